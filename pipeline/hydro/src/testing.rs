//! Sections for tests, and gradients by central differences.

use crate::{Section, ValueWithGradient};

/// Some sections in motion.
pub(crate) fn sections() -> Vec<Section> {
    let bent = |a: f64, vx: f64, vy: f64| Section { tangent: [a.cos(), a.sin()], velocity: [vx, vy] };
    vec![bent(0.0, 0.0, 0.2), bent(0.4, -0.05, 0.3), bent(-0.9, 0.1, -0.25), bent(1.2, -0.2, 0.02)]
}

/// Compares the gradient of `force` with central differences at every section.
pub(crate) fn gradient_is_difference(force: &dyn Fn(&Section) -> ValueWithGradient) {
    for section in sections() {
        let found = force(&section);
        for k in 0..2 {
            let step = 1e-6;
            let moved = |by: f64, tangent: bool| {
                let mut other = section;
                if tangent {
                    other.tangent[k] += by
                } else {
                    other.velocity[k] += by
                }
                force(&other).value
            };
            let by = |tangent| (moved(step, tangent) - moved(-step, tangent)) / (2.0 * step);
            let size = found.value.abs().max(1e-3);
            assert!((by(true) - found.by_tangent[k]).abs() < 1e-7 * size.max(found.by_tangent[k].abs()), "{section:?}");
            assert!(
                (by(false) - found.by_velocity[k]).abs() < 1e-7 * size.max(found.by_velocity[k].abs()),
                "{section:?}"
            );
        }
    }
}
