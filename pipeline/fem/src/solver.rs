//! Solvers: the numbers of one thread on a shared system.
//!
//! What a solver can do stands beside this file: `statics`, `adjoint`, `dynamics`.
//!
//! Stands on: `system`, `newton`. Never knows: another solver.

use crate::assembly::Elastic;
use crate::checks;
use crate::loads::DeadForces;
use crate::material::Lame;
use crate::newton::Newton;
use crate::potential::Potential;
use crate::refusal::SetupError;
use crate::search::Stall;
use crate::statics::Equilibrium;
use crate::system::{Parts, RegionProperties};
use si::{Pascal, Second};
use std::sync::Arc;

/// Solves one system; `Send`, so that each thread can have its own.
pub struct Solver {
    pub(crate) parts: Arc<Parts>,
    pub(crate) properties: Vec<RegionProperties>,
    pub(crate) elastic: Vec<Elastic>,
    pub(crate) dead: DeadForces,
    pub(crate) newton: Newton,
    /// The equilibrium whose exact tangent stands in `newton.values`.
    pub(crate) linearised: Option<Equilibrium>,
}

impl std::fmt::Debug for Solver {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("Solver").field("properties", &self.properties).finish_non_exhaustive()
    }
}

/// Why no solution was found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SolveError {
    /// A list of the wrong length.
    #[error(
        "{what} has {given} numbers\n  why: this system asks for {asked}\n  do:  give one pressure a chamber, and 3 numbers a node"
    )]
    Length {
        /// What was given.
        what: &'static str,
        /// How many numbers.
        given: usize,
        /// How many are needed.
        asked: usize,
    },
    /// An input that is NaN or infinite.
    #[error("{what} holds {value}\n  why: every number must be finite\n  do:  check where it comes from")]
    NotANumber {
        /// What was given.
        what: &'static str,
        /// The number.
        value: f64,
    },
    /// A setting that cannot be followed.
    #[error("{what} is {value:e}\n  why: it must be {range}\n  do:  change the setting")]
    Setting {
        /// Which setting.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Its range.
        range: &'static str,
    },
    /// No equilibrium was found beyond part of the load.
    #[error("no equilibrium is found beyond {:.1} % of the load (largest pressure {pressure:.4e} Pa)\n  why: {stall}, in load steps of {:.2} %\n  do:  look at the last converged state; give a smaller load, a stiffer material or a finer mesh", 100.0 * .reached, 100.0 * .stride)]
    NoEquilibrium {
        /// Part of the load that was reached, 0 to 1.
        reached: f64,
        /// Load step that failed, as a part.
        stride: f64,
        /// Largest pressure asked for, Pa.
        pressure: Pascal,
        /// What went wrong in it.
        stall: Stall,
        /// The equilibrium at `reached`, converged to 1e-5 of the body's size; none when not even a first step was.
        last_converged: Option<Box<Equilibrium>>,
    },
    /// A tangent that is not positive definite.
    #[error(
        "the equilibrium is not stable\n  why: its tangent is not positive definite\n  do:  pass the equilibrium that this solver found with these very properties"
    )]
    NotStable,
    /// No time step was found.
    #[error(
        "no motion is found beyond {time:.6} s\n  why: {stall}, in a step of {step:.3e} s\n  do:  take a smaller time step or smoother pressures"
    )]
    NoMotion {
        /// The last time that was reached, s.
        time: Second,
        /// The time step, s.
        step: Second,
        /// What went wrong.
        stall: Stall,
    },
}

impl SolveError {
    /// The last equilibrium before the failure, when there is one.
    pub fn last_converged(&self) -> Option<&Equilibrium> {
        match self {
            Self::NoEquilibrium { last_converged, .. } => last_converged.as_deref(),
            _ => None,
        }
    }
}

impl Solver {
    pub(crate) fn new(parts: Arc<Parts>) -> Self {
        let properties = parts.regions.clone();
        let elastic = properties
            .iter()
            .map(|is| Elastic { material: is.material, lame: Lame::of(is.youngs_modulus, is.poissons_ratio) })
            .collect();
        let newton = Newton::new(&parts);
        Self { parts, properties, elastic, dead: DeadForces::default(), newton, linearised: None }
    }

    /// Gives `region` another E (Pa) and ν from here on; the factor's structure and its last numbers are kept.
    ///
    /// # Errors
    /// [`SetupError`] when there is no such region or the constants are out of range; nothing is then changed.
    pub fn set_elastic(
        &mut self,
        region: usize,
        youngs_modulus: Pascal,
        poissons_ratio: f64,
    ) -> Result<(), SetupError> {
        let count = self.properties.len();
        if region >= count {
            return Err(SetupError::NoSuch { part: "region", index: region, count });
        }
        checks::elastic(region, youngs_modulus, poissons_ratio)?;
        self.properties[region].youngs_modulus = youngs_modulus;
        self.properties[region].poissons_ratio = poissons_ratio;
        self.elastic[region].lame = Lame::of(youngs_modulus, poissons_ratio);
        self.linearised = None;
        Ok(())
    }

    /// Pushes with dead forces (3 a node, N) from here on, beside all pressures; an empty list takes them away.
    ///
    /// # Errors
    /// [`SolveError`] when the list is neither empty nor 3 a node, or holds a number that is not finite.
    pub fn set_forces(&mut self, forces: &[f64]) -> Result<(), SolveError> {
        if !forces.is_empty() {
            self.check_field("a list of forces", forces)?;
        }
        self.dead.forces = forces.to_vec();
        self.linearised = None;
        Ok(())
    }

    /// What the regions are made of now.
    pub fn properties(&self) -> &[RegionProperties] {
        &self.properties
    }

    pub(crate) fn check_field(&self, what: &'static str, values: &[f64]) -> Result<(), SolveError> {
        check(what, values, 3 * self.parts.mesh.nodes.len())
    }

    pub(crate) fn check_pressures(&self, pressures: &[Pascal]) -> Result<(), SolveError> {
        check("a list of pressures", pressures, self.parts.chambers.len())
    }
}

/// The potential at rest under `pressures` and `dead_strength` of the dead forces.
pub(crate) fn at_rest<'a>(
    parts: &'a Parts,
    elastic: &'a [Elastic],
    dead: &'a DeadForces,
    pressures: &'a [Pascal],
    dead_strength: f64,
) -> Potential<'a> {
    Potential { parts, elastic, stiffening: 1.0, pressures, dead, dead_strength, inertia: None }
}

fn check(what: &'static str, values: &[f64], asked: usize) -> Result<(), SolveError> {
    if values.len() != asked {
        return Err(SolveError::Length { what, given: values.len(), asked });
    }
    match values.iter().find(|value| !value.is_finite()) {
        Some(&value) => Err(SolveError::NotANumber { what, value }),
        None => Ok(()),
    }
}
