//! The discretisation error of identified parameters, estimated on a finer mesh.
//!
//! On a mesh with finer edges the displacements at the same parameters are closer to those of the continuum; the difference is an estimate of
//! the error of the mesh that identifies [roache1997]. The parameters follow that error as far as a change of theirs looks like it. It is
//! the same in every film, so more films do not reduce it.

use fem::StaticSettings;
use optimize::Residuals;
use si::Point2;

use crate::levels::PressureLevel;
use crate::misfit::Misfit;
use crate::model::{Elastic, Model};
use diagnostics::{Diagnostic, Result};

/// By how much displacements on the mesh of `found` (levels × markers, m) differ from those on the mesh of `finer` at the same parameters.
///
/// # Errors
/// A [`Diagnostic`] when the finer mesh has no equilibrium at a lowest pressure.
// The lowest level of each chamber alone is solved for, and its error scaled with the displacement for the others: a third of the cost of
// the whole search would be spent on the highest.
pub fn error(
    levels: &[PressureLevel],
    found: &[Vec<Point2>],
    finer: &Model,
    (elastic, settings): (&Elastic, &StaticSettings),
) -> Result<Vec<Vec<Point2>>> {
    let lowest = lowest(levels);
    let mut solver = finer.system.solver();
    elastic.apply(&mut solver)?;
    let mut solved = |low: &usize| -> Result<Vec<Point2>> {
        let equilibrium = solver.equilibrium(&levels[*low].pressures, None, settings)?;
        Ok(finer.markers.iter().map(|spot| Model::in_plane(spot, &equilibrium.displacement)).collect())
    };
    let solved: Vec<Vec<Point2>> = lowest.iter().map(&mut solved).collect::<Result<_>>()?;
    let of = |level: usize| {
        let place = lowest.iter().position(|&low| levels[low].filled() == levels[level].filled());
        let (low, finer) = place.map_or((level, &found[level]), |k| (lowest[k], &solved[k]));
        let pairs = found[low].iter().zip(finer).zip(&found[level]);
        pairs.map(|((coarse, fine), here)| scaled(*coarse, *fine, size(*here))).collect()
    };
    Ok((0..levels.len()).map(of).collect())
}

/// The level of the lowest pressure of each filled chamber.
fn lowest(levels: &[PressureLevel]) -> Vec<usize> {
    let mut lowest: Vec<usize> = Vec::new();
    for (number, level) in levels.iter().enumerate() {
        match lowest.iter_mut().find(|low| levels[**low].filled() == level.filled()) {
            Some(low) if levels[*low].top() > level.top() => *low = number,
            Some(_) => {}
            None => lowest.push(number),
        }
    }
    lowest
}

fn size(of: Point2) -> f64 {
    of[0].hypot(of[1])
}

/// The difference of two displacements, in proportion where the first would be of this size.
fn scaled(coarse: Point2, fine: Point2, to: f64) -> Point2 {
    let by = to / size(coarse).max(f64::MIN_POSITIVE);
    [0, 1].map(|k| by * (coarse[k] - fine[k]))
}

/// By how much an `error` of the simulated displacements (levels × markers, m) shifts the identified parameters; `white` are the whitened
/// residuals there.
///
/// # Errors
/// A [`Diagnostic`] when the error is that of other levels, or the residuals do not determine the parameters.
pub fn shift(misfit: &Misfit, (white, parameters): (&Residuals, usize), error: &[Vec<Point2>]) -> Result<Vec<f64>> {
    let values: Vec<f64> = error.iter().flatten().flatten().copied().collect();
    let jacobian = vec![0.0; values.len() * parameters];
    let mut error = misfit.white(&Residuals { values, jacobian }, parameters)?.values;
    // a prior of the parameters knows nothing of a mesh
    error.resize(white.values.len(), 0.0);
    white.response(&error, parameters).map_err(Diagnostic::from)
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
        let white = misfit.white(&Residuals { values, jacobian }, 1).unwrap();
        let error: Vec<Vec<Point2>> =
            misfit.levels.iter().map(|l| l.measured.iter().map(|u| [0.0, -0.01 * u[1]]).collect()).collect();
        let found = shift(&misfit, (&white, 1), &error).unwrap();
        assert!((found[0] + 0.01).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn an_error_is_scaled_with_the_displacement() {
        let [x, y] = scaled([0.0, 2e-3], [2e-4, 2.2e-3], 1e-3);
        assert!((x + 1e-4).abs() < 1e-15 && (y + 1e-4).abs() < 1e-15);
        assert_eq!(lowest(&levels()), [0]);
    }
}
