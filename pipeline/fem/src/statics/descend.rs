//! One descent to a shape at rest under a load that stays.
//!
//! Stands on: `solver`, `descent`. Never knows: a load step.

use crate::descent::search::{Rule, Stall};
use crate::solver::Solver;
use crate::statics::equilibrium::Equilibrium;
use si::Pascal;

impl Solver {
    /// Moves `at` to its equilibrium; returns the factors made.
    pub(crate) fn descend(
        &mut self,
        at: &mut Equilibrium,
        before: Option<&[f64]>,
        pressures: &[Pascal],
        dead_strength: f64,
        rule: &Rule,
    ) -> Result<usize, Stall> {
        let potential = self.given.at_rest(&self.parts, pressures, dead_strength);
        let found = self.newton.minimise(&potential, &mut at.displacement, before, rule)?;
        at.iterations += found.iterations;
        at.factorisations += found.factorisations;
        if found.indefinite > 0 {
            at.snaps.push(dead_strength);
        }
        Ok(found.factorisations)
    }
}
