//! A mass on a thread: its weight acts in full, its inertia along the thread alone.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use simulate::{Body, case, load};
use std::path::Path;

/// Kinetic energy of unit velocities along x, y and z, and the deflection under the weight, m: with the mass fixed, or on a thread.
fn with(hangs: &str) -> ([f64; 3], f64) {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let text = std::fs::read_to_string(examples.join("swing.toml")).unwrap();
    let text = text.replace("mass = 0.001\n", &format!("mass = 0.001\n{hangs}\n"));
    let case = case::parse(&text, Path::new("swing.toml")).unwrap();
    let loaded = load(&case, &examples).unwrap();
    let body = Body::new(&case, &loaded).unwrap();
    let mut solver = body.solver(&case).unwrap();
    let energy = |axis: usize| {
        let velocity: Vec<f64> =
            (0..3 * body.solid.nodes().len()).map(|at| f64::from(u8::from(at % 3 == axis))).collect();
        solver.kinetic_energy(&velocity).unwrap()
    };
    let energies = [0, 1, 2].map(energy);
    let down = solver.equilibrium(&[], None, &fem::StaticSettings::default()).unwrap().displacement;
    (energies, down.chunks_exact(3).fold(0.0, |most: f64, u| most.min(u[2])))
}

#[test]
fn a_mass_on_a_thread_has_its_weight_and_inertia_along_the_thread_alone() {
    let ((fixed, sag), (hanging, same)) = (with(""), with("hangs = \"z\""));
    let lost = [0, 1, 2].map(|axis| fixed[axis] - hanging[axis]);
    assert!((lost[0] - 5e-4).abs() < 1e-12 && (lost[1] - 5e-4).abs() < 1e-12 && lost[2].abs() < 1e-15, "{lost:?}");
    assert!((sag - same).abs() < 1e-12 && sag < -1e-4, "{sag} {same}");
}
