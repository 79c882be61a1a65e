//! Natural modes against the closed form of a slender beam, and their orthogonality.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::{Clamps, Equilibrium, RegionProperties, Solver, StaticSettings, System, box_mesh};

const LENGTH: f64 = 0.2;
const SIDES: [f64; 2] = [0.006, 0.01];

fn beam() -> (Solver, Equilibrium) {
    let mesh = box_mesh::quadratic([LENGTH, SIDES[0], SIDES[1]], [20, 1, 1]);
    let material = fem::materials::by_name("neo_hookean").unwrap();
    let clamps = Clamps::below_x(&mesh, 1e-9);
    let system = System::new(mesh, vec![RegionProperties::elastic(material, 2e6, 0.0, 1e3)], clamps).unwrap();
    let mut solver = system.solver();
    let rest = solver.equilibrium(&[], None, &StaticSettings::default()).unwrap();
    (solver, rest)
}

#[test]
fn the_first_modes_are_those_of_a_slender_beam() {
    let (mut solver, rest) = beam();
    let modes = solver.modes(&rest, 4).unwrap();
    // f = (βL)² / 2πL² √(EI/ρA), with I/A = h²/12
    let closed = |root: f64, side: f64| {
        root * root / (std::f64::consts::TAU * LENGTH * LENGTH) * (2e6 / 1e3 / 12.0f64).sqrt() * side
    };
    let expected = [closed(1.8751, SIDES[0]), closed(1.8751, SIDES[1]), closed(4.6941, SIDES[0])];
    for (mode, expected) in modes.iter().zip(expected) {
        // shear and rotary inertia lower the frequencies of a real beam
        assert!((mode.frequency / expected - 1.0).abs() < 0.015, "{} {expected}", mode.frequency);
    }
}

#[test]
fn modes_are_orthonormal_in_mass_and_carry_their_own_energy() {
    let (mut solver, rest) = beam();
    let modes = solver.modes(&rest, 3).unwrap();
    for mode in &modes {
        assert!((2.0 * solver.kinetic_energy(&mode.shape).unwrap() - 1.0).abs() < 1e-10);
        let small: Vec<f64> = mode.shape.iter().map(|u| 1e-6 * u).collect();
        let omega = std::f64::consts::TAU * mode.frequency;
        let elastic = 2e12 * solver.elastic_energy(&small).unwrap();
        assert!((elastic / (omega * omega) - 1.0).abs() < 1e-4, "{elastic}");
    }
    let both: Vec<f64> = modes[0].shape.iter().zip(&modes[1].shape).map(|(a, b)| a + b).collect();
    assert!((solver.kinetic_energy(&both).unwrap() - 1.0).abs() < 1e-9);
    assert!(solver.modes(&rest, 0).is_err());
}

#[test]
fn a_body_has_as_many_modes_as_degrees_of_freedom() {
    let mesh = box_mesh::linear([0.01, 0.01, 0.02], [1, 1, 1]);
    let material = fem::materials::by_name("neo_hookean").unwrap();
    let clamps = Clamps::below_x(&mesh, 1e-9);
    let system = System::new(mesh, vec![RegionProperties::elastic(material, 2e6, 0.3, 1e3)], clamps).unwrap();
    let (dofs, mut solver) = (system.dofs(), system.solver());
    let rest = solver.equilibrium(&[], None, &StaticSettings::default()).unwrap();
    let modes = solver.modes(&rest, dofs).unwrap();
    assert!(modes.len() == dofs && modes.is_sorted_by(|a, b| a.frequency <= b.frequency));
    assert!(solver.modes(&rest, dofs + 1).is_err());
}
