//! Gliding: a solution nearby, reached with the factor of the last one.
//!
//! Newton's directions on the tangent of the moment, by conjugate gradients that the old factor, turned with the body,
//! makes short. After a change of a few per cent that is cheaper than a factor; where it is not, it gives up at once.
//!
//! Stands on: `tangent`, `newton`, `potential`. Never knows: what has changed.

use crate::algebra::bordered::Bordered;
use crate::algebra::vectors::dot;
use crate::descent::newton::Newton;
use crate::descent::potential::{Curvature, Potential};
use crate::descent::search::{Found, Rule};

/// Directions at most: one that needs more had better make a factor.
const DIRECTIONS: usize = 8;
/// Iterations of one direction at most: a factor costs about so many.
const PATIENCE: usize = 24;
/// ‖Kx − g‖ / ‖g‖ of a direction: each direction leaves the square of the last one's step anyway.
const EXACT: f64 = 1e-3;

impl Newton {
    /// Moves `u` (3 a node, m) to a minimum of `on` without a new factor; nothing when that takes too long, and `u` is
    /// then as it was.
    pub fn glide(&mut self, on: &Potential, u: &mut [f64], rule: &Rule) -> Option<Found> {
        let mut at = u.to_vec();
        let mut before: Option<Vec<f64>> = None;
        let mut gradient = vec![0.0; u.len()];
        let mut last = f64::INFINITY;
        for iterations in 1..=DIRECTIONS {
            if !on.energy(&at, &mut gradient).value.is_finite() {
                return None;
            }
            let direction = self.glide_along(on, &at, before.as_deref(), &gradient)?;
            let size = direction.iter().fold(0.0, |most: f64, entry| most.max(entry.abs()));
            if size > 2.0 * last || !size.is_finite() {
                return None;
            }
            before = Some(at.clone());
            on.parts.pattern.spread(&direction, -1.0, &mut at);
            // the next one would be shorter by as much again, or by what conjugate gradients leave
            if size * (size / last).max(EXACT) <= 0.5 * rule.tolerance || size <= rule.tolerance {
                u.copy_from_slice(&at);
                return Some(Found { iterations, ..Found::default() });
            }
            last = size;
        }
        None
    }

    /// K⁻¹ g at `u`, in elimination order; `before` is where the last direction began.
    fn glide_along(&mut self, on: &Potential, u: &[f64], before: Option<&[f64]>, g: &[f64]) -> Option<Vec<f64>> {
        let kept = if before.is_some() { Curvature::Foreseen } else { Curvature::Exact };
        on.curvature(u, before.unwrap_or(&[]), kept, &mut self.values);
        self.full = Bordered::new(on.full_blocks(u));
        self.turn_to(on, u);
        let mut free = Vec::new();
        on.parts.pattern.gather(g, &mut free);
        let goal = EXACT * dot(&free, &free).sqrt();
        self.iterate(on, &free, goal, PATIENCE).map(|(direction, _)| direction)
    }
}
