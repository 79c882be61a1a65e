//! Theory with coefficients: Lighthill's terms, drag, the tail's own inertia, and a constant.
//!
//! F = c₁ shed + c₂ d/dt ∫ m w n_x da + c₃ drag + c₄ ẍ + c₅; Lighthill says c₁ = c₂ = 1 [lighthill1971].
//!
//! Stands on: run. Never knows: how coefficients are found.

use crate::thrust::run::Parts;

/// How many coefficients stand before the constant.
pub const COEFFICIENTS: usize = 4;

/// The columns at one sample, without the constant.
pub fn columns(parts: &Parts) -> Vec<f64> {
    vec![parts.shed, parts.gained, parts.drag, parts.jerked]
}
