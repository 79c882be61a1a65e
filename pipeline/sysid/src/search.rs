//! Searching moduli: the order in which points are simulated, the feasible lower bound, and the diagnostic that ends a search.

use diagnostics::Diagnostic;
use fem::StaticSettings;
use optimize::{Bounds, OptimiseError};

use crate::levels::{Derivatives, LevelSolver, PressureLevel};
use crate::model::{BODY, Model};

/// Step from stiff to soft, in the logarithm of the body's modulus.
const SOFTER: f64 = 0.1;

/// Why a search stops: a diagnostic passed through an optimiser.
pub struct Interrupted(pub Diagnostic);

impl From<OptimiseError> for Interrupted {
    fn from(error: OptimiseError) -> Self {
        Self(Diagnostic::from(error))
    }
}

/// An order of points in which each is the nearest of those left to the one before, so that each starts near a known equilibrium.
pub fn nearest_neighbour_order(points: &[Vec<f64>]) -> Vec<usize> {
    let distance = |a: usize, b: usize| -> f64 { points[a].iter().zip(&points[b]).map(|(x, y)| (x - y).powi(2)).sum() };
    let mut left: Vec<usize> = (0..points.len()).rev().collect();
    let mut order: Vec<usize> = left.pop().into_iter().collect();
    while let Some(&here) = order.last() {
        let Some(next) = (0..left.len()).min_by(|&a, &b| distance(here, left[a]).total_cmp(&distance(here, left[b])))
        else {
            break;
        };
        order.push(left.remove(next));
    }
    order
}

/// Logarithm, over the nominal value, of the lowest modulus of the body with an equilibrium at the highest pressure of each film, with
/// the other solids nominal; the lower bound of the search where that has one.
///
/// Below it walls lose stability and the films cannot be simulated.
pub fn feasible_lower_bound(model: &Model, levels: &[PressureLevel], bounds: &Bounds) -> f64 {
    let settings = StaticSettings { tolerance: 1e-4, max_halvings: 0, max_iterations: 12, ..StaticSettings::default() };
    let top = levels.iter().map(PressureLevel::top).fold(0.0, f64::max);
    let highest: Vec<PressureLevel> = levels.iter().filter(|r| r.top() > 0.98 * top).cloned().collect();
    let count = highest.len();
    let mut solver = LevelSolver::new(model.clone(), highest, settings, count);
    let has_equilibrium = |solver: &mut LevelSolver, at: f64| {
        let mut elastic = model.nominal.clone();
        elastic.youngs_moduli[BODY] *= at.exp();
        solver.solve(&elastic, Derivatives::None).is_ok()
    };
    let (low, high) = (bounds.low[0], bounds.high[0]);
    // The bound is approached from the stiff side with warm starts: a failed equilibrium is the most expensive evaluation, and this
    // order meets only one.
    let steps = ((high - low) / SOFTER).ceil() as usize;
    if !has_equilibrium(&mut solver, high) {
        return low;
    }
    let lost = (1..=steps).find(|&k| !has_equilibrium(&mut solver, (high - SOFTER * k as f64).max(low)));
    lost.map_or(low, |k| (high - SOFTER * (k as f64 - 1.0)).min(high - SOFTER))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_in_the_order_are_neighbours_in_the_grid() {
        let grid: Vec<Vec<f64>> = (0..5).flat_map(|i| (0..5).map(move |j| vec![f64::from(i), f64::from(j)])).collect();
        let order = nearest_neighbour_order(&grid);
        let distance = |w: &[usize]| (0..2).map(|k| (grid[w[0]][k] - grid[w[1]][k]).powi(2)).sum::<f64>();
        assert!(order.windows(2).all(|w| distance(w) <= 1.0), "{order:?}");
    }
}
