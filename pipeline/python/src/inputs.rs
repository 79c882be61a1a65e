//! What a solve depends on beside pressures: moduli, densities, forces and gravity, given in full for every solve, so
//! that no result depends on the solves before it.

use fem::Solver;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Reals, check_length, number_vector};
use crate::errors::input_error;

/// The inputs of one solve.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Inputs {
    /// By region, Pa.
    youngs_modulus: Vec<f64>,
    /// By region.
    poissons_ratio: Vec<f64>,
    /// By region, kg/m³.
    density: Vec<f64>,
    /// By element: its modulus over that of its region; empty: 1.
    factors: Vec<f64>,
    /// 3 entries per node, N; empty: none.
    forces: Vec<f64>,
    /// m/s².
    gravity: Vec<f64>,
}

impl Inputs {
    /// From the dictionary that the package's Python files make, for a body of so many regions.
    pub(crate) fn of(given: &Bound<'_, PyDict>, regions: usize) -> PyResult<Self> {
        let list = |key: &str| -> PyResult<Vec<f64>> {
            let absent = || input_error(format!("`{key}` is not given"), "a solve needs all of its inputs", "give it");
            let value = given.get_item(key)?.ok_or_else(absent)?;
            number_vector(key, &value.extract::<Reals<'_>>()?)
        };
        let by_region = |key: &str| -> PyResult<Vec<f64>> {
            let values = list(key)?;
            check_length(key, values.len(), regions).map(|()| values)
        };
        let (youngs_modulus, poissons_ratio) = (by_region("youngs_modulus")?, by_region("poissons_ratio")?);
        let (density, gravity) = (by_region("density")?, list("gravity")?);
        check_length("gravity", gravity.len(), 3)?;
        Ok(Self {
            youngs_modulus,
            poissons_ratio,
            density,
            factors: list("factors")?,
            forces: list("forces")?,
            gravity,
        })
    }

    /// These with other forces, 3 entries per node, N.
    pub(crate) fn with_forces(&self, forces: Vec<f64>) -> Self {
        Self { forces, ..self.clone() }
    }

    /// Whether gravity acts.
    pub(crate) fn is_heavy(&self) -> bool {
        self.gravity.iter().any(|part| *part != 0.0)
    }

    /// Sets what differs from the inputs `before`, which the solver has; what is equal leaves its factor and its
    /// linearised tangent in use.
    ///
    /// # Errors
    /// A diagnostic where one is out of range.
    pub(crate) fn set(&self, before: Option<&Self>, solver: &mut Solver) -> diagnostics::Result<()> {
        let differs = |of: fn(&Self) -> &Vec<f64>| before.is_none_or(|before| of(before) != of(self));
        for (region, (&modulus, &ratio)) in self.youngs_modulus.iter().zip(&self.poissons_ratio).enumerate() {
            let had = before.map(|before| (before.youngs_modulus[region], before.poissons_ratio[region]));
            if had != Some((modulus, ratio)) {
                solver.set_elastic(region, modulus, ratio)?;
            }
        }
        for (region, &density) in self.density.iter().enumerate() {
            if before.map(|before| before.density[region]) != Some(density) {
                solver.set_density(region, density)?;
            }
        }
        if differs(|of| &of.factors) {
            solver.set_element_factors(&self.factors)?;
        }
        if differs(|of| &of.forces) {
            solver.set_forces(&self.forces)?;
        }
        if differs(|of| &of.gravity) {
            solver.set_gravity([self.gravity[0], self.gravity[1], self.gravity[2]])?;
        }
        Ok(())
    }
}
