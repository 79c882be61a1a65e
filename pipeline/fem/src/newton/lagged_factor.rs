//! Warm start: a nearby solution by preconditioned conjugate gradients (PCG) on the lagged factor.
//!
//! Newton's directions on the current tangent, each solved by PCG with the factor of the previous solve, rotated with
//! the body, as preconditioner. After a change of parameters by a few per cent this is cheaper than a new
//! factorisation: re-solves after changes of 2 to 10 % took 1.1 to 1.8 s, with a new factor 3.3 to 4.2 s. Where it is
//! not, it gives up early.

use crate::newton::iteration::Newton;
use crate::newton::options::{NewtonCounts, NewtonOptions};
use crate::newton::potential::{HessianKind, Potential};
use sparse::{PcgOptions, RankOneUpdates, max_abs};

/// Newton iterations at most: a solve that needs more converges faster with a new factor.
const MAX_ITERATIONS: usize = 8;
/// Relative residual of a direction: each Newton iteration squares the error anyway. A factorisation costs about 24
/// iterations of PCG.
const DIRECTION: PcgOptions = PcgOptions { tolerance: 1e-3, max_iterations: 24 };

impl Newton {
    /// Moves `u` (3 entries per node, m) to a minimum of `potential` without a new factorisation; none when that takes too
    /// long, and `u` is then unchanged.
    pub(crate) fn warm_start(
        &mut self,
        potential: &Potential,
        u: &mut [f64],
        options: &NewtonOptions,
    ) -> Option<NewtonCounts> {
        let mut iterate = u.to_vec();
        let mut previous: Option<Vec<f64>> = None;
        let mut gradient = vec![0.0; u.len()];
        let mut last = f64::INFINITY;
        for iterations in 1..=MAX_ITERATIONS {
            if !potential.energy(&iterate, &mut gradient).value.is_finite() {
                return None;
            }
            let direction = self.pcg_direction(potential, &iterate, previous.as_deref(), &gradient)?;
            let size = max_abs(&direction);
            // Diverging steps: the guess is outside the basin of Newton's method without globalisation.
            if size > 2.0 * last || !size.is_finite() {
                return None;
            }
            let step = potential.data.pattern.scattered(&direction, -1.0, iterate.len());
            if potential.admissible_part(&iterate, &step) < 1.0 {
                return None;
            }
            previous = Some(iterate.clone());
            sparse::add(&mut iterate, 1.0, &step);
            // The next step would be shorter by the same ratio again, but not below the residual of PCG: stop when that
            // suffices.
            if size * (size / last).max(DIRECTION.tolerance) <= 0.5 * options.tolerance || size <= options.tolerance {
                u.copy_from_slice(&iterate);
                return Some(NewtonCounts { iterations, ..NewtonCounts::default() });
            }
            last = size;
        }
        None
    }

    /// K⁻¹ g at `u`, in elimination order; `previous` is where the last step began.
    fn pcg_direction(
        &mut self,
        potential: &Potential,
        u: &[f64],
        previous: Option<&[f64]>,
        gradient: &[f64],
    ) -> Option<Vec<f64>> {
        let kind = if previous.is_some() { HessianKind::MixedPoint } else { HessianKind::Exact };
        potential.hessian(u, previous.unwrap_or(&[]), kind, &mut self.tangent);
        self.rank_one = RankOneUpdates::new(potential.rank_one_terms(u));
        self.rotate_factor_to(potential, u);
        let free = potential.data.pattern.gather(gradient);
        self.preconditioned_solve(potential, &free, DIRECTION).map(|(direction, _)| direction)
    }
}
