//! Gradients of equilibria and motions: adjoint (one scalar by all parameters) and forward sensitivity (all nodes by
//! one parameter).

pub(crate) mod dynamics;
pub(crate) mod gradient;
pub(crate) mod parameter;
mod sensitivity;
pub(crate) mod shape;
mod statics;
