//! Dead loads: forces on nodes that keep their size and direction.
//!
//! Stands on: `load`. Never knows: where the nodes are.

use crate::load::Load;
use nalgebra::Matrix3;

/// W = −f · u
#[derive(Debug, Clone, Default)]
pub(crate) struct DeadForces {
    /// 3 a node, N; empty: none.
    pub forces: Vec<f64>,
}

impl Load for DeadForces {
    fn potential(&self, u: &[f64]) -> f64 {
        -self.forces.iter().zip(u).map(|(force, moved)| force * moved).sum::<f64>()
    }

    fn add_gradient(&self, _u: &[f64], strength: f64, gradient: &mut [f64]) {
        gradient.iter_mut().zip(&self.forces).for_each(|(entry, force)| *entry -= strength * force);
    }

    fn add_hessian(&self, _u: &[f64], _strength: f64, _add: &mut dyn FnMut(u32, u32, &Matrix3<f64>)) {}
}
