//! Resistive forces: drag of a section across the flow, which has a part along the tail when the section is turned.
//!
//! dF = −½ ρ c s |w| w n da; its thrust is ½ ρ c s |w| w n_x da [taylor1952]. c stays a factor outside.
//!
//! Stands on: `Section`. Never knows: the whole tail.

use si::{KilogramPerCubicMetre, Metre, Point2};

use crate::{Section, Sloped};

/// ½ ρ s |w| w n_x, N/m for c = 1, of a section of depth `depth` (m) in a fluid of `density` (kg/m³).
pub fn drag(density: KilogramPerCubicMetre, depth: Metre, section: &Section) -> Sloped {
    let w = section.across();
    w.size().by(w).by(Sloped::normal_x(section)).times(0.5 * density * depth)
}

/// −½ ρ s |w| w n, N/m for c = 1: all of it.
pub fn push(density: KilogramPerCubicMetre, depth: Metre, section: &Section) -> Point2 {
    let (w, [tx, ty]) = (section.across().value, section.tangent);
    [-ty, tx].map(|n| -0.5 * density * depth * w.abs() * w * n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::slopes_are_differences;

    #[test]
    fn its_slope_is_what_differences_say() {
        slopes_are_differences(&|s| drag(1000.0, 0.03, s));
    }

    #[test]
    fn the_thrust_is_the_push_s_part_forwards() {
        let section = Section { tangent: [0.8, 0.6], velocity: [0.1, -0.3] };
        assert!((push(1000.0, 0.03, &section)[0] + drag(1000.0, 0.03, &section).value).abs() < 1e-15);
    }

    #[test]
    fn a_tail_that_swings_out_is_pushed_back_and_one_that_swings_home_forwards() {
        let moving = |vy: f64| Section { tangent: [0.8, 0.6], velocity: [0.0, vy] };
        assert!(drag(1000.0, 0.03, &moving(0.2)).value < 0.0);
        assert!(drag(1000.0, 0.03, &moving(-0.2)).value > 0.0);
    }
}
