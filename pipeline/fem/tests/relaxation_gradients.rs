//! Gradients through relaxation against differences, by the adjoint and by forward sensitivity, of motions and of holds, stored whole
//! and in checkpoint segments.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::{
    Branch, Clamps, DynamicSettings, InitialValueProblem, LossGradient, MotionGradient, Options, Parameter,
    RegionProperties, Relaxation, Scheme, Solver, Springpot, State, System, Trajectory, box_mesh, materials,
};

const STEPS: usize = 16;
const PLENTY: usize = usize::MAX;

/// E, ν, C₂₀/C₁₀, C₃₀/C₁₀, g₀, τ₀, g₁, τ₁, strength and exponent of the other region's springpot.
const AT: [f64; 10] = [2.1e5, 0.44, -0.08, 0.05, 0.25, 0.01, 0.2, 0.2, 0.08, 0.3];

const PARAMETERS: [Parameter; 10] = [
    Parameter::YoungsModulus(0),
    Parameter::PoissonsRatio(0),
    Parameter::Stiffening { region: 0, term: 0 },
    Parameter::Stiffening { region: 0, term: 1 },
    Parameter::RelaxationStrength { region: 0, branch: 0 },
    Parameter::RelaxationTime { region: 0, branch: 0 },
    Parameter::RelaxationStrength { region: 0, branch: 1 },
    Parameter::RelaxationTime { region: 0, branch: 1 },
    Parameter::SpringpotStrength(1),
    Parameter::SpringpotExponent(1),
];

/// A bar of two regions with a chamber, its body with mean dilatation.
fn system() -> System {
    let air = |cell: [usize; 3]| (1..4).contains(&cell[0]) && cell[1] == 1 && cell[2] == 0;
    let place = |at: [f64; 3]| [0.05 * at[0], 0.02 * at[1], 0.01 * at[2]];
    let region = move |cell: [usize; 3]| if air(cell) { None } else { Some(u16::from(cell[1] == 2)) };
    let mesh = box_mesh::to_quadratic(&box_mesh::grid([5, 3, 2], true, place, region));
    let yeoh = RegionProperties::elastic(materials::by_name("yeoh").unwrap(), AT[0], AT[1], 1e3);
    let stiff = RegionProperties::elastic(materials::by_name("neo_hookean").unwrap(), 8e5, 0.4, 1e3);
    let clamps = Clamps::below_x(&mesh, 1e-9);
    let options = Options { mean_dilatation: vec![true], ..Options::default() };
    System::with(mesh, vec![yeoh, stiff], clamps, options).unwrap()
}

fn set(solver: &mut Solver, at: [f64; 10]) {
    let [e, nu, second, third, g, time, h, later, strength, exponent] = at;
    solver.set_elastic(0, e, nu).unwrap();
    solver.set_stiffening(0, [second, third]).unwrap();
    let branches = [Branch { strength: g, time }, Branch { strength: h, time: later }];
    solver.set_relaxation(0, Relaxation::maxwell(&branches).unwrap()).unwrap();
    let springpot = Springpot { strength, exponent, decades: [-3, 0] };
    solver.set_relaxation(1, Relaxation::springpot(springpot).unwrap()).unwrap();
}

#[derive(Clone, Copy)]
struct Motion {
    scheme: Scheme,
    beta: f64,
    memory: usize,
}

const MOTIONS: [Motion; 3] = [
    Motion { scheme: Scheme::Bdf2, beta: 8e-4, memory: PLENTY },
    Motion { scheme: Scheme::ImplicitEuler, beta: 0.0, memory: 2_100_000 },
    Motion { scheme: Scheme::QuasiStatic, beta: 0.0, memory: PLENTY },
];

fn record(solver: &mut Solver, system: &System, at: [f64; 10], motion: Motion) -> Trajectory {
    set(solver, at);
    let Motion { scheme, beta, memory } = motion;
    let settings = DynamicSettings { scheme, stiffness_damping: beta, tolerance: 5e-12, ..Default::default() };
    // A bent start, whose stress the histories begin with.
    let bend = |x: &[f64; 3]| [0.0, 2e-3 * (x[0] / 0.05).powi(2), 0.0];
    let mut start = State::rest(system.mesh().nodes.len());
    start.displacement = system.mesh().nodes.iter().flat_map(bend).collect();
    let pressures = |time: f64| vec![6e3 * (1.0 + (60.0 * time).sin())];
    let times = (0..=STEPS).map(|n| 3e-3 * n as f64 * (1.0 + 0.02 * n as f64)).collect();
    let problem = InitialValueProblem { settings: &settings, initial: &start, pressures: &pressures };
    solver.record_at(&problem, times, memory).unwrap()
}

