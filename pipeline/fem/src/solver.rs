//! Solvers: the numbers of one thread on a shared system.
//!
//! What a solver can do stands beside this file: `statics`, `motion`, `linear`.
//!
//! Stands on: `parts`, `given`, `newton`. Never knows: another solver.

use crate::body::mass::Mass;
use crate::checks;
use crate::descent::newton::Newton;
use crate::gas::Gas;
use crate::given::Given;
use crate::material::Lame;
use crate::parts::Parts;
use crate::refusal::SetupError;
use crate::region::RegionProperties;
use crate::stall::SolveError;
use crate::statics::equilibrium::Equilibrium;
use si::{KilogramPerCubicMetre, MetrePerSecondSquared, Pascal};
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
