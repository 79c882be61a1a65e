//! Relaxation of bodies against closed forms: creep, harmonic answer, the order in time, adaptive steps, ring-down.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::{
    Branch, Clamps, DynamicSettings, InitialValueProblem, Mesh, Parameter, RegionProperties, Relaxation, Scheme,
    Springpot, State, StaticSettings, StepControl, System, box_mesh, materials,
};
use std::f64::consts::TAU;

const E: f64 = 2e5;

fn silicone(nu: f64, relaxation: Relaxation) -> RegionProperties {
    let material = materials::by_name("neo_hookean").unwrap();
    RegionProperties { relaxation, ..RegionProperties::elastic(material, E, nu, 1070.0) }
}

fn one_branch() -> Relaxation {
    Relaxation::maxwell(&[Branch { strength: 0.5, time: 0.2 }]).unwrap()
}

fn springpot() -> Relaxation {
    Relaxation::springpot(Springpot { strength: 0.06, exponent: 0.27, decades: [-3, 1] }).unwrap()
}

fn hollow_cube() -> Mesh {
    let air = |cell: [usize; 3]| cell.iter().all(|&at| at == 1);
    box_mesh::grid([3; 3], false, |at| at.map(|x| 0.03 * x), |cell| (!air(cell)).then_some(0))
}

/// With ν = 0 all of the stress relaxes, so that a small displacement of any body is its static one times the creep compliance.
fn inflated(relaxation: Relaxation) -> (System, usize) {
    let mesh = hollow_cube();
    let far = (0..mesh.nodes.len()).max_by(|&a, &b| mesh.nodes[a][0].total_cmp(&mesh.nodes[b][0])).unwrap();
    let clamps = Clamps::below_x(&mesh, 1e-9);
    (System::new(mesh, vec![silicone(0.0, relaxation)], clamps).unwrap(), 3 * far)
}

const PRESSURE: f64 = 2.0;

/// Creep of a Maxwell branch beside a spring: J(t) = 1 − g/(1+g) e^(−t/(τ(1+g))), over 1/μ.
#[test]
fn creep_of_one_branch_is_that_of_the_standard_linear_solid() {
    let (system, dof) = inflated(one_branch());
    let mut solver = system.solver();
    let long = solver.equilibrium(&[PRESSURE], None, &StaticSettings::default()).unwrap().displacement[dof];
    let mut times: Vec<f64> = vec![0.0, 1e-6];
    while times[times.len() - 1] < 3.0 {
        times.push((times[times.len() - 1] * 1.1).max(1e-2));
    }
    let settings = DynamicSettings { scheme: Scheme::QuasiStatic, tolerance: 1e-10, ..Default::default() };
    let rest = State::rest(system.mesh().nodes.len());
    let problem = InitialValueProblem { settings: &settings, initial: &rest, pressures: &|_| vec![PRESSURE] };
    let recorded = solver.record_at(&problem, times, usize::MAX).unwrap();
    let mut see = |time: f64, state: &State| {
        let exact = 1.0 - 0.5 / 1.5 * (-time / (0.2 * 1.5)).exp();
        let found = state.displacement[dof] / long;
        assert!(time == 0.0 || (found / exact - 1.0).abs() < 0.002, "{time} s: {found} of {exact}");
    };
    solver.replay(&recorded, &mut see).unwrap();
}

#[test]
fn a_held_body_relaxes_to_its_equilibrium_of_long_times() {
    let (system, dof) = inflated(springpot());
    let mut solver = system.solver();
    let long = solver.equilibrium(&[PRESSURE], None, &StaticSettings::default()).unwrap().displacement[dof];
    let settings = DynamicSettings { scheme: Scheme::QuasiStatic, step: 20.0, tolerance: 1e-10, ..Default::default() };
    let rest = State::rest(system.mesh().nodes.len());
    let problem = InitialValueProblem { settings: &settings, initial: &rest, pressures: &|_| vec![PRESSURE] };
    let last = solver.integrate(&problem, 20, &mut |_, _| ()).unwrap();
    assert!((last.displacement[dof] / long - 1.0).abs() < 1e-4);
}

