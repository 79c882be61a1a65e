//! Gradients of an equilibrium against differences of equilibria, on a box of two materials with a chamber.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::{
    Clamps, Equilibrium, Forces, Mesh, Options, Parameter, RegionProperties, Solver, StaticSettings, System, box_mesh,
    materials,
};

const E: [f64; 2] = [2.1e5, 3e7];
const NU: [f64; 2] = [0.47, 0.35];
const PRESSURE: f64 = 2.5e4;

/// A bar of 60 × 20 × 20 mm, half of it meshed: a chamber beside a stiff sheet, so that it bends.
fn bar() -> Mesh {
    let air = |cell: [usize; 3]| (1..5).contains(&cell[0]) && cell[1] == 3 && cell[2] == 0;
    let place = |at: [f64; 3]| [0.06 * at[0], 0.02 * at[1] * (0.6 + 0.4 * at[1]), 0.01 * at[2]];
    let region = move |cell: [usize; 3]| if air(cell) { None } else { Some(u16::from(cell[1] == 1)) };
    box_mesh::to_quadratic(&box_mesh::grid([6, 5, 2], true, place, region))
}

fn system() -> System {
    with(Options::default())
}

fn with(options: Options) -> System {
    let mesh = bar();
    let material = materials::by_name("neo_hookean").unwrap();
    let regions = [0, 1].map(|n| RegionProperties::elastic(material, E[n], NU[n], 1e3));
    let clamps = Clamps::below_x(&mesh, 1e-9);
    System::with(mesh, regions.to_vec(), clamps, options).unwrap()
}

fn tight() -> StaticSettings {
    StaticSettings { tolerance: 1e-12, load_steps: 4, ..Default::default() }
}

/// A nonlinear scalar of the displacement, and its derivative.
fn loss(u: &[f64]) -> (f64, Vec<f64>) {
    let weight = |at: usize| (0.37 * at as f64).sin();
    let value = u.iter().enumerate().map(|(at, u)| weight(at) * u + 40.0 * u * u).sum();
    (value, u.iter().enumerate().map(|(at, u)| weight(at) + 80.0 * u).collect())
}

/// What a bar is made of and how it is pushed.
#[derive(Clone, Copy)]
struct Set {
    e: [f64; 2],
    nu: [f64; 2],
    density: [f64; 2],
    pressure: f64,
    force: f64,
}

const SET: Set = Set { e: E, nu: NU, density: [1e3, 1.4e3], pressure: PRESSURE, force: 0.02 };

/// Gravity and a force across the bar, so that every parameter counts.
fn give(solver: &mut Solver, mesh: &Mesh, set: Set) {
    for region in 0..2 {
        solver.set_elastic(region, set.e[region], set.nu[region]).unwrap();
        solver.set_density(region, set.density[region]).unwrap();
    }
    let node = far_node(mesh);
    solver.set_forces(Forces::none(mesh).on_node(node as u32, [0.0, set.force, 0.0]).unwrap().as_slice()).unwrap();
    solver.set_gravity([3.0, 9.81, 0.0]).unwrap();
}

fn far_node(mesh: &Mesh) -> usize {
    (0..mesh.nodes.len()).max_by(|&a, &b| mesh.nodes[a][0].total_cmp(&mesh.nodes[b][0])).unwrap()
}

fn rest(solver: &mut Solver, mesh: &Mesh, set: Set, start: Option<&Equilibrium>) -> Equilibrium {
    give(solver, mesh, set);
    solver.equilibrium(&[set.pressure], start.map(|at| at.displacement.as_slice()), &tight()).unwrap()
}

/// (parameter, the number that it is)
type Case = (Parameter, fn(&mut Set) -> &mut f64);

fn cases(mesh: &Mesh) -> [Case; 8] {
    [
        (Parameter::YoungsModulus(0), |set| &mut set.e[0]),
        (Parameter::YoungsModulus(1), |set| &mut set.e[1]),
        (Parameter::PoissonsRatio(0), |set| &mut set.nu[0]),
        (Parameter::PoissonsRatio(1), |set| &mut set.nu[1]),
        (Parameter::Density(0), |set| &mut set.density[0]),
        (Parameter::Density(1), |set| &mut set.density[1]),
        (Parameter::Pressure(0), |set| &mut set.pressure),
        (Parameter::Force { node: far_node(mesh), axis: 1 }, |set| &mut set.force),
    ]
}

