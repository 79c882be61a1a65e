//! A plate that heaves sideways in still water: Lighthill's term at its trailing edge is ½ m ẏ² with the added mass m = ρ π d²/4 of its depth d.

use hydro::{Stations, Tail};

/// kg/m³, m, and m/s.
const DENSITY: f64 = 998.0;
const DEPTH: f64 = 0.04;
const SPEED: f64 = 0.1;

/// # Errors
/// When the marks do not lie along the tail.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let stations = Stations { clamp: 0.01, marks: &[0.05, 0.07, 0.09], edge: 0.11, end: 0.11 };
    let tail = Tail::new(DENSITY, &stations, 24, &|_| DEPTH)?;
    // all marks move along and sideways as one: the line between them turns no section
    let straight = [[0.0; 2]; 3];
    let terms = tail.terms(&straight, &[[0.0, SPEED]; 3]);
    let added_mass = DENSITY * std::f64::consts::FRAC_PI_4 * DEPTH.powi(2);
    println!(
        "trailing edge {:.3} mN, drag {:.3} mN a unit coefficient",
        1e3 * terms.trailing_edge.value,
        1e3 * terms.drag.value
    );
    // the clamped end stands still, so that the spline's speed at the edge is above that of the marks
    let edge_speed = (terms.trailing_edge.value / (0.5 * added_mass)).sqrt();
    println!("speed of the trailing edge {edge_speed:.4} m/s");
    assert!(edge_speed > SPEED && edge_speed < 1.5 * SPEED);
    // the derivative by the last mark's sideways speed against a difference
    let step = 1e-6;
    let faster = tail.terms(&straight, &[[0.0, SPEED], [0.0, SPEED], [0.0, SPEED + step]]);
    let difference = (faster.trailing_edge.value - terms.trailing_edge.value) / step;
    assert!((terms.trailing_edge.by_velocity[2][1] / difference - 1.0).abs() < 1e-4);
    Ok(())
}
