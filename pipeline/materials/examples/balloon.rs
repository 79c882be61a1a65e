//! A balloon: pressure over stretch of a thin inflated sphere, from the stress of a law, against the formula of a neo-Hookean one. Its pressure has a
//! maximum at λ = 7^(1/6), beyond which a balloon grows by itself.

use materials::{Material, Moduli, by_name};
use nalgebra::{Matrix3, Vector3};

/// Stress along the skin (Pa) at the stretch λ in both directions, through whose thickness there is none.
fn biaxial_stress(law: &dyn Material, moduli: Moduli, stretch: f64) -> f64 {
    let stress = |thickness: f64| {
        law.energy_and_stress(&Matrix3::from_diagonal(&Vector3::new(stretch, stretch, thickness)), moduli).1
    };
    let (mut thin, mut thick) = (0.5 / stretch.powi(2), 2.0 / stretch.powi(2));
    for _ in 0..60 {
        let middle = 0.5 * (thin + thick);
        *(if stress(middle)[(2, 2)] < 0.0 { &mut thin } else { &mut thick }) = middle;
    }
    stress(thin)[(0, 0)]
}

/// # Errors
/// When there is no such law.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (law, moduli) = (by_name("neo_hookean").ok_or("no such law")?, Moduli::of(3e5, 0.4999));
    let wall_over_radius = 0.01;
    let mut highest = (0.0, 0.0);
    for stretch in (0..60).map(|i| 1.01 + 0.02 * f64::from(i)) {
        // the force 2πr t σ of the skin against p πr²: the first Piola–Kirchhoff stress is a force over the area at rest
        let pressure = 2.0 * wall_over_radius * biaxial_stress(law, moduli, stretch) / stretch.powi(2);
        let formula = 2.0 * moduli.mu * wall_over_radius * (stretch.powi(-1) - stretch.powi(-7));
        println!("λ = {stretch:.2}: {:6.2} mbar, formula {:6.2} mbar", pressure / 100.0, formula / 100.0);
        assert!((pressure / formula - 1.0).abs() < 2e-3);
        highest = if pressure > highest.1 { (stretch, pressure) } else { highest };
    }
    assert!((highest.0 - 7.0_f64.powf(1.0 / 6.0)).abs() < 0.02, "{highest:?}");
    Ok(())
}
