//! Reduced models of hexahedra of second order, whose energy is shared between two sets of points, against the full model.

use fem::{
    Actuation, Clamps, DynamicSettings, InitialValueProblem, NoForce, Options, ReducedModel, ReducedMotion,
    ReducedState, ReducedStep, ReductionSettings, RegionProperties, Relaxation, Scheme, Springpot, State,
    StaticSettings, System, box_mesh, materials,
};
use nalgebra::DVector;

/// Share of the μ part at 3³ points.
const SHARE: f64 = 0.2;

/// A clamped beam with a chamber beside its axis, in the law named.
fn hollow_beam(law: &str) -> System {
    let air = |cell: [usize; 3]| (1..5).contains(&cell[0]) && cell[1] == 2 && cell[2] == 0;
    let place = |at: [f64; 3]| [0.06 * at[0], 0.02 * at[1], 0.01 * at[2]];
    let mesh = box_mesh::quadratic_hexahedra([6, 4, 2], true, place, |cell| (!air(cell)).then_some(0));
    let rubber = RegionProperties {
        stiffening: [0.1, 0.3],
        ..RegionProperties::elastic(materials::by_name(law).expect("a law of this name"), 2e5, 0.45, 1000.0)
    };
    let clamps = Clamps::below_x(&mesh, 1e-9);
    let options = Options { shear_share: Some(SHARE), ..Options::default() };
    System::with(mesh, vec![rubber], clamps, options).expect("a beam with a chamber")
}

/// Equilibria under rising pressures, with lateral gravity or without.
fn snapshots(system: &System) -> Vec<Vec<f64>> {
    let mut shapes: Vec<Vec<f64>> = Vec::new();
    for pull in [0.0, -20.0, 20.0] {
        let mut solver = system.solver();
        solver.set_gravity([0.0, pull, 0.0]).expect("finite gravity");
        for pressure in [6e3, 1.2e4, 1.8e4, 2.4e4] {
            let nearby = shapes.last().filter(|_| pressure > 6e3).cloned();
            let found = solver.equilibrium(&[pressure], nearby.as_deref(), &StaticSettings::default());
            shapes.push(found.expect("a moderate load").displacement);
        }
    }
    shapes
}

fn reduced(system: &System, shapes: &[Vec<f64>]) -> ReducedModel {
    let shapes: Vec<&[f64]> = shapes.iter().map(Vec::as_slice).collect();
    let settings = ReductionSettings { coordinates: 12, tolerance: 1e-4, ..ReductionSettings::default() };
    system.reduce(&shapes, &settings).expect("snapshots")
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |most, value| most.max(value.abs()))
}

fn largest_difference(left: &[f64], right: &[f64]) -> f64 {
    largest(left.iter().zip(right).map(|(left, right)| left - right))
}

#[test]
fn the_two_sets_of_points_have_their_shares_of_the_moduli() {
    let system = hollow_beam("lopez_pamies");
    let body = reduced(&system, &snapshots(&system));
    let arrays = body.arrays();
    let [whole, sampled] = [system.regions()[0].moduli(), arrays.regions[0].moduli];
    let shares: Vec<[f64; 2]> =
        arrays.regions.iter().map(|group| [group.moduli.mu / whole.mu, group.moduli.lambda / whole.lambda]).collect();
    assert_eq!((arrays.regions.len(), sampled.stiffening[0] / whole.stiffening[0]), (2, shares[0][0]));
    let mut sorted = shares.clone();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]));
    assert!((sorted[0][0] - SHARE).abs() < 1e-12 && sorted[0][1] == 0.0, "{shares:?}");
    assert!((sorted[1][0] - (1.0 - SHARE)).abs() < 1e-12 && sorted[1][1] == 1.0, "{shares:?}");
    assert_eq!(body.points(), [arrays.regions.iter().map(|group| group.weights.len()).sum::<usize>()]);
}

#[test]
fn between_its_snapshots_the_equilibrium_and_its_energy_are_those_of_the_full_model() {
    for law in ["lopez_pamies", "neo_hookean", "yeoh"] {
        let system = hollow_beam(law);
        let shapes = snapshots(&system);
        let body = reduced(&system, &shapes);
        let full = system.solver().equilibrium(&[1.5e4], Some(&shapes[1]), &StaticSettings::default());
        let full = full.expect("a moderate load").displacement;
        let q = body.equilibrium(&[1.5e4], &[1.0], &DVector::zeros(body.coordinates())).expect("a moderate load");
        let shape = body.displacement(&q);
        let size = largest(full.iter().copied());
        assert!(largest_difference(&shape, &full) < 5e-3 * size, "{law}: {}", largest_difference(&shape, &full) / size);
        let weights = body.arrays().regions.iter().flat_map(|group| group.weights.to_vec()).collect::<Vec<_>>();
        let sampled: f64 =
            weights.iter().zip(body.energy_densities(0, &q)).map(|(weight, density)| weight * density).sum();
        let energy = system.solver().elastic_energy(&shape).expect("a shape of this system");
        assert!((sampled / energy - 1.0).abs() < 0.01, "{law}: {sampled} of {energy} J");
        let again = system.restore(&body.data()).expect("data of this system");
        assert_eq!(again.displacement(&again.equilibrium(&[1.5e4], &[1.0], &q).expect("its own")), {
            body.displacement(&body.equilibrium(&[1.5e4], &[1.0], &q).expect("its own"))
        });
    }
}