fn loss_of_state(n: usize, state: &State) -> (f64, LossGradient) {
    if !n.is_multiple_of(2) {
        return (0.0, LossGradient::default());
    }
    let w = |at: usize| (0.37 * at as f64 + n as f64).sin();
    let value = state.displacement.iter().enumerate().map(|(at, u)| w(at) * u + 20.0 * u * u).sum::<f64>();
    let displacement = state.displacement.iter().enumerate().map(|(at, u)| w(at) + 40.0 * u).collect();
    (value, LossGradient { displacement, velocity: Vec::new() })
}

fn loss(solver: &mut Solver, system: &System, at: [f64; 10], motion: Motion) -> f64 {
    let made = record(solver, system, at, motion);
    let (mut sum, mut n) = (0.0, 0);
    let mut see = |_: f64, state: &State| {
        sum += loss_of_state(n, state).0;
        n += 1;
    };
    solver.replay(&made, &mut see).unwrap();
    sum
}

fn adjoint(solver: &mut Solver, system: &System, motion: Motion) -> [f64; 10] {
    let made = record(solver, system, AT, motion);
    assert_eq!(made.segments() > 1, motion.memory < PLENTY, "checkpoints");
    let found: MotionGradient = solver.trajectory_adjoint(&made, &mut |n, state| loss_of_state(n, state).1).unwrap();
    let region = found.regions[0];
    let [[g, time], [h, later]] = found.relaxation[0][..] else { panic!("two branches") };
    let by_strength: Vec<f64> = found.relaxation[1].iter().map(|by| by[0]).collect();
    let springpot = solver.properties()[1].relaxation.springpot_gradient(&by_strength).unwrap();
    let [second, third] = region.stiffening;
    let (e, nu) = (region.youngs_modulus, region.poissons_ratio);
    [e, nu, second, third, g, time, h, later, springpot[0], springpot[1]]
}

fn forward(solver: &mut Solver, system: &System, motion: Motion) -> [f64; 10] {
    let made = record(solver, system, AT, motion);
    let mut states = Vec::new();
    solver.replay(&made, &mut |_, state: &State| states.push(state.clone())).unwrap();
    let mut sums = [0.0; 10];
    let mut see = |n: usize, all: &[&State]| {
        let by = loss_of_state(n, &states[n]).1.displacement;
        for (sum, derivative) in sums.iter_mut().zip(all) {
            *sum += by.iter().zip(&derivative.displacement).map(|(a, b)| a * b).sum::<f64>();
        }
    };
    solver.trajectory_sensitivity(&made, &PARAMETERS, &mut see).unwrap();
    sums
}

#[test]
fn adjoint_and_forward_sensitivity_through_histories_agree_with_each_other_and_with_differences() {
    let system = system();
    for motion in MOTIONS {
        let mut solver = system.solver();
        let (by_adjoint, by_sensitivity) =
            (adjoint(&mut solver, &system, motion), forward(&mut solver, &system, motion));
        for n in 0..10 {
            let mut value = |part: f64| {
                let mut at = AT;
                at[n] *= 1.0 + part;
                loss(&mut solver, &system, at, motion)
            };
            let h = 4e-3;
            let coarse = (value(h) - value(-h)) / (2.0 * h * AT[n]);
            let fine = (value(0.5 * h) - value(-0.5 * h)) / (h * AT[n]);
            let difference = (4.0 * fine - coarse) / 3.0;
            let what = format!(
                "{:?} {:?}: {} {} {difference}",
                motion.scheme, PARAMETERS[n], by_adjoint[n], by_sensitivity[n]
            );
            assert!((by_adjoint[n] / by_sensitivity[n] - 1.0).abs() < 1e-6, "{what}");
            assert!((by_adjoint[n] / difference - 1.0).abs() < 1e-6, "{what}");
        }
    }
}

/// The remainder of the linear prediction along all parameters at once falls with the square of the step.
#[test]
fn taylors_remainder_falls_with_slope_two() {
    let system = system();
    for motion in MOTIONS {
        let mut solver = system.solver();
        let slope: f64 = adjoint(&mut solver, &system, motion).iter().zip(AT).map(|(by, at)| by * at * 0.3).sum();
        let mut value = |part: f64| loss(&mut solver, &system, AT.map(|x| x * (1.0 + 0.3 * part)), motion);
        let start = value(0.0);
        let remainder = [0.08, 0.04, 0.02, 0.01].map(|part| (value(part) - start - part * slope).abs());
        let order = (remainder[2] / remainder[3]).log2();
        assert!((order - 2.0).abs() < 0.05, "{:?}: {order} {remainder:?}", motion.scheme);
    }
}
