//! Exact solves with the tangent of a potential, by the last factor where that is near enough.
//!
//! The factor that Newton left is one step off the solution, so conjugate gradients on the exact tangent need two or
//! three iterations with it. When they need many, the exact tangent is factorised.
//!
//! Stands on: `newton`, `krylov`, `potential`. Never knows: what is solved for.

use crate::algebra::bordered::Bordered;
use crate::algebra::krylov::conjugate_gradients;
use crate::algebra::vectors::dot;
use crate::descent::newton::Newton;
use crate::descent::potential::Potential;

/// How exact, and when another factor is cheaper.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Demand {
    /// ‖Kx − b‖ / ‖b‖
    pub tolerance: f64,
    /// Iterations after which a factor of the exact tangent is made.
    pub patience: usize,
}

impl Newton {
    /// Puts the exact tangent of `on` at `u` (3 a node, m) in place, and turns the last factor to it.
    pub fn linearise(&mut self, on: &Potential, u: &[f64]) {
        on.stiffness(u, &mut self.values);
        self.complete(on, u);
    }

    /// The second half of `linearise`, when `values` hold the elastic part of the tangent alone.
    pub fn complete(&mut self, on: &Potential, u: &[f64]) {
        on.add_other_curvature(u, &mut self.values);
        self.full = Bordered::new(on.full_blocks(u));
        self.turn_to(on, u);
    }

    /// K⁻¹ b with the tangent in place, both in elimination order, and the iterations that it took; nothing where K is
    /// not positive definite.
    pub fn solve_exactly(&mut self, on: &Potential, u: &[f64], b: &[f64], demand: Demand) -> Option<(Vec<f64>, usize)> {
        let (goal, patience) = (demand.tolerance * dot(b, b).sqrt(), demand.patience);
        if b.iter().all(|&entry| entry == 0.0) {
            return Some((b.to_vec(), 0));
        }
        if let Some(found) = self.is_ready().then(|| self.iterate(on, b, goal, patience)).flatten() {
            return Some(found);
        }
        self.factorise(on, u, b).ok()?;
        // rounding may keep the residual of a stiff sheet above the goal: the factor's own answer is then the best
        self.iterate(on, b, goal, patience).or_else(|| {
            let mut x = b.to_vec();
            self.solve(on.parts, &mut x);
            Some((x, patience))
        })
    }

    /// K⁻¹ b by conjugate gradients with the tangent in place and the last factor.
    pub fn iterate(&mut self, on: &Potential, b: &[f64], goal: f64, patience: usize) -> Option<(Vec<f64>, usize)> {
        let (values, full) = (std::mem::take(&mut self.values), std::mem::take(&mut self.full));
        let image = |x: &[f64], y: &mut [f64]| {
            on.parts.pattern.multiply(&values, x, y);
            full.multiply(x, y);
        };
        let found = conjugate_gradients(image, |x| self.solve(on.parts, x), b, goal, patience);
        (self.values, self.full) = (values, full);
        found
    }
}
