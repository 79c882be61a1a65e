//! Gradients of a motion against differences of motions, by the adjoint and by forward sensitivity, stored whole and in checkpoint segments.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::{
    Clamps, DynamicSettings, Forces, InitialValueProblem, LossGradient, Masses, Mesh, MotionGradient, Options,
    Parameter, RegionProperties, Scheme,
};
use fem::{Solver, State, System, Trajectory, box_mesh, materials};

const STEPS: usize = 12;
const STEP: f64 = 4e-3;
const PLENTY: usize = usize::MAX;

/// A bar of 60 × 20 × 20 mm, half of it meshed: a chamber beside a stiff sheet, and a weight on its end; its body uses mean
/// dilatation.
fn system() -> System {
    let air = |cell: [usize; 3]| (1..5).contains(&cell[0]) && cell[1] == 3 && cell[2] == 0;
    let position = |at: [f64; 3]| [0.06 * at[0], 0.02 * at[1] * (0.6 + 0.4 * at[1]), 0.01 * at[2]];
    let region = move |cell: [usize; 3]| if air(cell) { None } else { Some(u16::from(cell[1] == 1)) };
    let mesh = box_mesh::to_quadratic(&box_mesh::grid([6, 5, 2], true, position, region));
    let material = materials::by_name("neo_hookean").unwrap();
    let is = RegionProperties::elastic(material, 2.1e5, 0.45, 1e3);
    let clamps = Clamps::below_x(&mesh, 1e-9);
    let masses = Masses::none().on_node(far_node(&mesh) as u32, 1e-3);
    let options = Options { masses, mean_dilatation: vec![true], ..Options::default() };
    System::with(
        mesh,
        vec![is.clone(), RegionProperties { youngs_modulus: 1e7, poissons_ratio: 0.35, ..is }],
        clamps,
        options,
    )
    .unwrap()
}

fn far_node(mesh: &Mesh) -> usize {
    (0..mesh.nodes.len()).max_by(|&a, &b| mesh.nodes[a][0].total_cmp(&mesh.nodes[b][0])).unwrap()
}

/// All numbers that a motion depends on here.
#[derive(Debug, Clone, Copy)]
struct Set {
    scheme: Scheme,
    e: [f64; 2],
    nu: [f64; 2],
    density: [f64; 2],
    alpha: f64,
    beta: f64,
    gain: f64,
    force: f64,
    start: f64,
    speed: f64,
    bump: f64,
}

const SET: Set = Set {
    scheme: Scheme::Bdf2,
    e: [2.1e5, 1e7],
    nu: [0.45, 0.35],
    density: [1e3, 1.4e3],
    alpha: 3.0,
    beta: 1e-3,
    gain: 1.0,
    force: 0.01,
    start: 2e-4,
    speed: 0.05,
    bump: 200.0,
};

/// The one step whose pressure is higher by `bump`, Pa.
const BUMPED: usize = 5;

fn settings(set: Set) -> DynamicSettings {
    let Set { scheme, alpha, beta, .. } = set;
    DynamicSettings { step: STEP, scheme, mass_damping: alpha, stiffness_damping: beta, tolerance: 5e-12 }
}

fn give(solver: &mut Solver, mesh: &Mesh, set: Set) -> State {
    for region in 0..2 {
        solver.set_elastic(region, set.e[region], set.nu[region]).unwrap();
        solver.set_density(region, set.density[region]).unwrap();
    }
    solver.set_gravity([2.0, 5.0, 0.0]).unwrap();
    let node = far_node(mesh);
    solver.set_forces(Forces::none(mesh).on_node(node as u32, [0.0, set.force, 0.0]).unwrap().as_slice()).unwrap();
    // a bend that grows with the square of the way from the clamp
    let bend = |at: &[f64; 3]| [0.0, (at[0] / 0.06).powi(2), 0.0];
    let mut start = State::rest(mesh.nodes.len());
    start.displacement = mesh.nodes.iter().flat_map(|at| bend(at).map(|x| set.start * x)).collect();
    start.velocity = mesh.nodes.iter().flat_map(|at| bend(at).map(|x| set.speed * x)).collect();
    start
}

fn record(solver: &mut Solver, mesh: &Mesh, set: Set, steps: usize, memory: usize) -> Trajectory {
    let start = give(solver, mesh, set);
    let bump = move |time: f64| if (time / STEP).round() as usize == BUMPED { set.bump } else { 0.0 };
    let beat = move |time: f64| vec![set.gain * (8e3 * (1.0 + (40.0 * time).sin()) + bump(time))];
    solver
        .record(&InitialValueProblem { settings: &settings(set), initial: &start, pressures: &beat }, steps, memory)
        .unwrap()
}