#[test]
fn adjoint_and_sensitivity_agree_with_converged_central_differences() {
    for (ambient, freed) in [(None, false), (Some(101_325.0), false), (None, true)] {
        let system = with(Options { mean_dilatation: vec![freed], ..Options::default() });
        let mesh = system.mesh();
        let mut solver = system.solver();
        let mut other = system.solver();
        solver.set_sealed(0, ambient).unwrap();
        other.set_sealed(0, ambient).unwrap();
        let at = rest(&mut solver, mesh, SET, None);
        let tip = at.displacement.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
        assert!(tip > 1e-3, "the bar bends visibly: {tip}");
        let slope = loss(&at.displacement).1;
        let gradient = solver.gradient(&at, &slope).unwrap();
        for (parameter, number) in cases(mesh) {
            let adjoint = match parameter {
                Parameter::YoungsModulus(region) => gradient.regions[region].youngs_modulus,
                Parameter::PoissonsRatio(region) => gradient.regions[region].poissons_ratio,
                Parameter::Density(region) => gradient.regions[region].density,
                Parameter::Pressure(chamber) => gradient.pressures[chamber],
                Parameter::Force { node, axis } => gradient.forces[3 * node + axis],
                _ => unreachable!("no such case"),
            };
            let forward: f64 = solver.sensitivity(&at, parameter).unwrap().iter().zip(&slope).map(|(u, l)| u * l).sum();
            assert!((forward / adjoint - 1.0).abs() < 1e-8, "{parameter:?} {forward} {adjoint}");
            let mut set = SET;
            let value = *number(&mut set);
            let mut at_value = |value: f64| {
                *number(&mut set) = value;
                loss(&rest(&mut other, mesh, set, Some(&at)).displacement).0
            };
            // fourth-order differences: the step is large enough that solves to 1e-12 leave 1e-8
            let h = value
                * match parameter {
                    Parameter::Density(_) => 0.1,
                    Parameter::PoissonsRatio(_) => 4e-4,
                    _ => 2e-3,
                };
            let difference = (8.0 * (at_value(value + h) - at_value(value - h))
                - (at_value(value + 2.0 * h) - at_value(value - 2.0 * h)))
                / (12.0 * h);
            assert!((difference / adjoint - 1.0).abs() < 1e-6, "{parameter:?} {difference} {adjoint}");
        }
    }
}

#[test]
fn the_adjoint_gradient_passes_the_taylor_test() {
    let system = system();
    let mut solver = system.solver();
    let at = rest(&mut solver, system.mesh(), SET, None);
    let (value, slope) = loss(&at.displacement);
    let gradient = solver.adjoint(&at, &slope).unwrap();
    let turn = [[0.3 * E[0], -0.2 * E[1]], [-0.05, 0.1]];
    let along: f64 =
        (0..2).map(|n| gradient[n].youngs_modulus * turn[0][n] + gradient[n].poissons_ratio * turn[1][n]).sum();
    let mut other = system.solver();
    let remainders: Vec<f64> = [0.1f64, 0.05, 0.025]
        .iter()
        .map(|step| {
            let e = [0, 1].map(|n| E[n] + step * turn[0][n]);
            let nu = [0, 1].map(|n| NU[n] + step * turn[1][n]);
            ({
                let set = Set { e, nu, ..SET };
                loss(&rest(&mut other, system.mesh(), set, Some(&at)).displacement).0
            } - value
                - step * along)
                .abs()
        })
        .collect();
    for pair in remainders.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 2.0).abs() < 0.05, "{order}");
    }
}

#[test]
fn a_warm_start_on_the_lagged_factor_finds_the_same_equilibrium() {
    let system = system();
    let (mut new, mut old) = (system.solver(), system.solver());
    let settings = StaticSettings::default();
    let at = old.equilibrium(&[PRESSURE], None, &settings).unwrap();
    for solver in [&mut new, &mut old] {
        solver.set_elastic(0, 1.05 * E[0], NU[0]).unwrap();
    }
    let fresh = new.equilibrium(&[PRESSURE], Some(&at.displacement), &settings).unwrap();
    let reused = old
        .equilibrium(&[PRESSURE], Some(&at.displacement), &StaticSettings { reuse_factor: true, ..settings })
        .unwrap();
    let apart =
        fresh.displacement.iter().zip(&reused.displacement).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    assert!(apart < 1e-8 * 0.06, "{apart:e}");
    assert_eq!(reused.factorisations, 0);
    let slope = loss(&fresh.displacement).1;
    let (a, b) = (new.adjoint(&fresh, &slope).unwrap(), old.adjoint(&reused, &slope).unwrap());
    assert!((a[0].youngs_modulus / b[0].youngs_modulus - 1.0).abs() < 1e-6);
}

#[test]
fn two_threads_share_one_system_and_find_the_same_bytes() {
    let system = system();
    let solve = || system.solver().equilibrium(&[PRESSURE], None, &StaticSettings::default()).unwrap();
    let (one, two) = std::thread::scope(|scope| {
        let (one, two) = (scope.spawn(solve), scope.spawn(solve));
        (one.join().unwrap(), two.join().unwrap())
    });
    assert_eq!(one, two);
}

#[test]
fn a_gradient_is_linear_in_the_derivative_of_the_loss_whatever_its_size() {
    let mesh = bar();
    let system = system();
    let mut solver = system.solver();
    give(&mut solver, &mesh, SET);
    let at = solver.equilibrium(&[PRESSURE], None, &tight()).unwrap();
    let slope = loss(&at.displacement).1;
    let gradient = solver.gradient(&at, &slope).unwrap();
    for exponent in [-100, -40, 40, 100] {
        // a power of two changes no digit
        let scale = 2f64.powi(exponent);
        let scaled: Vec<f64> = slope.iter().map(|entry| scale * entry).collect();
        let other = solver.gradient(&at, &scaled).unwrap();
        for (one, other) in gradient.regions.iter().zip(&other.regions) {
            assert_eq!(scale * one.youngs_modulus, other.youngs_modulus);
            assert_eq!(scale * one.poissons_ratio, other.poissons_ratio);
        }
        let pairs = gradient.elements.iter().zip(&other.elements);
        assert!(pairs.into_iter().all(|(one, other)| scale * one == *other));
    }
}
