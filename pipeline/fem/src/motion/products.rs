//! Products of a body's matrices with a field of all its nodes.
//!
//! Stands on: `solver`. Never knows: what a field stands for.

use crate::solver::Solver;

impl Solver {
    /// M x at free nodes, both 3 a node.
    pub(crate) fn mass_times(&self, x: &[f64]) -> Vec<f64> {
        let pattern = &self.parts.pattern;
        let mut free = Vec::new();
        pattern.gather(x, &mut free);
        let mut image = vec![0.0; free.len()];
        self.given.mass.multiply(pattern, &free, &mut image);
        let mut full = vec![0.0; x.len()];
        pattern.spread(&image, 1.0, &mut full);
        full
    }

    /// K_f(u) x at free nodes, both 3 a node; the tangent in place is lost.
    pub(crate) fn elastic_stiffness_times(&mut self, u: &[f64], x: &[f64]) -> Vec<f64> {
        let Self { parts, given, newton, .. } = self;
        let pressures = vec![0.0; parts.chambers.len()];
        given.at_rest(parts, &pressures, 0.0).stiffness(u, &mut newton.values);
        let mut free = Vec::new();
        parts.pattern.gather(x, &mut free);
        let mut image = vec![0.0; free.len()];
        parts.pattern.multiply(&newton.values, &free, &mut image);
        let mut full = vec![0.0; x.len()];
        parts.pattern.spread(&image, 1.0, &mut full);
        full
    }
}
