//! Projective dynamics against Newton's method: the same steps, the same gradients, and the number of iterations with a stiff sheet.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::{
    Clamps, DynamicSettings, InitialValueProblem, Mesh, Projective, ProjectiveError, ProjectiveSettings,
    RegionProperties, Scheme, Solver,
};
use fem::{State, StaticSettings, System, box_mesh, materials};

const STEP: f64 = 0.01;
const PRESSURE: f64 = 1e4;

fn made_of(law: &str, youngs_modulus: f64, poissons_ratio: f64) -> RegionProperties {
    let material = materials::by_name(law).unwrap();
    RegionProperties::elastic(material, youngs_modulus, poissons_ratio, 1070.0)
}

/// A bar of 60 × 20 × 20 mm, half of it meshed, with a chamber beside a sheet of 1 mm.
fn mesh() -> Mesh {
    let air = |cell: [usize; 3]| (1..8).contains(&cell[0]) && (3..5).contains(&cell[1]) && cell[2] < 2;
    let across = [0.0, 0.006, 0.007, 0.010, 0.014, 0.017, 0.020];
    let place = |at: [f64; 3]| [0.06 * at[0], across[(6.0 * at[1]).round() as usize], 0.01 * at[2]];
    box_mesh::grid([9, 6, 3], true, place, |cell| (!air(cell)).then_some(u16::from(cell[1] == 1)))
}

fn bar(ratio: f64) -> System {
    let mesh = mesh();
    let clamps = Clamps::below_x(&mesh, 1e-9);
    System::new(mesh, vec![made_of("corotated", 2e5, 0.45), made_of("corotated", ratio * 2e5, 0.4)], clamps).unwrap()
}

fn tight() -> ProjectiveSettings {
    ProjectiveSettings { tolerance: 1e-10, ..Default::default() }
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |most: f64, x| most.max(x.abs()))
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) / largest(b)
}

/// A list of varying numbers, 3 per node.
fn crooked(count: usize, scale: f64) -> Vec<f64> {
    (0..count).map(|at| scale * (0.37 * at as f64).sin()).collect()
}

/// A step of the solver's own time integration.
fn integrated(solver: &mut Solver, from: &State, forces: &[f64]) -> State {
    let settings =
        DynamicSettings { step: STEP, scheme: Scheme::ImplicitEuler, tolerance: 1e-10, ..DynamicSettings::default() };
    solver.set_forces(forces).unwrap();
    solver
        .integrate(
            &InitialValueProblem { settings: &settings, initial: from, pressures: &|_| vec![PRESSURE] },
            1,
            &mut |_, _| (),
        )
        .unwrap()
}

#[test]
fn two_steps_agree_with_implicit_euler_by_newtons_method() {
    let system = bar(10.0);
    let (mut projective, mut solver) = (Projective::new(&system, STEP).unwrap(), system.solver());
    let mut from = State::rest(system.mesh().nodes.len());
    for _ in 0..2 {
        let forces = crooked(from.displacement.len(), 1e-3);
        let (state, _) = projective.step(&from, &[PRESSURE], &forces, &tight()).unwrap();
        let newton = integrated(&mut solver, &from, &forces);
        assert!(largest(&newton.displacement) > 1e-4, "it moves");
        assert!(apart(&state.displacement, &newton.displacement) < 1e-6);
        assert!(apart(&state.velocity, &newton.velocity) < 1e-6);
        from = state;
    }
}

#[test]
fn an_infinite_step_is_the_equilibrium() {
    let system = bar(10.0);
    let mut projective = Projective::new(&system, f64::INFINITY).unwrap();
    let rest = State::rest(system.mesh().nodes.len());
    let (found, _) = projective.step(&rest, &[PRESSURE], &[], &tight()).unwrap();
    let newton = system.solver().equilibrium(&[PRESSURE], None, &StaticSettings::default()).unwrap();
    assert!(largest(&newton.displacement) > 1e-3, "it bends visibly");
    assert!(apart(&found.displacement, &newton.displacement) < 1e-6);
    assert_eq!(largest(&found.velocity), 0.0);
}

