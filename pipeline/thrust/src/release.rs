//! Added mass and normal drag from the free vibration of a tail that is released in water.
//!
//! Gauss-Newton over both logarithms, with differences for derivatives: a simulation of a release takes a fraction of a second. What the
//! model leaves of the film is no white noise but a smooth discrepancy; its size and its correlation time are those of the residuals, and
//! both widen the deviations. So do the silicone's own uncertainties: a vibration that the silicone damps less needs more drag.

use hydro::Coefficients;
use optimize::optimisers::gauss_newton::{GaussNewton, Settings as Newton};
use optimize::posterior::integrated_correlation;
use optimize::{Bounds, Evaluation, Needs, Optimiser, Problem, Residuals};

use diagnostics::{Diagnostic, Result};
use sysid::Interrupted;

/// How added mass and drag are sought.
#[derive(Debug, Clone, PartialEq)]
pub struct ReleaseSettings {
    /// Least and greatest ratio of elongated-body theory's added mass.
    pub added_mass_ratio: [f64; 2],
    /// Least and greatest coefficient of normal drag.
    pub normal_drag_coefficient: [f64; 2],
    /// Iterations at most, three simulations each.
    pub iterations: usize,
    /// Tolerance of a step: converged when no logarithm changes by more.
    pub step_tolerance: f64,
}

/// The residuals, in units of their standard deviation, at each of several points: x of the observed
/// marker, frame after frame, before y.
pub type Evaluated<'a> = dyn FnMut(&[Coefficients]) -> Result<Vec<Vec<f64>>> + 'a;

/// The best coefficients.
#[derive(Debug, Clone, PartialEq)]
pub struct Release {
    /// Added mass ratio and normal drag coefficient, no unit.
    pub by: Coefficients,
    best: Residuals,
}

/// Names of the parameters in messages.
const NAMES: [&str; 2] = ["added mass", "drag"];
/// Step of the finite difference, in the logarithm.
const NUDGE: f64 = 0.02;

impl ReleaseSettings {
    /// The coefficients whose residuals are least.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a simulation fails or the bounds are no interval.
    pub fn identify(&self, evaluated: &mut Evaluated) -> Result<Release> {
        let ranges = [self.added_mass_ratio, self.normal_drag_coefficient];
        let bounds_at = |k: usize| ranges.map(|range| range[k].ln()).to_vec();
        // the middle of both ranges, in logarithms
        let start = ranges.map(|[low, high]| 0.5 * (low * high).ln()).to_vec();
        let search = Problem::new(&NAMES, start, Bounds { low: bounds_at(0), high: bounds_at(1) })?;
        let newton = Newton { step_tolerance: self.step_tolerance, iterations: self.iterations, ..Newton::default() };
        let mut optimiser = GaussNewton::new(&search, &newton)?;
        let mut problem = |batch: &[Vec<f64>], _: Needs| -> Result<Vec<Evaluation>, Interrupted> {
            batch.iter().map(|point| evaluated_point(point, evaluated).map_err(Interrupted)).collect()
        };
        let log = optimize::minimise(&mut optimiser as &mut dyn Optimiser, &mut problem).map_err(|stop| stop.0)?;
        let best = log.best.residuals.ok_or_else(|| {
            let action = "report it with the recordings";
            Diagnostic::new("the best simulation left no residuals", "it was evaluated without them", action)
        })?;
        Ok(Release { by: coefficients_at(&log.best.at), best })
    }
}

fn evaluated_point(point: &[f64], evaluated: &mut Evaluated) -> Result<Evaluation> {
    let perturbed = |k: usize| -> Vec<f64> { (0..2).map(|i| point[i] + if i == k { NUDGE } else { 0.0 }).collect() };
    let mut residual_sets =
        evaluated(&[coefficients_at(point), coefficients_at(&perturbed(0)), coefficients_at(&perturbed(1))])?
            .into_iter();
    let values = residual_sets.next().unwrap_or_default();
    let columns: Vec<Vec<f64>> = residual_sets.collect();
    let slope = |i: usize| columns.iter().map(|c| (c[i] - values[i]) / NUDGE).collect::<Vec<f64>>();
    let jacobian = (0..values.len()).flat_map(slope).collect();
    let residuals = Residuals { values, jacobian };
    let loss = residuals.half_sum_of_squares();
    Ok(Evaluation { loss, at: point.to_vec(), gradient: None, residuals: Some(residuals) })
}

fn coefficients_at(point: &[f64]) -> Coefficients {
    Coefficients { added: point[0].exp(), drag: point[1].exp() }
}