/// A crooked loss of all states: Σₙ (w · uₙ + 20 |uₙ|²) + 0.01 z · vₙ over every third state and the last.
fn loss_of_state(n: usize, state: &State) -> (f64, LossGradient) {
    if !n.is_multiple_of(3) {
        return (0.0, LossGradient::default());
    }
    let (w, z) = (|at: usize| (0.37 * at as f64 + n as f64).sin(), |at: usize| 0.01 * (0.61 * at as f64).cos());
    let value = state.displacement.iter().enumerate().map(|(at, u)| w(at) * u + 20.0 * u * u).sum::<f64>()
        + state.velocity.iter().enumerate().map(|(at, v)| z(at) * v).sum::<f64>();
    let displacement = state.displacement.iter().enumerate().map(|(at, u)| w(at) + 40.0 * u).collect();
    (value, LossGradient { displacement, velocity: (0..state.velocity.len()).map(z).collect() })
}

fn loss(solver: &mut Solver, mesh: &Mesh, set: Set) -> f64 {
    let trajectory = record(solver, mesh, set, STEPS, PLENTY);
    let (mut sum, mut n) = (0.0, 0);
    let mut see = |_: f64, state: &State| {
        sum += loss_of_state(n, state).0;
        n += 1;
    };
    solver.replay(&trajectory, &mut see).unwrap();
    sum
}

fn gradient(solver: &mut Solver, mesh: &Mesh, set: Set, memory: usize) -> MotionGradient {
    let trajectory = record(solver, mesh, set, STEPS, memory);
    solver.trajectory_adjoint(&trajectory, &mut |n, state| loss_of_state(n, state).1).unwrap()
}

/// (name, the number, what the gradient says, step of the difference as a part of the number)
type Case = (&'static str, fn(&mut Set) -> &mut f64, fn(&MotionGradient, &Mesh) -> f64, f64);

/// Σ over the bend of `give`.
fn along_bend(list: &[f64], mesh: &Mesh) -> f64 {
    mesh.nodes.iter().enumerate().map(|(node, at)| list[3 * node + 1] * (at[0] / 0.06).powi(2)).sum()
}

const CASES: [Case; 13] = [
    ("E body", |set| &mut set.e[0], |by, _| by.regions[0].youngs_modulus, 2e-3),
    ("E sheet", |set| &mut set.e[1], |by, _| by.regions[1].youngs_modulus, 2e-3),
    ("ν body", |set| &mut set.nu[0], |by, _| by.regions[0].poissons_ratio, 4e-4),
    ("ν sheet", |set| &mut set.nu[1], |by, _| by.regions[1].poissons_ratio, 4e-4),
    ("ρ body", |set| &mut set.density[0], |by, _| by.regions[0].density, 2e-3),
    ("ρ sheet", |set| &mut set.density[1], |by, _| by.regions[1].density, 2e-3),
    ("α", |set| &mut set.alpha, |by, _| by.mass_damping, 1e-2),
    ("β", |set| &mut set.beta, |by, _| by.stiffness_damping, 1e-2),
    ("gain", |set| &mut set.gain, |by, _| by.pressure_gains[0], 2e-3),
    ("force", |set| &mut set.force, |by, mesh| by.forces[3 * far_node(mesh) + 1], 2e-2),
    ("start", |set| &mut set.start, |by, mesh| along_bend(&by.initial.displacement, mesh), 2e-2),
    ("speed", |set| &mut set.speed, |by, mesh| along_bend(&by.initial.velocity, mesh), 2e-2),
    ("p at one time", |set| &mut set.bump, |by, _| by.pressures[BUMPED - 1][0], 0.5),
];

#[test]
fn the_adjoint_agrees_with_converged_central_differences_for_every_parameter() {
    let system = system();
    let mesh = system.mesh();
    for scheme in [Scheme::ImplicitEuler, Scheme::Bdf2] {
        let set = Set { scheme, ..SET };
        let adjoint = gradient(&mut system.solver(), mesh, set, PLENTY);
        let mut solver = system.solver();
        for (name, number, of, part) in CASES {
            let mut perturbed = set;
            let value = *number(&mut perturbed);
            let mut loss_at = |value: f64| {
                *number(&mut perturbed) = value;
                loss(&mut solver, mesh, perturbed)
            };
            let h = part * value;
            let difference = (8.0 * (loss_at(value + h) - loss_at(value - h))
                - (loss_at(value + 2.0 * h) - loss_at(value - 2.0 * h)))
                / (12.0 * h);
            let exact = of(&adjoint, mesh);
            assert!((exact / difference - 1.0).abs() < 1e-6, "{scheme:?} {name}: {exact:e} {difference:e}");
        }
    }
}

#[test]
fn forward_sensitivities_agree_with_the_adjoint() {
    let system = system();
    let mesh = system.mesh();
    let (node, axis) = (far_node(mesh), 1);
    let mut solver = system.solver();
    let trajectory = record(&mut solver, mesh, SET, STEPS, PLENTY);
    let adjoint = solver.trajectory_adjoint(&trajectory, &mut |n, state| loss_of_state(n, state).1).unwrap();
    let cases = [
        (Parameter::YoungsModulus(1), adjoint.regions[1].youngs_modulus),
        (Parameter::PoissonsRatio(0), adjoint.regions[0].poissons_ratio),
        (Parameter::Density(0), adjoint.regions[0].density),
        (Parameter::Pressure(0), adjoint.pressures.iter().map(|step| step[0]).sum()),
        (Parameter::PressureGain(0), adjoint.pressure_gains[0]),
        (Parameter::Force { node, axis }, adjoint.forces[3 * node + axis]),
        (Parameter::MassDamping, adjoint.mass_damping),
        (Parameter::StiffnessDamping, adjoint.stiffness_damping),
        (Parameter::InitialDisplacement { node, axis }, adjoint.initial.displacement[3 * node + axis]),
        (Parameter::InitialVelocity { node, axis }, adjoint.initial.velocity[3 * node + axis]),
    ];
    let mut slopes = Vec::new();
    let mut see = |_: f64, state: &State| slopes.push(loss_of_state(slopes.len(), state).1);
    solver.replay(&trajectory, &mut see).unwrap();
    let mut sums = [0.0; 10];
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut add = |n: usize, changes: &[&State]| {
        for (sum, change) in sums.iter_mut().zip(changes) {
            *sum += dot(&slopes[n].displacement, &change.displacement) + dot(&slopes[n].velocity, &change.velocity);
        }
    };
    solver.trajectory_sensitivity(&trajectory, &cases.map(|(parameter, _)| parameter), &mut add).unwrap();
    for ((parameter, backward), forward) in cases.iter().zip(sums) {
        assert!((forward / backward - 1.0).abs() < 1e-7, "{parameter:?} {forward:e} {backward:e}");
    }
}

#[test]
fn the_gradient_of_a_motion_passes_the_taylor_test() {
    let system = system();
    let mesh = system.mesh();
    let mut solver = system.solver();
    let adjoint = gradient(&mut solver, mesh, SET, PLENTY);
    let value = loss(&mut solver, mesh, SET);
    let turn = [0.3 * SET.e[0], -0.2 * SET.e[1], -0.04, 2e2, 0.3];
    let directional_derivative = adjoint.regions[0].youngs_modulus * turn[0]
        + adjoint.regions[1].youngs_modulus * turn[1]
        + adjoint.regions[0].poissons_ratio * turn[2]
        + adjoint.regions[1].density * turn[3]
        + adjoint.pressure_gains[0] * turn[4];
    let remainders = [0.02, 0.01, 0.005].map(|step: f64| {
        let mut perturbed = SET;
        perturbed.e = [SET.e[0] + step * turn[0], SET.e[1] + step * turn[1]];
        perturbed.nu[0] += step * turn[2];
        perturbed.density[1] += step * turn[3];
        perturbed.gain += step * turn[4];
        (loss(&mut solver, mesh, perturbed) - value - step * directional_derivative).abs()
    });
    for pair in remainders.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 2.0).abs() < 0.05, "{order} {remainders:?}");
    }
}

