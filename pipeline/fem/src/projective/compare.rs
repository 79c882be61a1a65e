//! The same step and the same gradient by Newton's method: what projective dynamics is compared with.
//!
//! Stands on: `newton`, `tangent`. Never knows: local and global steps.

use super::{Projective, ProjectiveError, potential};
use crate::descent::search::{Gait, Rule};
use crate::descent::tangent::Demand;
use crate::motion::march::State;
use crate::solver::Solver;
use si::Pascal;

/// Directions at most in one step.
const LIMIT: usize = 200;
/// Part of the body's size that the last direction may still move a node.
const TOLERANCE: f64 = 1e-7;
/// ‖Kz − b‖ / ‖b‖
const EXACT: f64 = 1e-11;
/// Iterations with the factor that the step left, before the exact tangent is factorised.
const PATIENCE: usize = 12;

impl Projective {
    /// As [`Projective::step`], by Newton's method with a new factor for each step; their number is returned.
    ///
    /// # Errors
    /// [`ProjectiveError`] when a list has the wrong length or no step is found.
    pub fn step_by_newton(
        &mut self,
        state: &State,
        pressures: &[Pascal],
        forces: &[f64],
    ) -> Result<(State, usize), ProjectiveError> {
        let (inertia, mut u) = self.set_out(state, pressures, forces)?;
        let Solver { given, parts, newton, .. } = &mut self.solver;
        let on = potential(given, parts, pressures, inertia.as_ref());
        let tolerance = TOLERANCE * parts.size;
        let rule = Rule { tolerance, limit: LIMIT, patience: 0.0, trials: 1, fresh: true, gait: Gait::Careful };
        let found = newton.minimise(&on, &mut u, None, &rule)?;
        Ok((self.arrived(state, u), found.factorisations))
    }

    /// As [`Projective::backward`], by the factor that Newton's step left, or one of the exact tangent.
    ///
    /// # Errors
    /// [`ProjectiveError`] when a list has the wrong length or K is not positive definite.
    pub fn backward_by_newton(
        &mut self,
        displacement: &[f64],
        pressures: &[Pascal],
        b: &[f64],
    ) -> Result<(Vec<f64>, usize), ProjectiveError> {
        let (inertia, b) = self.set_back(displacement, pressures, b)?;
        let Solver { given, parts, newton, .. } = &mut self.solver;
        let on = potential(given, parts, pressures, inertia.as_ref());
        newton.linearise(&on, displacement);
        let demand = Demand { tolerance: EXACT, patience: PATIENCE };
        let (z, iterations) = newton
            .solve_exactly(&on, displacement, &b, demand)
            .ok_or(ProjectiveError::NotStable { iterations: PATIENCE })?;
        let mut full = vec![0.0; displacement.len()];
        parts.pattern.spread(&z, 1.0, &mut full);
        Ok((full, iterations))
    }
}