impl Release {
    /// The residuals at the best coefficients.
    pub fn residuals(&self) -> &[f64] {
        &self.best.values
    }

    /// Standard deviations of both coefficients: by the residuals' own scatter, which some hundred frames determine, and by `others`, the
    /// residuals at the best coefficients with one of the other quantities of the model one standard deviation off, each independent of
    /// the next.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the residuals do not determine both.
    pub fn sigma(&self, others: &[Vec<f64>]) -> Result<Coefficients> {
        let covariance = self.best.covariance(NAMES.len())?;
        let widened = discrepancy_factor(&self.best);
        let mut variance = [0, 1].map(|k| (widened * covariance.sigma(k)).powi(2));
        for perturbed in others {
            let change: Vec<f64> = perturbed
                .iter()
                .zip(&self.best.values)
                .map(|(perturbed_value, value)| perturbed_value - value)
                .collect();
            let response = self.best.parameter_response(&change, NAMES.len())?;
            (0..2).for_each(|k| variance[k] += response[k].powi(2));
        }
        let [added, drag] = variance.map(f64::sqrt);
        Ok(Coefficients { added: added * self.by.added, drag: drag * self.by.drag })
    }
}

/// By how much the deviations of the parameters exceed those of independent residuals that have their own scatter
/// ([`Residuals::posterior`]): the root of the number of residuals that count as one.
fn discrepancy_factor(residuals: &Residuals) -> f64 {
    let axes = residuals.values.chunks_exact((residuals.values.len() / 2).max(1));
    (axes.map(integrated_correlation).sum::<f64>() / 2.0).sqrt()
}

/// Root of the mean square of a path's distances, x before y, in their unit.
pub fn rms(distances: &[f64]) -> f64 {
    (distances.iter().map(|v| v * v).sum::<f64>() / (distances.len() / 2).max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> ReleaseSettings {
        let (added_mass_ratio, normal_drag_coefficient) = ([0.3, 2.0], [0.5, 50.0]);
        ReleaseSettings { added_mass_ratio, normal_drag_coefficient, iterations: 12, step_tolerance: 1e-4 }
    }

    /// A vibration that drag damps and added mass slows, with further damping.
    fn path(by: &Coefficients, damping: f64) -> Vec<f64> {
        let at = |i: u32| {
            let (t, decay) = (f64::from(i), 1.0 / (8.0 * by.drag.sqrt()) + damping);
            1e5 * (-t * decay).exp() * (t / (5.0 + 4.0 * by.added)).cos()
        };
        (0..60).map(at).collect()
    }

    fn off(by: &Coefficients, damping: f64) -> Vec<f64> {
        let hidden = path(&Coefficients { added: 0.7, drag: 12.0 }, 0.0);
        path(by, damping).iter().zip(&hidden).map(|(x, y)| x - y).collect()
    }

    #[test]
    fn the_coefficients_of_a_simulated_path_are_identified() {
        let found = settings().identify(&mut |at| Ok(at.iter().map(|by| off(by, 0.0)).collect())).unwrap().by;
        assert!((found.added - 0.7).abs() < 1e-3 && (found.drag - 12.0).abs() < 2e-2, "{found:?}");
    }

    #[test]
    fn the_uncertainty_of_another_damping_is_that_of_the_drag_it_would_give() {
        let at =
            |damping: f64| settings().identify(&mut |at| Ok(at.iter().map(|by| off(by, damping)).collect())).unwrap();
        let found = at(0.0);
        let (alone, with) = (found.sigma(&[]).unwrap(), found.sigma(&[off(&found.by, 1e-4)]).unwrap());
        let shift = (at(1e-4).by.drag - found.by.drag).abs();
        assert!(alone.drag < 0.1 * with.drag && (with.drag / shift - 1.0).abs() < 0.05, "{with:?} {shift}");
    }

    #[test]
    fn deviations_are_those_of_the_scatter_however_coarsely_a_frame_is_weighed() {
        let noisy = |by: &Coefficients, weight: f64| -> Vec<f64> {
            let error = |i: usize| 20.0 * (1.7 * i as f64).sin();
            off(by, 0.0).iter().enumerate().map(|(i, residual)| weight * (residual + error(i))).collect()
        };
        let sigma = |weight: f64| {
            let found = settings().identify(&mut |at| Ok(at.iter().map(|by| noisy(by, weight)).collect())).unwrap();
            found.sigma(&[]).unwrap().drag
        };
        let [fine, coarse] = [1.0, 1e-3].map(sigma);
        assert!((coarse / fine - 1.0).abs() < 1e-2, "{coarse:e} {fine:e}");
    }
}