#[test]
fn it_relaxes_in_motion_as_the_full_model() {
    let system = hollow_beam("lopez_pamies");
    let spectrum = Relaxation::springpot(Springpot { strength: 0.06, exponent: 0.27, decades: [-3, 1] });
    let relaxation = [spectrum.expect("a spectrum of silicone")];
    let settings = DynamicSettings { step: 5e-3, scheme: Scheme::Bdf2, ..DynamicSettings::default() };
    let oscillating = |time: f64| vec![8e3 * (1.0 - (std::f64::consts::TAU * 3.0 * time).cos())];
    let (rest, mut full) = (State::rest(system.mesh().nodes.len()), Vec::new());
    let problem = InitialValueProblem { settings: &settings, initial: &rest, pressures: &oscillating };
    let mut solver = system.solver();
    solver.set_relaxation(0, relaxation[0].clone()).expect("an objective law");
    let mut record = |_: f64, state: &State| full.push(state.displacement.clone());
    solver.integrate(&problem, 70, &mut record).expect("a moderate load");
    let shapes: Vec<Vec<f64>> = snapshots(&system).into_iter().chain(full.iter().step_by(5).cloned()).collect();
    let body = reduced(&system, &shapes);
    let moved = |relaxation: &[Relaxation]| {
        let actuation = |time: f64| Actuation { pressures: oscillating(time) };
        let motion = ReducedMotion {
            settings: &settings,
            modulus_scale: &[1.0],
            relaxation,
            stiffening: &[],
            actuation: &actuation,
        };
        let mut states: Vec<Vec<f64>> = Vec::new();
        let mut record = |_: f64, q: &DVector<f64>, _: &DVector<f64>| states.push(body.displacement(q));
        body.integrate(&motion, &mut NoForce, 70, &mut record).expect("a moderate load");
        states
    };
    let off =
        |states: &[Vec<f64>]| largest(full.iter().zip(states).map(|(full, state)| largest_difference(full, state)));
    let size = largest(full.iter().flatten().copied());
    let [relaxing, elastic] = [off(&moved(&relaxation)), off(&moved(&[]))];
    assert!(relaxing < 0.01 * size && elastic > 0.03 * size, "{relaxing} and {elastic} of {size} m");
}

#[test]
fn the_gradient_of_a_step_by_the_modulus_counts_both_sets() {
    let system = hollow_beam("neo_hookean");
    let body = reduced(&system, &snapshots(&system));
    let settings = DynamicSettings { step: 4e-3, ..DynamicSettings::default() };
    let r = body.coordinates();
    let coordinates = body.equilibrium(&[8e3], &[1.0], &DVector::zeros(r)).expect("a moderate load");
    let start = ReducedState { coordinates, velocity: DVector::zeros(r) };
    let loss = ReducedState {
        coordinates: DVector::from_fn(r, |mode, _| (2.3 * mode as f64 + 0.3).sin()),
        velocity: DVector::zeros(r),
    };
    let stepped = |pressure: f64, scale: f64| {
        let given = ReducedStep { settings: &settings, pressures: &[pressure], modulus_scale: &[scale] };
        body.step(&start, &given).expect("a step")
    };
    let value = |pressure: f64, scale: f64| stepped(pressure, scale).coordinates.dot(&loss.coordinates);
    let given = ReducedStep { settings: &settings, pressures: &[1.5e4], modulus_scale: &[1.1] };
    let gradient = body.step_gradient((&start, &stepped(1.5e4, 1.1)), &given, &loss).expect("a gradient");
    let by_scale = (value(1.5e4, 1.101) - value(1.5e4, 1.099)) / 2e-3;
    let by_pressure = (value(1.5e4 + 5.0, 1.1) - value(1.5e4 - 5.0, 1.1)) / 10.0;
    assert!((gradient.modulus_scale[0] / by_scale - 1.0).abs() < 1e-5, "{} {by_scale}", gradient.modulus_scale[0]);
    assert!((gradient.pressures[0] / by_pressure - 1.0).abs() < 1e-5, "{} {by_pressure}", gradient.pressures[0]);
}