#[test]
fn a_motion_in_checkpoint_segments_has_the_same_states_and_gradient() {
    let system = system();
    let mesh = system.mesh();
    let mut solver = system.solver();
    let state = 16 * 3 * mesh.nodes.len();
    let (steps, memory) = (40, 22 * state);
    let cut = record(&mut solver, mesh, SET, steps, memory);
    assert!(cut.segments() > 1, "{}", cut.segments());
    let (mut one, mut two) = (Vec::new(), Vec::new());
    solver.replay(&cut, &mut |_, state| one.push(state.clone())).unwrap();
    solver.replay(&cut, &mut |_, state| two.push(state.clone())).unwrap();
    assert!(one == two && one.len() == steps + 1, "a segment is recomputed to the byte");
    let mut gradient =
        |made: &Trajectory| solver.trajectory_adjoint(made, &mut |n, state| loss_of_state(n, state).1).unwrap();
    let cut = gradient(&cut);
    let mut second_solver = system.solver();
    let full_trajectory = record(&mut second_solver, mesh, SET, steps, PLENTY);
    let full_gradient = gradient(&full_trajectory);
    let is_near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-7;
    assert!(is_near(full_gradient.regions[0].youngs_modulus, cut.regions[0].youngs_modulus));
    assert!(is_near(full_gradient.regions[1].density, cut.regions[1].density));
    assert!(is_near(full_gradient.stiffness_damping, cut.stiffness_damping));
    let start = give(&mut solver, mesh, SET);
    let refused = solver
        .record(
            &InitialValueProblem { settings: &settings(SET), initial: &start, pressures: &|_| vec![0.0] },
            steps,
            3 * state,
        )
        .unwrap_err();
    assert!(refused.to_string().contains("memory"), "{refused}");
}
