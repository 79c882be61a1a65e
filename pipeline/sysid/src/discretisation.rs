//! The discretisation error of identified parameters, estimated on a finer mesh.
//!
//! On a mesh with finer edges the displacements at the same parameters are closer to those of the continuum; the difference is an estimate of
//! the error of the mesh that identifies \[roache1997\]. The parameters follow that error as far as a change of theirs looks like it. It is
//! the same in every film, so more films do not reduce it.

use fem::Mesh;
use optimize::Residuals;
use si::{Metre, Point2};

use crate::levels::{Derivatives, LevelSolver, SimulatedLevel, SimulatedMesh};
use crate::misfit::Misfit;
use crate::model::Elastic;
use diagnostics::{Diagnostic, Result};

/// By how much the markers' displacements of the levels that were simulated on a `coarse` mesh differ from those at the same parameters on the
/// mesh of `finer`, which solves the same levels: levels × markers, m.
///
/// # Errors
/// A [`Diagnostic`] when the finer mesh has no equilibrium at a level.
// Every level is solved for: the buckle of a thin wall amplifies the error, which is 0.4 % of the angle below it and 2 % beyond, so that an
// error of the lowest level, scaled with the displacement, says little of the others.
pub fn mesh_error(
    finer: &mut LevelSolver,
    elastic: &Elastic,
    coarse: (&Mesh, &[SimulatedLevel]),
) -> Result<Vec<Vec<Point2>>> {
    let (mesh, simulated) = coarse;
    let levels = finer.levels().to_vec();
    finer.add_guesses_of_mesh(&SimulatedMesh { mesh, elastic, levels: &levels, simulated });
    let finer = finer.solve(elastic, Derivatives::None)?;
    let difference = |(coarse, finer): (&Point2, &Point2)| [0, 1].map(|k| coarse[k] - finer[k]);
    // length: both have the levels of one misfit and the markers of one card
    let pairs = simulated.iter().zip(&finer);
    Ok(pairs.map(|(coarse, finer)| coarse.markers.iter().zip(&finer.markers).map(difference).collect()).collect())
}

/// What a finer mesh says about the one that identifies.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshError {
    /// By how much it shifts the logarithm of each identified parameter.
    pub shift: Vec<f64>,
    /// Largest difference of a marker's displacement at any level, m.
    pub largest: Metre,
}

impl MeshError {
    /// Of an `error` of the simulated displacements (levels × markers, m); see `parameter_shift`.
    ///
    /// # Errors
    /// As `parameter_shift`.
    pub fn new(misfit: &Misfit, residuals: (&Residuals, usize), error: &[Vec<Point2>]) -> Result<Self> {
        let largest = error.iter().flatten().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max);
        Ok(Self { shift: parameter_shift(misfit, residuals, error)?, largest })
    }
}

/// By how much an `error` of the simulated displacements (levels × markers, m) shifts the identified parameters; `white` are the whitened
/// residuals there.
///
/// # Errors
/// A [`Diagnostic`] when the error is that of other levels, or the residuals do not determine the parameters.
fn parameter_shift(
    misfit: &Misfit,
    (white, parameters): (&Residuals, usize),
    error: &[Vec<Point2>],
) -> Result<Vec<f64>> {
    let values: Vec<f64> = error.iter().flatten().flatten().copied().collect();
    let jacobian = vec![0.0; values.len() * parameters];
    let mut error = misfit.whiten_residuals(&Residuals { values, jacobian }, parameters)?.values;
    // a prior of the parameters knows nothing of a mesh
    error.resize(white.values.len(), 0.0);
    white.parameter_response(&error, parameters).map_err(Diagnostic::from)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::levels::PressureLevel;
    use crate::noise::NoiseModel;

    const NOISE: NoiseModel = NoiseModel { discrepancy_m: 1e-4, scale_sigma: 0.02 };

    /// Displacements of a beam under `pressure` whose flexibility is `by` times as large.
    fn moved(pressure: f64, by: f64) -> Vec<Point2> {
        (1..5).map(|m| [0.0, by * 1e-7 * pressure * f64::from(m * m)]).collect()
    }

    fn levels() -> Vec<PressureLevel> {
        let level = |pressure: f64| PressureLevel {
            pressures: vec![pressure],
            measured: moved(pressure, 1.0),
            covariance: vec![[1e-10, 0.0, 1e-10]; 4],
            shared: vec![[0.0; 3]; 4],
            rest: (1..5).map(|m| [0.02 * f64::from(m), 0.0]).collect(),
        };
        vec![level(1e4), level(2e4)]
    }

    #[test]
    fn a_mesh_that_is_too_stiff_lowers_the_modulus_by_its_error() {
        let misfit = Misfit::new(levels(), &[2], &NOISE, 0.1).unwrap();
        // one parameter, ln E: displacements go as 1/E
        let values = vec![0.0; 16];
        let jacobian = misfit.levels.iter().flat_map(|l| l.measured.iter().flatten().map(|u| -u)).collect();
        let white = misfit.whiten_residuals(&Residuals { values, jacobian }, 1).unwrap();
        let error: Vec<Vec<Point2>> =
            misfit.levels.iter().map(|l| l.measured.iter().map(|u| [0.0, -0.01 * u[1]]).collect()).collect();
        let found = parameter_shift(&misfit, (&white, 1), &error).unwrap();
        assert!((found[0] + 0.01).abs() < 1e-9, "{found:?}");
    }
}
