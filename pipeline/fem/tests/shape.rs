//! Derivatives of an equilibrium by the shape of the undeformed body, against equilibria of bodies whose nodes were moved.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::{
    Clamps, Equilibrium, Mesh, Options, RegionProperties, SolveError, Solver, StaticSettings, System, box_mesh,
    materials,
};

const PRESSURE: f64 = 1.2e4;

/// A bar of 60 × 20 × 20 mm with a chamber beside a stiff sheet, half of it meshed.
fn bar() -> Mesh {
    let air = |cell: [usize; 3]| (1..5).contains(&cell[0]) && cell[1] == 3 && cell[2] == 0;
    let place = |at: [f64; 3]| [0.06 * at[0], 0.02 * at[1] * (0.6 + 0.4 * at[1]), 0.01 * at[2]];
    let region = move |cell: [usize; 3]| if air(cell) { None } else { Some(u16::from(cell[1] == 1)) };
    box_mesh::to_quadratic(&box_mesh::grid([6, 5, 2], true, place, region))
}

fn system(law: &str, options: Options) -> System {
    let mesh = bar();
    let material = materials::by_name(law).unwrap();
    let regions = [2.1e5, 3e7]
        .map(|e| RegionProperties { stiffening: [0.3, -0.1], ..RegionProperties::elastic(material, e, 0.45, 1e3) });
    let clamps = Clamps::below_x(&mesh, 1e-9);
    System::with(mesh, regions.to_vec(), clamps, options).unwrap()
}

/// A field that bends every edge and keeps the plane of symmetry.
fn velocity(mesh: &Mesh) -> Vec<f64> {
    let field = |[x, y, z]: [f64; 3]| {
        [0.3 * (90.0 * y).sin(), 0.5 * (60.0 * x).cos() + 20.0 * y * z, 30.0 * z * (1.0 + 40.0 * x)]
    };
    mesh.nodes.iter().flat_map(|node| field(*node)).collect()
}

fn equilibrium(system: &System, start: Option<&Equilibrium>) -> (Solver, Equilibrium) {
    let mut solver = system.solver();
    solver.set_gravity([3.0, 9.81, 0.0]).unwrap();
    let settings = StaticSettings { tolerance: 1e-12, load_steps: 4, ..StaticSettings::default() };
    let guess = start.map(|at| at.displacement.as_slice());
    let at = solver.equilibrium(&[PRESSURE], guess, &settings).unwrap();
    (solver, at)
}

fn loss(u: &[f64]) -> (f64, Vec<f64>) {
    let weight = |at: usize| (0.37 * at as f64).sin();
    let value = u.iter().enumerate().map(|(at, u)| weight(at) * u + 40.0 * u * u).sum();
    (value, u.iter().enumerate().map(|(at, u)| weight(at) + 80.0 * u).collect())
}

/// What remains of a first-order Taylor expansion falls with the square of the step.
#[test]
fn the_remainder_of_a_taylor_expansion_by_shape_has_the_slope_two() {
    for law in ["neo_hookean", "yeoh", "lopez_pamies_m15", "ogden"] {
        let system = system(law, Options::default());
        let velocity = velocity(system.mesh());
        let (mut solver, at) = equilibrium(&system, None);
        let (value, by_u) = loss(&at.displacement);
        let gradient = solver.shape_gradient(&at, &by_u, &[&velocity]).unwrap()[0];
        let remainder = |step: f64| {
            let moved = system.morphed(&velocity, step).unwrap();
            (loss(&equilibrium(&moved, Some(&at)).1.displacement).0 - value - step * gradient).abs()
        };
        let (coarse, fine) = (remainder(4e-4), remainder(1e-4));
        let slope = (coarse / fine).ln() / 4.0_f64.ln();
        assert!((slope - 2.0).abs() < 0.05, "{law}: {slope}");
    }
}

#[test]
fn forward_sensitivity_adjoint_and_differences_agree() {
    let system = system("ogden", Options::default());
    let velocity = velocity(system.mesh());
    let (mut solver, at) = equilibrium(&system, None);
    let (_, by_u) = loss(&at.displacement);
    let forward = solver.shape_sensitivity(&at, &velocity).unwrap();
    let along: f64 = forward.iter().zip(&by_u).map(|(u, l)| u * l).sum();
    let adjoint = solver.shape_gradient(&at, &by_u, &[&velocity]).unwrap()[0];
    let side = |step: f64| {
        let moved = system.morphed(&velocity, step).unwrap();
        loss(&equilibrium(&moved, Some(&at)).1.displacement).0
    };
    let difference = (side(1e-5) - side(-1e-5)) / 2e-5;
    assert!((along / adjoint - 1.0).abs() < 1e-8, "{along} {adjoint}");
    assert!((difference / adjoint - 1.0).abs() < 1e-5, "{difference} {adjoint}");
}

/// A body that is moved as a whole, or made longer and as much thicker, is as heavy and as large as it should be.
#[test]
fn a_morphed_body_has_the_mass_and_the_chamber_of_its_shape() {
    let system = system("yeoh", Options::default());
    let mesh = system.mesh();
    let grown: Vec<f64> = mesh.nodes.iter().flat_map(|node| *node).collect();
    let larger = system.morphed(&grown, 0.1).unwrap();
    assert!((larger.mass() / system.mass() / 1.331 - 1.0).abs() < 1e-12);
    let rest = vec![0.0; 3 * mesh.nodes.len()];
    assert!((larger.chamber_volume(0, &rest) / system.chamber_volume(0, &rest) / 1.331 - 1.0).abs() < 1e-12);
    assert_eq!(larger.dofs(), system.dofs());
    assert!(system.morphed(&grown, -2.0).is_err(), "inverted");
}

#[test]
fn what_has_no_derivative_by_shape_is_refused() {
    let system = system("yeoh", Options { mean_dilatation: vec![true], ..Options::default() });
    let velocity = velocity(system.mesh());
    let (mut solver, at) = equilibrium(&system, None);
    let refused = solver.shape_sensitivity(&at, &velocity);
    assert!(matches!(refused, Err(SolveError::Setting { .. })), "{refused:?}");
    assert!(matches!(solver.shape_sensitivity(&at, &velocity[1..]), Err(SolveError::Length { .. })));
}
