//! Searching moduli: the order in which points are simulated, the feasible lower bound, and the diagnostic that ends a search.

use diagnostics::{Diagnostic, Result};
use optimize::{Bounds, OptimiseError};

use crate::levels::LevelSolver;
use crate::model::{BODY, Elastic};

/// Least range of the logarithm of the body's modulus.
// A feasible bound close to the highest plausible modulus would leave the search next to no range, or none, which is
// refused.
const LEAST_RANGE: f64 = 0.1;

/// Part of a path that its end may seem to miss.
// A start that counts as missed by a rounding error would be moved by a quarter of the range.
const ROUNDING: f64 = 1e-9;

/// Why a search stops: a diagnostic passed through an optimiser.
pub struct Interrupted(pub Diagnostic);

impl From<OptimiseError> for Interrupted {
    fn from(error: OptimiseError) -> Self {
        Self(Diagnostic::from(error))
    }
}

/// An order of `points` in which each is the nearest of those left to any before it or to one of `known`, so that each starts near a known
/// equilibrium: that of Prim's minimum spanning tree.
pub(crate) fn spanning_order(points: &[Vec<f64>], known: &[Vec<f64>]) -> Vec<usize> {
    let distance = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum() };
    let nearest = |point: &[f64]| known.iter().map(|k| distance(point, k)).fold(f64::INFINITY, f64::min);
    let mut remaining: Vec<(usize, f64)> = points.iter().map(|point| nearest(point)).enumerate().collect();
    let mut order = Vec::with_capacity(points.len());
    while let Some(next) = (0..remaining.len()).min_by(|&a, &b| remaining[a].1.total_cmp(&remaining[b].1)) {
        let (selected, _) = remaining.remove(next);
        remaining.iter_mut().for_each(|(point, away)| *away = away.min(distance(&points[*point], &points[selected])));
        order.push(selected);
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
/// As `LevelSolver::follow_paths`.
pub fn feasible_lower_bound(solver: &mut LevelSolver, elastic: &Elastic, bounds: &Bounds) -> Result<f64> {
    lower_bound_within(solver, elastic, bounds, (log_modulus(solver, elastic) - bounds.low[0]).exp())
}

/// The lower bound of a search that begins with `elastic`: that of `bounds` where this body has an equilibrium at every level, else that of the
/// bodies that have.
///
/// # Errors
/// As `LevelSolver::follow_paths`.
// A step to a body without equilibrium is halved. To know the softest body that has one takes paths to two or three times the pressures of the levels,
// through contact of walls, of which a search from a plausible start sees nothing.
pub(crate) fn feasible_start_bound(solver: &mut LevelSolver, elastic: &Elastic, bounds: &Bounds) -> Result<f64> {
    lower_bound_within(solver, elastic, bounds, 1.0)
}

/// Of paths to `reach` times the pressure of the levels; the lower bound of `bounds` where all of them end there.
fn lower_bound_within(solver: &mut LevelSolver, elastic: &Elastic, bounds: &Bounds, reach: f64) -> Result<f64> {
    let reached = solver.follow_paths(elastic, reach)? / reach;
    let lowest = log_modulus(solver, elastic) - (reach * reached).ln();
    let bound = if reached < 1.0 - ROUNDING { lowest } else { bounds.low[0] };
    Ok(bound_in_range(bound, [bounds.low[0], bounds.high[0]]))
}

/// A lower bound within a range; without an equilibrium in the whole range, the first evaluation names the level that has none.
fn bound_in_range(bound: f64, [low, high]: [f64; 2]) -> f64 {
    if bound < high { bound.clamp(low, (high - LEAST_RANGE).max(low)) } else { low }
}

/// Of the body, over the nominal one.
fn log_modulus(solver: &LevelSolver, elastic: &Elastic) -> f64 {
    (elastic.youngs_moduli[BODY] / solver.model().nominal.youngs_moduli[BODY]).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bound_leaves_a_range_or_none_at_all() {
        assert_eq!(bound_in_range(0.3, [-1.0, 1.0]), 0.3);
        assert_eq!(bound_in_range(-2.0, [-1.0, 1.0]), -1.0);
        assert_eq!(bound_in_range(0.98, [-1.0, 1.0]), 1.0 - LEAST_RANGE);
        assert_eq!(bound_in_range(1.5, [-1.0, 1.0]), -1.0);
    }

    #[test]
    fn the_order_spreads_over_a_grid_from_what_is_known() {
        let grid: Vec<Vec<f64>> = (0..5).flat_map(|i| (0..5).map(move |j| vec![f64::from(i), f64::from(j)])).collect();
        let order = spanning_order(&grid, &[vec![2.2, 3.1], vec![-9.0, -9.0]]);
        let distance = |a: usize, b: usize| (0..2).map(|k| (grid[a][k] - grid[b][k]).powi(2)).sum::<f64>();
        let beside = |i: usize| order[..i].iter().any(|&before| distance(before, order[i]) <= 1.0);
        assert!(order[0] == 13 && order.len() == 25 && (1..25).all(beside), "{order:?}");
        assert_eq!(spanning_order(&grid[..3], &[]), [0, 1, 2]);
    }
}
