//! Dynamics against beam theory, and against statics after the motion has decayed.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::{
    Clamps, DynamicSettings, InitialValueProblem, RegionProperties, Scheme, State, StaticSettings, System, box_mesh,
    materials,
};
use std::f64::consts::PI;

const LENGTH: f64 = 0.1;
const SIDE: f64 = 0.008;
const E: f64 = 2e5;
const DENSITY: f64 = 1070.0;

fn properties(poissons_ratio: f64) -> RegionProperties {
    let material = materials::by_name("corotated").unwrap();
    RegionProperties::elastic(material, E, poissons_ratio, DENSITY)
}

/// First bending frequency of a slender clamped beam, Hz: (1.8751/L)² √(EI/ρA) / 2π
fn first_frequency() -> f64 {
    (1.875_104_f64 / LENGTH).powi(2) * (E * SIDE * SIDE / 12.0 / DENSITY).sqrt() / (2.0 * PI)
}

/// A clamped beam let go from a small bend: the tip's height at each of `steps` steps, `each` of them a period.
fn ring(scheme: Scheme, mass_damping: f64, stiffness_damping: f64, each: usize, steps: usize) -> Vec<f64> {
    let mesh = box_mesh::quadratic([LENGTH, SIDE, SIDE], [10, 1, 1]);
    let clamps = Clamps::below_x(&mesh, 1e-9);
    let tip = mesh.nodes.iter().position(|at| at[0] > LENGTH - 1e-9).unwrap();
    let mut forces = vec![0.0; 3 * mesh.nodes.len()];
    forces[3 * tip + 1] = 1e-5;
    let system = System::new(mesh, vec![properties(0.3)], clamps).unwrap();
    let mut solver = system.solver();
    solver.set_forces(&forces).unwrap();
    let bent = solver.equilibrium(&[], None, &StaticSettings { tolerance: 1e-10, ..Default::default() }).unwrap();
    solver.set_forces(&[]).unwrap();
    let settings = DynamicSettings {
        step: 1.0 / first_frequency() / each as f64,
        scheme,
        mass_damping,
        stiffness_damping,
        ..DynamicSettings::default()
    };
    let start = State { velocity: vec![0.0; bent.displacement.len()], displacement: bent.displacement };
    let mut heights = vec![start.displacement[3 * tip + 1]];
    let mut see = |_: f64, state: &State| heights.push(state.displacement[3 * tip + 1]);
    solver
        .integrate(
            &InitialValueProblem { settings: &settings, initial: &start, pressures: &|_| Vec::new() },
            steps,
            &mut see,
        )
        .unwrap();
    heights
}

/// Where the signal falls through zero, in samples.
fn falls(signal: &[f64]) -> Vec<f64> {
    let through = signal.windows(2).enumerate().filter(|(_, pair)| pair[0] > 0.0 && pair[1] <= 0.0);
    through.map(|(at, pair)| at as f64 + pair[0] / (pair[0] - pair[1])).collect()
}

/// Part of the amplitude that one period keeps, from the root mean squares of the second and the third period.
fn kept(signal: &[f64], each: usize) -> f64 {
    let size = |part: &[f64]| part.iter().map(|x| x * x).sum::<f64>().sqrt();
    size(&signal[2 * each..3 * each]) / size(&signal[each..2 * each])
}

#[test]
fn an_undamped_beam_vibrates_at_its_first_frequency_with_constant_amplitude() {
    let heights = ring(Scheme::Bdf2, 0.0, 0.0, 100, 300);
    let falls = falls(&heights);
    let period = (falls[falls.len() - 1] - falls[0]) / (falls.len() - 1) as f64;
    assert!((period / 100.0 - 1.0).abs() < 0.02, "{period}");
    let kept = kept(&heights, 100);
    assert!((kept - 1.0).abs() < 0.01, "{kept}");
}

