//! Searching moduli: the order in which points are simulated, the feasible lower bound, and the diagnostic that ends a search.

use diagnostics::{Diagnostic, Result};
use optimize::{Bounds, OptimiseError};

use crate::levels::LevelSolver;
use crate::model::{BODY, Elastic};

/// Least range of the logarithm of the body's modulus.
const LEAST_RANGE: f64 = 0.1;

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

/// Logarithm, over the nominal value, of the lowest modulus of the body with an equilibrium at the highest pressure of each chamber; the
/// lower bound of the search where that has one. `solver` then knows the equilibria with `elastic` on the way.
///
/// Below it walls lose stability and the films cannot be simulated. The other solids are softened with the body: a shape then follows from
/// pressure over modulus alone, and one path of rising pressure shows all of these bodies.
///
/// # Errors
/// As [`LevelSolver::follow_paths`].
pub fn feasible_lower_bound(solver: &mut LevelSolver, elastic: &Elastic, bounds: &Bounds) -> Result<f64> {
    let (low, high) = (bounds.low[0], bounds.high[0]);
    let here = (elastic.youngs_moduli[BODY] / solver.model().nominal.youngs_moduli[BODY]).ln();
    let reached = solver.follow_paths(elastic, (here - low).exp())?;
    let lowest = here - reached.ln();
    // without an equilibrium in the whole range, the first evaluation names the level that has none
    Ok(if lowest < high { lowest.clamp(low, (high - LEAST_RANGE).max(low)) } else { low })
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
