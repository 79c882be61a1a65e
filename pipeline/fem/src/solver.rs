//! Solvers: the numbers of one thread on a shared system.
//!
//! What a solver can do stands beside this file: `statics`, `adjoint`, `dynamics`.
//!
//! Stands on: `system`, `newton`. Never knows: another solver.

use crate::checks;
use crate::gas::Gas;
use crate::given::Given;
use crate::mass::Mass;
use crate::material::Lame;
use crate::newton::Newton;
use crate::refusal::SetupError;
use crate::search::Stall;
use crate::statics::Equilibrium;
use crate::system::{Parts, RegionProperties};
use si::{KilogramPerCubicMetre, MetrePerSecondSquared, Pascal, Second};
use std::sync::Arc;

/// Solves one system; `Send`, so that each thread can have its own.
pub struct Solver {
    pub(crate) parts: Arc<Parts>,
    pub(crate) given: Given,
    pub(crate) newton: Newton,
    /// The equilibrium whose exact tangent stands in `newton.values`.
    pub(crate) linearised: Option<Equilibrium>,
}

impl std::fmt::Debug for Solver {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.debug_struct("Solver").field("properties", &self.given.properties).finish_non_exhaustive()
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
        let (given, newton) = (Given::new(&parts), Newton::new(&parts));
        Self { parts, given, newton, linearised: None }
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
        self.check_region(region)?;
        checks::elastic(region, youngs_modulus, poissons_ratio)?;
        self.given.properties[region].youngs_modulus = youngs_modulus;
        self.given.properties[region].poissons_ratio = poissons_ratio;
        self.given.elastic[region].lame = Lame::of(youngs_modulus, poissons_ratio);
        self.linearised = None;
        Ok(())
    }

    /// Gives `region` another density from here on.
    ///
    /// # Errors
    /// As [`Solver::set_elastic`].
    pub fn set_density(&mut self, region: usize, density: KilogramPerCubicMetre) -> Result<(), SetupError> {
        self.check_region(region)?;
        checks::density(region, density)?;
        self.given.properties[region].density = density;
        let densities: Vec<f64> = self.given.properties.iter().map(|region| region.density).collect();
        let Parts { mesh, pattern, places, overlaps, options, .. } = &*self.parts;
        self.given.mass = Arc::new(Mass::new(mesh, pattern, places, overlaps, &densities, &options.masses));
        self.given.gather_dead();
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
        self.given.forces = forces.to_vec();
        self.given.gather_dead();
        self.linearised = None;
        Ok(())
    }

    /// Lets `gravity` pull at the body and at what is attached, from here on.
    ///
    /// # Errors
    /// [`SolveError`] when a component is not finite.
    pub fn set_gravity(&mut self, gravity: [MetrePerSecondSquared; 3]) -> Result<(), SolveError> {
        check("gravity", &gravity, 3)?;
        self.given.gravity = gravity;
        self.given.gather_dead();
        self.linearised = None;
        Ok(())
    }

    /// Seals `chamber` in surroundings of this absolute pressure, or opens it again (`None`).
    ///
    /// The pressure that is given for a sealed chamber is the gauge pressure of its gas at rest volume; from there it
    /// follows (p + pₐ) V₀ = (g + pₐ) V, see [`Solver::chamber_pressure`].
    ///
    /// # Errors
    /// [`SetupError`] when there is no such chamber, or the ambient pressure is not positive.
    pub fn set_sealed(&mut self, chamber: usize, ambient: Option<Pascal>) -> Result<(), SetupError> {
        let count = self.given.ambient.len();
        if chamber >= count {
            return Err(SetupError::NoSuch { part: "chamber", index: chamber, count });
        }
        if let Some(ambient) = ambient.filter(|ambient| !(*ambient > 0.0 && *ambient < 1e8)) {
            return Err(SetupError::Ambient { chamber, ambient });
        }
        self.given.ambient[chamber] = ambient;
        self.linearised = None;
        Ok(())
    }

    /// Gauge pressure in `chamber` at `displacement` (3 a node, m) when `pressures` are given, Pa.
    ///
    /// # Errors
    /// [`SolveError`] when a list has the wrong length, or there is no such chamber.
    pub fn chamber_pressure(
        &self,
        chamber: usize,
        displacement: &[f64],
        pressures: &[Pascal],
    ) -> Result<Pascal, SolveError> {
        self.check_field("a displacement", displacement)?;
        self.check_pressures(pressures)?;
        if chamber >= pressures.len() {
            return Err(SolveError::Setting {
                what: "a chamber number",
                value: chamber as f64,
                range: "below their number",
            });
        }
        let (pressure, ambient) = (pressures[chamber], self.given.ambient[chamber]);
        Ok(Gas { chamber: &self.parts.chambers[chamber], pressure, ambient }.gauge_at(displacement))
    }

    /// What the regions are made of now.
    pub fn properties(&self) -> &[RegionProperties] {
        &self.given.properties
    }

    fn check_region(&self, region: usize) -> Result<(), SetupError> {
        let count = self.given.properties.len();
        if region < count { Ok(()) } else { Err(SetupError::NoSuch { part: "region", index: region, count }) }
    }

    pub(crate) fn check_field(&self, what: &'static str, values: &[f64]) -> Result<(), SolveError> {
        check(what, values, 3 * self.parts.mesh.nodes.len())
    }

    pub(crate) fn check_pressures(&self, pressures: &[Pascal]) -> Result<(), SolveError> {
        check("a list of pressures", pressures, self.parts.chambers.len())?;
        for (&pressure, ambient) in pressures.iter().zip(&self.given.ambient) {
            if ambient.is_some_and(|ambient| pressure <= -ambient) {
                let (what, range) = ("the pressure of a sealed chamber", "above a vacuum");
                return Err(SolveError::Setting { what, value: pressure, range });
            }
        }
        Ok(())
    }
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
