//! Elongated-body theory: the water that a slender tail drags sideways, and what it leaves behind at the trailing edge.
//!
//! m = ¼ π ρ s²                                            virtual mass a length of depth s [lighthill1971]
//! T ≈ ½ m w²                                              at the trailing edge alone; paper, equation 6 and appendix
//! T = d/dt ∫ m w n_x da − [m u w n_x] + [½ m w² x']       the whole tail, brackets at the trailing edge [lighthill1971]
//!
//! The last is the momentum balance of the water up to the plane across the trailing edge: what it gains, what the edge
//! leaves behind as it slides, and the suction of the wake; no swimming speed, the head is held.
//!
//! Stands on: `Section`. Never knows: how the tail is bent along its length.

use si::{KilogramPerCubicMetre, Metre, Point2};

use crate::{Section, Sloped};

/// Virtual mass a length, kg/m, of a section of depth `depth` (m) in a fluid of `density` (kg/m³).
pub fn virtual_mass(density: KilogramPerCubicMetre, depth: Metre) -> f64 {
    0.25 * std::f64::consts::PI * density * depth * depth
}

/// ½ m ẏ², N: the paper's simplification, with the sideways velocity at the trailing edge; never negative.
pub fn trailing_edge(mass: f64, edge: &Section) -> Sloped {
    let speed = Sloped { value: edge.velocity[1], by_tangent: [0.0; 2], by_velocity: [0.0, 1.0] };
    speed.by(speed).times(0.5 * mass)
}

/// m w n_x, kg/s: x momentum of the water a length, whose integral's rate is part of the thrust.
pub fn momentum(mass: f64, section: &Section) -> Sloped {
    section.across().by(Sloped::normal_x(section)).times(mass)
}

/// −m u w n_x + ½ m w² x', N: what happens at the trailing edge.
pub fn shed(mass: f64, edge: &Section) -> Sloped {
    let (w, u) = (edge.across(), edge.along());
    let slides = u.by(w).by(Sloped::normal_x(edge)).times(-mass);
    slides.plus(w.by(w).by(Sloped::tangent_x(edge)).times(0.5 * mass))
}

/// m w n, kg/s: the momentum a length of the water that moves with a section.
pub fn held(mass: f64, section: &Section) -> Point2 {
    normal(section).map(|n| mass * section.across().value * n)
}

/// m u w n − ½ m w² r', N: what a section that slides along itself leaves behind, and the suction there.
pub fn flux(mass: f64, section: &Section) -> Point2 {
    let (w, u, n) = (section.across().value, section.along().value, normal(section));
    [0, 1].map(|k| mass * u * w * n[k] - 0.5 * mass * w * w * section.tangent[k])
}

fn normal(section: &Section) -> Point2 {
    [-section.tangent[1], section.tangent[0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{sections, slopes_are_differences};

    #[test]
    fn slopes_of_every_term_are_what_differences_say() {
        slopes_are_differences(&|s| trailing_edge(2.1, s));
        slopes_are_differences(&|s| momentum(2.1, s));
        slopes_are_differences(&|s| shed(2.1, s));
    }

    #[test]
    fn the_flux_s_reaction_is_the_thrust_that_is_shed() {
        for section in sections() {
            assert!((flux(2.1, &section)[0] + shed(2.1, &section).value).abs() < 1e-15);
            assert!((held(2.1, &section)[0] - momentum(2.1, &section).value).abs() < 1e-15);
        }
    }

    #[test]
    fn a_straight_edge_that_moves_sideways_sheds_the_paper_s_force() {
        let edge = sections()[0];
        assert!((shed(2.1, &edge).value - trailing_edge(2.1, &edge).value).abs() < 1e-15);
        assert!((trailing_edge(2.1, &edge).value - 0.5 * 2.1 * 0.04).abs() < 1e-15);
    }

    #[test]
    fn the_virtual_mass_is_that_of_a_cylinder_of_water() {
        // a plate of depth s carries the water of a circle of diameter s
        assert!((virtual_mass(1000.0, 0.06) - 1000.0 * std::f64::consts::PI * 0.03 * 0.03).abs() < 1e-12);
    }

    #[test]
    fn an_edge_that_slides_along_itself_sheds_nothing() {
        let edge = Section { tangent: [0.8, 0.6], velocity: [0.4, 0.3] };
        assert!(shed(2.0, &edge).value.abs() < 1e-15 && momentum(2.0, &edge).value.abs() < 1e-15);
    }
}
