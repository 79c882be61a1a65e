//! Accurate solves with the exact tangent of a potential, preconditioned by the last factor.
//!
//! The factor that Newton's method left is one step away from the solution, so PCG on the exact tangent converges in
//! two or three iterations. Where it needs many, the exact tangent is factorised.

use crate::newton::iteration::Newton;
use crate::newton::potential::Potential;
use sparse::{PcgOptions, RankOneUpdates, conjugate_gradients};

impl Newton {
    /// Assembles the exact tangent of `potential` at `u` (3 entries per node, m), and rotates the lagged factor to it.
    pub fn linearise(&mut self, potential: &Potential, u: &[f64]) {
        potential.elastic_stiffness(u, &mut self.tangent);
        self.complete_tangent(potential, u);
    }

    /// The second half of `linearise`, when `tangent` holds its elastic part alone.
    pub(crate) fn complete_tangent(&mut self, potential: &Potential, u: &[f64]) {
        potential.add_inertia_and_loads(u, &mut self.tangent);
        self.rank_one = RankOneUpdates::new(potential.rank_one_terms(u));
        self.rotate_factor_to(potential, u);
    }

    /// K⁻¹ b with the assembled tangent, both in elimination order, and the number of iterations; none where K is not
    /// positive definite. The tangent is factorised when PCG takes more iterations than `options` allow.
    pub(crate) fn tangent_solve(
        &mut self,
        potential: &Potential,
        u: &[f64],
        b: &[f64],
        options: PcgOptions,
    ) -> Option<(Vec<f64>, usize)> {
        // A relative residual would be 0/0, and the iteration would end in a factorisation for nothing.
        if b.iter().all(|&entry| entry == 0.0) {
            return Some((b.to_vec(), 0));
        }
        if let Some(found) = self.is_ready().then(|| self.preconditioned_solve(potential, b, options)).flatten() {
            return Some(found);
        }
        self.factorise(potential, u, b).ok()?;
        // Rounding may keep the residual of a stiff sheet above the tolerance: the factor's own solution is then the
        // best.
        self.preconditioned_solve(potential, b, options).or_else(|| {
            let mut x = b.to_vec();
            self.solve(potential.data, &mut x);
            Some((x, options.max_iterations))
        })
    }

    /// K⁻¹ b by PCG with the assembled tangent and the last factor.
    pub(crate) fn preconditioned_solve(
        &mut self,
        potential: &Potential,
        b: &[f64],
        options: PcgOptions,
    ) -> Option<(Vec<f64>, usize)> {
        let (tangent, rank_one) = (std::mem::take(&mut self.tangent), std::mem::take(&mut self.rank_one));
        let multiply = |x: &[f64], y: &mut [f64]| {
            potential.data.pattern.multiply(&tangent, x, y);
            rank_one.multiply(x, y);
        };
        let solution = conjugate_gradients(multiply, |x| self.solve(potential.data, x), b, options);
        (self.tangent, self.rank_one) = (tangent, rank_one);
        solution
    }
}
