//! Displaced clamps: constrained dofs whose displacement is prescribed (inhomogeneous Dirichlet conditions), such as the grips of a testing
//! machine.
//!
//! Newton's method leaves constrained dofs as it finds them, so that a shape that has them in place is enough. Moved by themselves, they stretch
//! the elements beside them alone: a tenth of a bar's length inverts a compressed one. The other nodes are therefore predicted by the tangent.

use crate::newton::potential::HessianKind;
use crate::solver_state::SolverState;
use si::{Metre, Pascal};

/// Step of the difference that gives the forces of displaced clamps, as a fraction of the body's size: far above rounding.
const DIFFERENCE: f64 = 1e-7;

impl SolverState {
    /// Whether a clamp is displaced: a shape predicted from its motion has the stress of that motion, and the first tangent that of the shape before.
    pub(crate) fn moves_clamps(&self) -> bool {
        !self.inputs.prescribed.is_empty()
    }

    /// The same displacement with constrained dofs at `factor` of what is prescribed.
    pub(crate) fn with_clamps_at(&self, displacement: &[Metre], factor: f64) -> Vec<Metre> {
        let mut shape = self.with_constraints(displacement);
        shape.iter_mut().zip(&self.inputs.prescribed).for_each(|(u, prescribed)| *u += factor * prescribed);
        shape
    }

    /// The shape `from` with its clamps moved to `factor` of what is prescribed, and its other nodes by −K⁻¹ K_c of that motion; they stay
    /// where that tangent, under `pressures` (one per chamber, Pa), is not positive definite.
    pub(crate) fn follow_clamps(&mut self, from: &[Metre], pressures: &[Pascal], factor: f64) -> Vec<Metre> {
        let shape = self.with_clamps_at(from, factor);
        if !self.moves_clamps() {
            return shape;
        }
        let motion: Vec<Metre> = shape.iter().zip(from).map(|(to, from)| to - from).collect();
        let largest = motion.iter().fold(0.0, |most: f64, entry| most.max(entry.abs()));
        if largest == 0.0 {
            return shape;
        }
        let part = DIFFERENCE * self.data.size / largest;
        let nearby: Vec<Metre> = from.iter().zip(&motion).map(|(u, motion)| u + part * motion).collect();
        let change: Vec<f64> = self
            .elastic_forces(&nearby)
            .iter()
            .zip(self.elastic_forces(from))
            .map(|(to, from)| (to - from) / part)
            .collect();
        let Self { data, inputs, newton, linearised, .. } = self;
        *linearised = None;
        let potential = inputs.at_rest(data, pressures);
        potential.hessian(from, &[], HessianKind::Exact, &mut newton.tangent);
        let mut free = data.pattern.gather(&change);
        if newton.factorise(&potential, from, &free).is_err() {
            return shape;
        }
        newton.solve(data, &mut free);
        let response = data.pattern.scattered(&free, -1.0, shape.len());
        shape.iter().zip(response).map(|(u, response)| u + response).collect()
    }
}