/// Storage and loss modulus over μ from the answer to a small harmonic pressure, after the start has died away.
fn harmonic(relaxation: &Relaxation, frequency: f64) -> [f64; 2] {
    const STEPS: usize = 120;
    let (system, dof) = inflated(relaxation.clone());
    let mut solver = system.solver();
    let long = solver.equilibrium(&[PRESSURE], None, &StaticSettings::default()).unwrap().displacement[dof];
    let settings = DynamicSettings {
        scheme: Scheme::QuasiStatic,
        step: 1.0 / frequency / STEPS as f64,
        tolerance: 1e-9,
        ..Default::default()
    };
    let rest = State::rest(system.mesh().nodes.len());
    let pressure = |time: f64| vec![PRESSURE * (TAU * frequency * time).sin()];
    let problem = InitialValueProblem { settings: &settings, initial: &rest, pressures: &pressure };
    let cycles = 4;
    let mut sums = [0.0; 2];
    let mut observe = |time: f64, state: &State| {
        if time > (cycles as f64 - 1.0 + 0.5 / STEPS as f64) / frequency {
            let x = state.displacement[dof] / long;
            sums[0] += x * (TAU * frequency * time).sin() / (0.5 * STEPS as f64);
            sums[1] -= x * (TAU * frequency * time).cos() / (0.5 * STEPS as f64);
        }
    };
    solver.integrate(&problem, cycles * STEPS, &mut observe).unwrap();
    let size = sums[0] * sums[0] + sums[1] * sums[1];
    sums.map(|part| part / size)
}

#[test]
fn storage_and_loss_modulus_are_those_of_the_spectrum_from_a_tenth_to_twenty_hertz() {
    // Branches of some periods at most: what is slower than the four periods simulated has not settled.
    for (frequency, decades) in [(0.1, [-2, 0]), (1.0, [-3, -1]), (20.0, [-4, -2])] {
        let springpot = Springpot { strength: 0.06, exponent: 0.27, decades };
        let relaxation = Relaxation::springpot(springpot).unwrap();
        let [storage, loss] = relaxation.complex_modulus(TAU * frequency);
        let found = harmonic(&relaxation, frequency);
        assert!((found[0] / storage - 1.0).abs() < 0.005, "{frequency} Hz: {} of {storage}", found[0]);
        assert!((found[1] / loss - 1.0).abs() < 0.005, "{frequency} Hz: {} of {loss}", found[1]);
    }
}

/// A bar held straight and released under gravity.
fn released(relaxation: Relaxation) -> (System, usize) {
    let mesh = box_mesh::quadratic([0.1, 0.03, 0.03], [4, 1, 1]);
    let tip = (0..mesh.nodes.len()).find(|&n| mesh.nodes[n] == [0.1, 0.0, 0.0]).unwrap();
    let clamps = Clamps::below_x(&mesh, 1e-9);
    (System::new(mesh, vec![silicone(0.45, relaxation)], clamps).unwrap(), 3 * tip + 2)
}

fn fall(system: &System, dof: usize, scheme: Scheme, step: f64, until: f64) -> Vec<f64> {
    let mut solver = system.solver();
    solver.set_gravity([0.0, 0.0, -9.81]).unwrap();
    let settings = DynamicSettings { scheme, step, tolerance: 1e-10, ..Default::default() };
    let rest = State::rest(system.mesh().nodes.len());
    let problem = InitialValueProblem { settings: &settings, initial: &rest, pressures: &|_| Vec::new() };
    let mut path = Vec::new();
    let steps = (until / step).round() as usize;
    solver.integrate(&problem, steps, &mut |_, state| path.push(state.displacement[dof])).unwrap();
    path
}