#[test]
fn the_adjoint_is_the_gradient_by_every_force() {
    let system = bar(10.0);
    let mut projective = Projective::new(&system, STEP).unwrap();
    let from = State::rest(system.mesh().nodes.len());
    let count = from.displacement.len();
    let (at, _) = projective.step(&from, &[PRESSURE], &[], &tight()).unwrap();
    let b = crooked(count, 1.0);
    let (z, _) = projective.adjoint(&at.displacement, &[PRESSURE], &b, &tight()).unwrap();
    let (newton, _) = projective.adjoint_by_newton(&at.displacement, &[PRESSURE], &b).unwrap();
    assert!(apart(&z, &newton) < 1e-6, "{}", apart(&z, &newton));
    // b · u changes by z · δf
    let along: Vec<f64> = (0..count).map(|at| 1e-3 * (0.11 * at as f64).cos()).collect();
    let mut solver = system.solver();
    let mut at_forces = |part: f64| {
        let forces: Vec<f64> = along.iter().map(|force| part * force).collect();
        integrated(&mut solver, &from, &forces).displacement.iter().zip(&b).map(|(u, b)| u * b).sum::<f64>()
    };
    // fourth-order differences: the step is large enough that solves to 1e-10 leave 1e-8
    let h = 0.1;
    let difference = (8.0 * (at_forces(h) - at_forces(-h)) - (at_forces(2.0 * h) - at_forces(-2.0 * h))) / (12.0 * h);
    let slope: f64 = z.iter().zip(&along).map(|(z, force)| z * force).sum();
    assert!((difference / slope - 1.0).abs() < 1e-6, "{difference} {slope}");
}

#[test]
fn iterations_grow_with_the_ratio_of_the_moduli_but_not_for_newtons_method() {
    let (mut forwards, mut backwards) = (vec![0], vec![0]);
    for ratio in [1.0, 1e2, 1e4] {
        let system = bar(ratio);
        let mut projective = Projective::new(&system, STEP).unwrap();
        let from = State::rest(system.mesh().nodes.len());
        let (state, there) = projective.step(&from, &[PRESSURE], &[], &ProjectiveSettings::default()).unwrap();
        let b = crooked(state.displacement.len(), 1.0);
        let (_, back) = projective.adjoint(&state.displacement, &[PRESSURE], &b, &Default::default()).unwrap();
        let (_, factors) = projective.step_by_newton(&from, &[PRESSURE], &[]).unwrap();
        assert!(factors <= 7, "ratio {ratio:e}: {factors} factors");
        forwards.push(there);
        backwards.push(back);
    }
    assert!(forwards.is_sorted_by(|a, b| a < b), "{forwards:?}");
    assert!(backwards.is_sorted_by(|a, b| a < b), "{backwards:?}");
}

#[test]
fn other_elements_and_laws_are_refused() {
    let quadratic = box_mesh::to_quadratic(&mesh());
    let clamps = Clamps::below_x(&quadratic, 1e-9);
    let regions = vec![made_of("corotated", 2e5, 0.45); 2];
    let refused = Projective::new(&System::new(quadratic, regions, clamps).unwrap(), STEP).unwrap_err();
    assert_eq!(refused, ProjectiveError::Order { nodes: 10 });
    let clamps = Clamps::below_x(&mesh(), 1e-9);
    let regions = vec![made_of("corotated", 2e5, 0.45), made_of("neo_hookean", 2e5, 0.45)];
    let other = Projective::new(&System::new(mesh(), regions, clamps).unwrap(), STEP).unwrap_err();
    assert_eq!(other, ProjectiveError::Law { region: 1, law: "neo_hookean" });
    let step = Projective::new(&bar(1.0), 0.0).unwrap_err();
    for text in [refused, other, step].map(|refusal| refusal.to_string()) {
        assert!(text.contains("\n  why: ") && text.contains("\n  do:  "), "{text}");
    }
}

#[test]
fn too_few_iterations_are_an_error_with_the_residual() {
    let system = bar(1.0);
    let few = ProjectiveSettings { max_iterations: 3, ..Default::default() };
    let from = State::rest(system.mesh().nodes.len());
    let refused = Projective::new(&system, STEP).unwrap().step(&from, &[PRESSURE], &[], &few).unwrap_err();
    assert!(
        matches!(refused, ProjectiveError::IterationLimit { iterations: 3, residual, .. } if residual > 1e-6),
        "{refused}"
    );
}
