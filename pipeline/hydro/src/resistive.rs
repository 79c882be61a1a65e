//! Resistive forces: drag of a section by the velocity normal to it \[taylor1952\].
//!
//! dF = −½ ρ c s |w| w n da; its thrust is ½ ρ c s |w| w n_x da. The drag coefficient c is a factor outside.

use si::{KilogramPerCubicMetre, Metre, Point2};

use crate::{Section, ValueWithGradient};

/// ½ ρ s |w| w n_x, N/m for c = 1, of a section of depth `depth` (m) in a fluid of `density` (kg/m³).
pub fn drag(density: KilogramPerCubicMetre, depth: Metre, section: &Section) -> ValueWithGradient {
    let w = section.normal_velocity();
    w.abs().mul(w).mul(ValueWithGradient::normal_x(section)).scaled(0.5 * density * depth)
}

/// −½ ρ s |w| w n, N/m for c = 1: the force as a vector.
pub fn force(density: KilogramPerCubicMetre, depth: Metre, section: &Section) -> Point2 {
    let (w, [tx, ty]) = (section.normal_velocity().value, section.tangent);
    [-ty, tx].map(|n| -0.5 * density * depth * w.abs() * w * n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::gradient_is_difference;

    #[test]
    fn the_gradient_is_that_of_central_differences() {
        gradient_is_difference(&|s| drag(1000.0, 0.03, s));
    }

    #[test]
    fn the_thrust_is_the_forward_component_of_the_force() {
        let section = Section { tangent: [0.8, 0.6], velocity: [0.1, -0.3] };
        assert!((force(1000.0, 0.03, &section)[0] + drag(1000.0, 0.03, &section).value).abs() < 1e-15);
    }

    #[test]
    fn drag_opposes_an_outward_stroke_and_propels_on_the_return() {
        let moving = |vy: f64| Section { tangent: [0.8, 0.6], velocity: [0.0, vy] };
        assert!(drag(1000.0, 0.03, &moving(0.2)).value < 0.0);
        assert!(drag(1000.0, 0.03, &moving(-0.2)).value > 0.0);
    }
}
