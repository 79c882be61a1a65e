//! Implicit time integration: fixed and adaptive steps, and recorded motions with checkpoints.

mod adaptive;
pub(crate) mod refactorisation;
pub(crate) mod settings;
pub(crate) mod stencil;
pub(crate) mod stepper;
pub(crate) mod trajectory;
