//! The same step and the same adjoint by Newton's method: the reference to which projective dynamics is compared.

use super::{Projective, ProjectiveError, potential};
use crate::dynamics::settings::State;
use crate::newton::options::{Globalisation, NewtonOptions};
use crate::solver_state::SolverState;
use si::Pascal;
use sparse::PcgOptions;

/// Newton iterations at most in one step.
const MAX_ITERATIONS: usize = 200;
/// Fraction of the body's size by which the last iteration may move a node.
const TOLERANCE: f64 = 1e-7;
/// Accuracy of the adjoint; beyond these iterations the exact tangent is factorised.
const ADJOINT: PcgOptions = PcgOptions { tolerance: 1e-11, max_iterations: 12 };

impl Projective {
    /// As [`Projective::step`], by Newton's method with a new factorisation in each iteration; returns their number.
    ///
    /// # Errors
    /// [`ProjectiveError`] when a list has the wrong length or no step is found.
    pub fn step_by_newton(
        &mut self,
        state: &State,
        pressures: &[Pascal],
        forces: &[f64],
    ) -> Result<(State, usize), ProjectiveError> {
        let (inertia, mut u) = self.start_step(state, pressures, forces)?;
        let SolverState { inputs, data, newton, .. } = &mut self.state;
        let potential = potential(inputs, data, pressures, inertia.as_ref());
        let options = NewtonOptions {
            tolerance: TOLERANCE * data.size,
            max_iterations: MAX_ITERATIONS,
            // No lagged factor: numbers of iterations are compared, and each shall be a whole Newton step.
            max_predicted: 0.0,
            min_steps: 1,
            refactorise: true,
            predicted: false,
            globalisation: Globalisation::LineSearch,
        };
        let counts = newton.minimise(&potential, &mut u, None, &options)?;
        Ok((self.end_state(state, u), counts.factorisations))
    }

    /// As [`Projective::adjoint`], by PCG with the factor that Newton's step left, or by a factor of the exact tangent.
    ///
    /// # Errors
    /// [`ProjectiveError`] when a list has the wrong length or K is not positive definite.
    pub fn adjoint_by_newton(
        &mut self,
        displacement: &[f64],
        pressures: &[Pascal],
        b: &[f64],
    ) -> Result<(Vec<f64>, usize), ProjectiveError> {
        let (inertia, b) = self.start_adjoint(displacement, pressures, b)?;
        let SolverState { inputs, data, newton, .. } = &mut self.state;
        let potential = potential(inputs, data, pressures, inertia.as_ref());
        newton.linearise(&potential, displacement);
        let (z, iterations) = newton
            .tangent_solve(&potential, displacement, &b, ADJOINT)
            .ok_or(ProjectiveError::NotStable { iterations: ADJOINT.max_iterations })?;
        Ok((data.pattern.scattered(&z, 1.0, displacement.len()), iterations))
    }
}