#[test]
fn the_numerical_damping_of_implicit_euler_is_that_of_its_theory() {
    let kept = kept(&ring(Scheme::ImplicitEuler, 0.0, 0.0, 100, 300), 100);
    // |1 / (1 − iωh)| a step: (1 + (2π/100)²)^-50
    let theory = (1.0 + (2.0 * PI / 100.0_f64).powi(2)).powi(-50);
    assert!((kept - theory).abs() < 0.02, "{kept} {theory}");
    assert!(kept < 0.85);
}

#[test]
fn rayleigh_damping_gives_the_first_mode_its_damping_ratio() {
    let omega = 2.0 * PI * first_frequency();
    for (mass, stiffness) in [(0.1 * omega, 0.0), (0.0, 0.1 / omega)] {
        let kept = kept(&ring(Scheme::Bdf2, mass, stiffness, 100, 300), 100);
        let ratio: f64 = 0.05;
        let theory = (-2.0 * PI * ratio / (1.0 - ratio * ratio).sqrt()).exp();
        assert!((kept / theory - 1.0).abs() < 0.02, "{kept} {theory}");
    }
}

/// A bar of 60 × 20 × 20 mm, half of it meshed, with a chamber beside a stiff sheet.
fn bar() -> System {
    let air = |cell: [usize; 3]| (1..5).contains(&cell[0]) && cell[1] == 3 && cell[2] == 0;
    let place = |at: [f64; 3]| [0.06 * at[0], 0.02 * at[1], 0.01 * at[2]];
    let region = move |cell: [usize; 3]| if air(cell) { None } else { Some(u16::from(cell[1] == 1)) };
    let mesh = box_mesh::to_quadratic(&box_mesh::grid([6, 5, 2], true, place, region));
    let clamps = Clamps::below_x(&mesh, 1e-9);
    System::new(mesh, vec![properties(0.45), RegionProperties { youngs_modulus: 1e7, ..properties(0.4) }], clamps)
        .unwrap()
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
}

#[test]
fn a_damped_bar_comes_to_rest_at_its_equilibrium_with_either_scheme_and_any_time_step() {
    let system = bar();
    let mut solver = system.solver();
    let pressure = 1.5e4;
    let rest = solver.equilibrium(&[pressure], None, &StaticSettings::default()).unwrap();
    let most = apart(&rest.displacement, &vec![0.0; rest.displacement.len()]);
    for (scheme, step, steps) in
        [(Scheme::ImplicitEuler, 2e-2, 60), (Scheme::Bdf2, 1e-2, 120), (Scheme::Bdf2, 4e-3, 300)]
    {
        let settings =
            DynamicSettings { step, scheme, mass_damping: 40.0, stiffness_damping: 1e-3, ..DynamicSettings::default() };
        let raised = |time: f64| vec![pressure * (time / 0.1).min(1.0)];
        let end = solver
            .integrate(
                &InitialValueProblem {
                    settings: &settings,
                    initial: &State::rest(rest.displacement.len() / 3),
                    pressures: &raised,
                },
                steps,
                &mut |_, _| (),
            )
            .unwrap();
        let apart = apart(&end.displacement, &rest.displacement) / most;
        assert!(apart < 1e-3, "{scheme:?} {step} {apart:e}");
    }
}

#[test]
fn two_integrations_give_the_same_bytes() {
    let system = bar();
    let settings = DynamicSettings {
        step: 5e-3,
        scheme: Scheme::Bdf2,
        mass_damping: 1.0,
        stiffness_damping: 1e-3,
        ..DynamicSettings::default()
    };
    let beat = |time: f64| vec![1e4 * (1.0 - (2.0 * PI * 2.0 * time).cos())];
    let nodes = system.mesh().nodes.len();
    let run = || {
        system
            .solver()
            .integrate(
                &InitialValueProblem { settings: &settings, initial: &State::rest(nodes), pressures: &beat },
                20,
                &mut |_, _| (),
            )
            .unwrap()
    };
    assert_eq!(run(), run());
}
