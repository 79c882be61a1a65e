//! Elongated-body theory: reactive forces on a slender tail from the added mass of its cross-sections \[lighthill1971\].
//!
//! m = ¼ π ρ s²                                            added mass per length at depth s
//! T ≈ ½ m w²                                              from the trailing edge alone; paper, equation 6 and appendix
//! T = d/dt ∫ m w n_x da − [m u w n_x] + [½ m w² x']       large-amplitude form, brackets at the trailing edge
//!
//! The last is the momentum balance of the water up to the plane through the trailing edge: rate of momentum, flux through the edge and
//! pressure of the wake. There is no swimming speed, because the head is clamped.

use si::{KilogramPerCubicMetre, Metre, Point2};

use crate::{Section, ValueWithGradient};

/// Virtual mass a length, kg/m, of a section of depth `depth` (m) in a fluid of `density` (kg/m³).
pub(crate) fn virtual_mass(density: KilogramPerCubicMetre, depth: Metre) -> f64 {
    0.25 * std::f64::consts::PI * density * depth * depth
}

/// ½ m ẏ², N: the paper's simplification, with the lateral velocity at the trailing edge; never negative.
pub fn trailing_edge(mass: f64, edge: &Section) -> ValueWithGradient {
    // ẏ and not w: without swimming speed u = ẋ x' + ẏ y' is of second order in the motion, w − ẏ and the flux m u w y'
    // are of higher order still. What remains, and is positive, is the formula as published.
    let speed = ValueWithGradient { value: edge.velocity[1], by_tangent: [0.0; 2], by_velocity: [0.0, 1.0] };
    speed.mul(speed).scaled(0.5 * mass)
}

/// m w n_x, kg/s: x momentum of the water a length, whose integral's rate is part of the thrust.
pub fn momentum(mass: f64, section: &Section) -> ValueWithGradient {
    section.normal_velocity().mul(ValueWithGradient::normal_x(section)).scaled(mass)
}

/// −m u w n_x + ½ m w² x', N: thrust at the trailing edge from convected momentum and the pressure of the wake.
pub(crate) fn edge_thrust(mass: f64, edge: &Section) -> ValueWithGradient {
    let (w, u) = (edge.normal_velocity(), edge.tangential_velocity());
    let convected = u.mul(w).mul(ValueWithGradient::normal_x(edge)).scaled(-mass);
    convected.add(w.mul(w).mul(ValueWithGradient::tangent_x(edge)).scaled(0.5 * mass))
}

/// m w n, kg/s: momentum per length of the water that moves with a section.
pub(crate) fn momentum_vector(mass: f64, section: &Section) -> Point2 {
    normal_vector(section).map(|n| mass * section.normal_velocity().value * n)
}

/// m u w n − ½ m w² r', N: momentum flux that leaves at a section, and the wake's pressure there.
pub(crate) fn flux_vector(mass: f64, section: &Section) -> Point2 {
    let (w, u, n) = (section.normal_velocity().value, section.tangential_velocity().value, normal_vector(section));
    [0, 1].map(|k| mass * u * w * n[k] - 0.5 * mass * w * w * section.tangent[k])
}

fn normal_vector(section: &Section) -> Point2 {
    [-section.tangent[1], section.tangent[0]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{gradient_is_difference, sections};

    #[test]
    fn gradients_are_those_of_central_differences() {
        gradient_is_difference(&|s| trailing_edge(2.1, s));
        gradient_is_difference(&|s| momentum(2.1, s));
        gradient_is_difference(&|s| edge_thrust(2.1, s));
    }

    #[test]
    fn the_reaction_of_the_flux_is_the_thrust_at_the_edge() {
        for section in sections() {
            assert!((flux_vector(2.1, &section)[0] + edge_thrust(2.1, &section).value).abs() < 1e-15);
            assert!((momentum_vector(2.1, &section)[0] - momentum(2.1, &section).value).abs() < 1e-15);
        }
    }

    #[test]
    fn a_straight_edge_that_moves_sideways_has_the_thrust_of_the_paper() {
        let edge = sections()[0];
        assert!((edge_thrust(2.1, &edge).value - trailing_edge(2.1, &edge).value).abs() < 1e-15);
        assert!((trailing_edge(2.1, &edge).value - 0.5 * 2.1 * 0.04).abs() < 1e-15);
    }

    #[test]
    fn the_virtual_mass_is_that_of_a_cylinder_of_water() {
        // the added mass of a plate of depth s is the water of a circle of diameter s
        assert!((virtual_mass(1000.0, 0.06) - 1000.0 * std::f64::consts::PI * 0.03 * 0.03).abs() < 1e-12);
    }

    #[test]
    fn an_edge_that_moves_along_itself_has_no_thrust() {
        let edge = Section { tangent: [0.8, 0.6], velocity: [0.4, 0.3] };
        assert!(edge_thrust(2.0, &edge).value.abs() < 1e-15 && momentum(2.0, &edge).value.abs() < 1e-15);
    }
}