#[test]
fn motion_with_relaxation_is_of_second_order_in_the_time_step() {
    let (system, dof) = released(springpot());
    let last = |step: f64| *fall(&system, dof, Scheme::Bdf2, step, 0.06).last().unwrap();
    let exact = last(0.25e-3);
    let error = [4e-3, 2e-3, 1e-3].map(|step| (last(step) - exact).abs());
    // The reference is itself off by a sixteenth of the last error.
    for pair in error.windows(2) {
        assert!((pair[0] / pair[1]).log2() > 1.9, "{error:?}");
    }
}

/// Damping ratio and frequency of the released bar are those of a single degree of freedom whose modulus is μ*(ω) (nearly: λ does not
/// relax, and ν = 0.45 leaves it a part in the stretch of the fibres).
#[test]
fn a_released_bar_loses_what_the_loss_modulus_says() {
    let (system, dof) = released(springpot());
    let path = fall(&system, dof, Scheme::Bdf2, 0.5e-3, 0.8);
    let long = *fall(&system, dof, Scheme::QuasiStatic, 5.0, 500.0).last().unwrap();
    let lows: Vec<(usize, f64)> = (1..path.len() - 1)
        .filter(|&n| path[n] < path[n - 1] && path[n] <= path[n + 1] && path[n] < 1.1 * long)
        .map(|n| (n, path[n]))
        .collect();
    let [(first, a), .., (last, b)] = lows[..] else { panic!("{} minima", lows.len()) };
    let count = (lows.len() - 1) as f64;
    let frequency = count / ((last - first) as f64 * 0.5e-3);
    // The bar still creeps while it swings: the middle of the swing is not at its long-term sag yet.
    let middle = path[path.len() - 200..].iter().sum::<f64>() / 200.0;
    let decrement = ((a - middle) / (b - middle)).ln() / count;
    let [storage, loss] = springpot().complex_modulus(TAU * frequency);
    let expected = std::f64::consts::PI * loss / storage;
    assert!((decrement / expected - 1.0).abs() < 0.15, "{decrement} of {expected} at {frequency} Hz");
}

#[test]
fn adaptive_steps_follow_the_motion_of_short_equal_ones() {
    let (system, dof) = released(springpot());
    let reference = *fall(&system, dof, Scheme::Bdf2, 0.5e-3, 0.1).last().unwrap();
    let mut solver = system.solver();
    solver.set_gravity([0.0, 0.0, -9.81]).unwrap();
    let settings = DynamicSettings { tolerance: 1e-10, ..Default::default() };
    let rest = State::rest(system.mesh().nodes.len());
    let problem = InitialValueProblem { settings: &settings, initial: &rest, pressures: &|_| Vec::new() };
    let control = StepControl { tolerance: 2e-6, shortest: 1e-4, longest: 1e-2 };
    let (last, times) = solver.integrate_adaptive(&problem, &control, 0.1, &mut |_, _| ()).unwrap();
    assert!(times.len() < 200);
    assert!((last.displacement[dof] - reference).abs() < 0.01 * reference.abs());
}

#[test]
fn a_law_that_is_not_objective_cannot_relax() {
    let (system, _) = released(Relaxation::default());
    let linear = RegionProperties { material: materials::by_name("linear").unwrap(), ..silicone(0.3, springpot()) };
    let refused = System::new(system.mesh().clone(), vec![linear], Clamps::below_x(system.mesh(), 1e-9)).unwrap_err();
    assert!(refused.to_string().contains("the law `linear` cannot relax"));
    let mut solver = system.solver();
    assert!(solver.set_relaxation(1, springpot()).is_err());
    let at = solver.equilibrium(&[], None, &StaticSettings::default()).unwrap();
    assert!(solver.sensitivity(&at, Parameter::RelaxationTime { region: 0, branch: 0 }).is_err(), "no such branch");
    assert!(solver.sensitivity(&at, Parameter::SpringpotExponent(0)).is_err(), "no springpot");
}
