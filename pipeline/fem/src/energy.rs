//! Energies of the whole body: what is stored in its strain and in its motion, so that a motion's books can be kept.
//!
//! Stands on: `solver`, `body`. Never knows: who did the work.

use crate::solver::Solver;
use crate::stall::SolveError;
use si::Joule;

impl Solver {
    /// Ψ(u) of displacement `u` (3 a node, m), J; of a half model, of the half. Infinite where an element is inside out and its
    /// law forbids that.
    ///
    /// # Errors
    /// [`SolveError`] when `u` is not of this system.
    pub fn elastic_energy(&self, u: &[f64]) -> Result<Joule, SolveError> {
        self.check_field("the displacement", u)?;
        let mut forces = vec![0.0; u.len()];
        Ok(self.parts.body().energy(&self.given.elastic, u, 0.0, &mut forces))
    }

    /// ½ vᵀ M v of velocity `v` (3 a node, m/s), J; of a half model, of the half.
    ///
    /// # Errors
    /// [`SolveError`] when `v` is not of this system.
    pub fn kinetic_energy(&self, v: &[f64]) -> Result<Joule, SolveError> {
        self.check_field("the velocity", v)?;
        let (mut free, pattern) = (Vec::new(), &self.parts.pattern);
        pattern.gather(v, &mut free);
        let mut momentum = vec![0.0; free.len()];
        self.given.mass.multiply(pattern, &free, &mut momentum);
        Ok(0.5 * free.iter().zip(&momentum).map(|(v, p)| v * p).sum::<f64>())
    }

    /// ∂Ψ/∂u at `u` (3 a node, m), 3 a node, N.
    ///
    /// # Errors
    /// [`SolveError`] when `u` is not of this system.
    pub fn elastic_force(&self, u: &[f64]) -> Result<Vec<f64>, SolveError> {
        self.check_field("the displacement", u)?;
        Ok(self.elastic_forces(u))
    }
}
