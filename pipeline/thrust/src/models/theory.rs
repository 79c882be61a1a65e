//! Theory with coefficients: Lighthill's terms, drag, the tail's own inertia, and a constant.
//!
//! F = c₁ F_edge + c₂ d/dt ∫ m w n_x da + c₃ F_drag + c₄ ẍ + c₅; c₁ = c₂ = 1 in \[lighthill1971\].

use crate::run::TheoryTerms;

/// How many coefficients stand before the constant.
pub const COEFFICIENTS: usize = 4;

/// The columns at one sample, without the constant.
pub fn columns(parts: &TheoryTerms) -> Vec<f64> {
    vec![parts.edge_flux, parts.momentum_rate, parts.drag, parts.tip_acceleration]
}
