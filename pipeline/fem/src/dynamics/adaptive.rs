//! Adaptive time steps.
//!
//! The difference between a step's result and the extrapolation of the past is a multiple of the step's local error
//! [milne1926]: ⅓ of it for implicit Euler (line), 2/11 for BDF2 (parabola). A step with too large an error is repeated
//! with a shorter one.

use crate::dynamics::settings::{DynamicSettings, InitialValueProblem, Scheme, State, StepControl, check_control};
use crate::dynamics::stepper::StepperState;
use crate::solve_error::SolveError;
use crate::solver_state::SolverState;
use si::{Metre, Second};

/// Largest ratio of successive steps: BDF2 is stable below 2.41.
const MAX_RATIO: f64 = 1.5;
/// Smallest ratio of successive steps.
const MIN_RATIO: f64 = 0.25;
/// Fraction of the step that would just meet the tolerance.
const SAFETY: f64 = 0.85;

impl SolverState {
    /// See [`crate::Solver::integrate_adaptive`].
    pub(crate) fn integrate_adaptive(
        &mut self,
        problem: &InitialValueProblem,
        control: &StepControl,
        until: Second,
        observe: &mut dyn FnMut(Second, &State),
    ) -> Result<(State, Vec<Second>), SolveError> {
        check_control(control)?;
        let scheme = problem.settings.scheme;
        let first = DynamicSettings { step: control.shortest, ..*problem.settings };
        let mut stepper = self.start(&first, problem.initial)?;
        let mut times = vec![0.0];
        let mut step = control.shortest;
        while until - stepper.times[0] > 1e-9 * control.shortest {
            let remaining = until - stepper.times[0];
            // The last two steps share what is left, so that none is much shorter than the error allows.
            let time =
                if remaining < 1.0001 * step { until } else { stepper.times[0] + step.min(0.5 * remaining.max(step)) };
            let (next, error) = self.try_step(problem, &stepper, time);
            let taken = time - stepper.times[0];
            let shortest = taken <= control.shortest * 1.0001;
            match next {
                Err(failure) if shortest => return Err(failure),
                Ok(next) if shortest || error <= control.tolerance => {
                    stepper = next;
                    times.push(time);
                    observe(time, &stepper.states[0]);
                }
                _ => {}
            }
            step = (taken * step_ratio(scheme, error / control.tolerance)).clamp(control.shortest, control.longest);
        }
        Ok((stepper.into_newest(), times))
    }

    /// The stepper one step further, and the estimated error of that step; infinite when the step failed.
    fn try_step(
        &mut self,
        problem: &InitialValueProblem,
        stepper: &StepperState,
        time: Second,
    ) -> (Result<StepperState, SolveError>, Metre) {
        let mut next = stepper.clone();
        if let Err(failure) = self.step_to(problem.settings, &mut next, time, &(problem.pressures)(time)) {
            return (Err(failure), f64::INFINITY);
        }
        let (order, part) = if problem.settings.scheme == Scheme::Bdf2 { (3, 2.0 / 11.0) } else { (2, 1.0 / 3.0) };
        let predicted = stepper.initial_guess(order, time);
        let difference = next.states[0].displacement.iter().zip(predicted).map(|(u, guess)| (u - guess).abs());
        let error = part * difference.fold(0.0, f64::max);
        (Ok(next), error)
    }
}

/// Ratio of the next step to this one, from this one's error in tolerances.
fn step_ratio(scheme: Scheme, error: f64) -> f64 {
    // The local error is one order above the scheme's: h³ of BDF2, h² of Euler. The floor keeps the root finite at
    // rest.
    let order = if scheme == Scheme::Bdf2 { 3.0 } else { 2.0 };
    (SAFETY * error.max(1e-12).powf(-1.0 / order)).clamp(MIN_RATIO, MAX_RATIO)
}
