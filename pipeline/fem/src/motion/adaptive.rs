//! A march that chooses its steps: short where the motion turns, long where it is smooth.
//!
//! The difference between a step's result and the polynomial that the past foretold is a multiple of the step's own
//! error [milne1926]: ⅓ of it for implicit Euler (line), 2/11 for BDF2 (parabola). A step that errs too much is taken
//! again, shorter.
//!
//! Stands on: `dynamics`. Never knows: where pressures come from.

use crate::motion::dynamics::Walk;
use crate::motion::march::{Adaptive, March, Scheme, State, check_adaptive};
use crate::solver::Solver;
use crate::stall::SolveError;
use si::{Metre, Pascal, Second};

/// A step is at most this much longer than the one before: BDF2 is stable below 2.41.
const LONGER: f64 = 1.5;
/// And at least this part of it.
const SHORTER: f64 = 0.25;
/// Part of the length that would just do.
const CAUTION: f64 = 0.85;

impl Solver {
    /// Moves from `initial` to the time `until` (s) in steps of its own choice; `march.step` is not used.
    ///
    /// `pressures` and `observe` as in [`Solver::march`]. Returns the last state and the times of all states, s.
    ///
    /// # Errors
    /// As [`Solver::march`]; a step that finds no motion is tried shorter first.
    pub fn march_adaptive(
        &mut self,
        march: &March,
        adaptive: &Adaptive,
        initial: &State,
        pressures: &dyn Fn(Second) -> Vec<Pascal>,
        until: Second,
        observe: &mut dyn FnMut(Second, &State),
    ) -> Result<(State, Vec<Second>), SolveError> {
        check_adaptive(adaptive)?;
        let mut walk = self.set_out(&March { step: adaptive.shortest, ..*march }, initial)?;
        let mut times = vec![0.0];
        let mut step = adaptive.shortest;
        while until - walk.times[0] > 1e-9 * adaptive.shortest {
            let left = until - walk.times[0];
            let time = if left < 1.0001 * step { until } else { walk.times[0] + step.min(0.5 * left.max(step)) };
            let (next, error) = self.try_step(march, &walk, time, pressures);
            let taken = time - walk.times[0];
            let shortest = taken <= adaptive.shortest * 1.0001;
            match next {
                Err(lost) if shortest => return Err(lost),
                Ok(next) if shortest || error <= adaptive.tolerance => {
                    walk = next;
                    times.push(time);
                    observe(time, &walk.states[0]);
                }
                _ => {}
            }
            step =
                (taken * factor(march.scheme, error / adaptive.tolerance)).clamp(adaptive.shortest, adaptive.longest);
        }
        Ok((walk.states.swap_remove_front(0).expect("a walk holds at least the initial state"), times))
    }

    /// The walk one step further, and the error of that step; an infinite one where there is no step.
    fn try_step(
        &mut self,
        march: &March,
        walk: &Walk,
        time: Second,
        pressures: &dyn Fn(Second) -> Vec<Pascal>,
    ) -> (Result<Walk, SolveError>, Metre) {
        let mut next = walk.clone();
        if let Err(lost) = self.step_to(march, &mut next, time, &pressures(time)) {
            return (Err(lost), f64::INFINITY);
        }
        let (order, part) = if march.scheme == Scheme::Bdf2 { (3, 2.0 / 11.0) } else { (2, 1.0 / 3.0) };
        let foretold = walk.guess(order, time);
        let apart = next.states[0].displacement.iter().zip(foretold).map(|(u, g)| (u - g).abs());
        let error = part * apart.fold(0.0, f64::max);
        (Ok(next), error)
    }
}

/// How much longer the next step may be, from this one's error in tolerances.
fn factor(scheme: Scheme, error: f64) -> f64 {
    let order = if scheme == Scheme::Bdf2 { 3.0 } else { 2.0 };
    (CAUTION * error.max(1e-12).powf(-1.0 / order)).clamp(SHORTER, LONGER)
}
