//! Moduli element by element: gradients and sensitivities against differences, and what is refused.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::{
    Branch, Clamps, DynamicSettings, Equilibrium, InitialValueProblem, LossGradient, Parameter, RegionProperties,
    Relaxation, Solver, State, StaticSettings, System, box_mesh,
};

const FINE: StaticSettings =
    StaticSettings { tolerance: 1e-13, load_steps: 3, max_iterations: 40, max_halvings: 40, reuse_factor: false };

fn beams() -> Vec<System> {
    let meshes =
        [box_mesh::quadratic([0.04, 0.01, 0.01], [3, 1, 1]), box_mesh::hexahedra([0.04, 0.01, 0.01], [6, 2, 2])];
    let of = |mesh: fem::Mesh| {
        let silicone = RegionProperties::elastic(fem::materials::by_name("neo_hookean").unwrap(), 2e5, 0.4, 1e3);
        let clamps = Clamps::below_x(&mesh, 1e-9);
        System::new(mesh, vec![silicone], clamps).unwrap()
    };
    meshes.map(of).into()
}

fn factors(system: &System) -> Vec<f64> {
    (0..system.mesh().elements.len()).map(|n| 1.0 + 0.5 * (1.7 * n as f64).sin()).collect()
}

fn loaded(system: &System) -> Solver {
    let mut solver = system.solver();
    solver.set_gravity([0.0, 3.0, -9.81]).unwrap();
    solver
}

fn loss(u: &[f64]) -> f64 {
    u.iter().enumerate().map(|(n, u)| 1e3 * (0.3 * n as f64).sin() * u + 1e5 * u * u).sum()
}

fn slope(u: &[f64]) -> Vec<f64> {
    u.iter().enumerate().map(|(n, u)| 1e3 * (0.3 * n as f64).sin() + 2e5 * u).collect()
}

fn rest(solver: &mut Solver, factors: &[f64]) -> Equilibrium {
    solver.set_element_factors(factors).unwrap();
    solver.equilibrium(&[], None, &FINE).unwrap()
}

/// The central difference of `of` by the factor of one element.
fn difference(factors: &[f64], element: usize, mut of: impl FnMut(&[f64]) -> f64) -> f64 {
    let mut at = |step: f64| {
        let mut near = factors.to_vec();
        near[element] += step;
        of(&near)
    };
    (at(1e-4) - at(-1e-4)) / 2e-4
}

#[test]
fn the_gradient_by_element_factors_at_rest_is_that_of_differences() {
    for system in beams() {
        let (mut solver, factors) = (loaded(&system), factors(&system));
        let found = rest(&mut solver, &factors);
        let gradient = solver.gradient(&found, &slope(&found.displacement)).unwrap();
        let size = gradient.elements.iter().fold(0.0, |most: f64, by| most.max(by.abs()));
        for element in [0, 3, factors.len() - 1] {
            let expected = difference(&factors, element, |near| loss(&rest(&mut solver, near).displacement));
            assert!((gradient.elements[element] - expected).abs() < 1e-6 * size, "{element}");
        }
        let sum: f64 = gradient.elements.iter().zip(&factors).map(|(by, factor)| by * factor).sum();
        assert!((gradient.regions[0].youngs_modulus * 2e5 / sum - 1.0).abs() < 1e-9);
    }
}

#[test]
fn the_sensitivity_along_a_direction_is_the_sum_of_those_of_its_parameters() {
    for system in beams() {
        let (mut solver, factors) = (loaded(&system), factors(&system));
        let found = rest(&mut solver, &factors);
        let direction = [
            (Parameter::ElementFactor(2), 0.3),
            (Parameter::ElementFactor(5), -0.2),
            (Parameter::YoungsModulus(0), 1e3),
            (Parameter::Force { node: 7, axis: 2 }, 1e-4),
        ];
        let together = solver.sensitivity_along(&found, &direction).unwrap();
        let mut sum = vec![0.0; together.len()];
        for (parameter, part) in direction {
            let alone = solver.sensitivity(&found, parameter).unwrap();
            sum.iter_mut().zip(alone).for_each(|(sum, alone)| *sum += part * alone);
        }
        let size = sum.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
        assert!(together.iter().zip(&sum).all(|(a, b)| (a - b).abs() < 1e-8 * size));
        let by_elements: f64 = slope(&found.displacement)
            .iter()
            .zip(&solver.sensitivity(&found, Parameter::ElementFactor(2)).unwrap())
            .map(|(a, b)| a * b)
            .sum();
        let gradient = solver.gradient(&found, &slope(&found.displacement)).unwrap();
        assert!((gradient.elements[2] / by_elements - 1.0).abs() < 1e-6);
    }
}

#[test]
fn the_gradient_by_element_factors_in_motion_is_that_of_differences() {
    for system in beams() {
        let (mut solver, factors) = (loaded(&system), factors(&system));
        let settings = DynamicSettings {
            step: 2e-3,
            stiffness_damping: 1e-3,
            mass_damping: 0.5,
            tolerance: 1e-12,
            ..DynamicSettings::default()
        };
        let initial = State::rest(system.mesh().nodes.len());
        let problem = InitialValueProblem { settings: &settings, initial: &initial, pressures: &|_| Vec::new() };
        let mut last = |near: &[f64]| {
            solver.set_element_factors(near).unwrap();
            loss(&solver.integrate(&problem, 8, &mut |_, _| {}).unwrap().displacement)
        };
        let expected: Vec<f64> = [1, 4].map(|element| difference(&factors, element, &mut last)).into();
        solver.set_element_factors(&factors).unwrap();
        let made = solver.record(&problem, 8, 1 << 28).unwrap();
        let mut by_state = |n: usize, state: &State| match n {
            8 => LossGradient { displacement: slope(&state.displacement), velocity: Vec::new() },
            _ => LossGradient::default(),
        };
        let gradient = solver.trajectory_adjoint(&made, &mut by_state).unwrap();
        let size = gradient.elements.iter().fold(0.0, |most: f64, by| most.max(by.abs()));
        for (element, expected) in [1, 4].into_iter().zip(expected) {
            assert!((gradient.elements[element] - expected).abs() < 2e-6 * size, "{element}");
        }
    }
}

#[test]
fn factors_of_the_wrong_length_or_sign_and_those_of_a_body_that_relaxes_are_refused() {
    let system = &beams()[0];
    let mut solver = system.solver();
    let count = system.mesh().elements.len();
    for bad in [vec![1.0; count - 1], vec![-1.0; count], vec![f64::NAN; count]] {
        assert!(solver.set_element_factors(&bad).is_err());
    }
    let branch = || Relaxation::maxwell(&[Branch { strength: 0.3, time: 0.1 }]).unwrap();
    solver.set_element_factors(&vec![2.0; count]).unwrap();
    assert!(solver.set_relaxation(0, branch()).is_err());
    solver.set_element_factors(&[]).unwrap();
    solver.set_relaxation(0, branch()).unwrap();
    assert!(solver.set_element_factors(&vec![2.0; count]).is_err());
}
