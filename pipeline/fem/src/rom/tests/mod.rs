//! The reduced model against the full model: volumes, forces and their derivatives, equilibria and motion.

mod statics;

use nalgebra::DVector;

use super::elastic_forces::ReducedTangent;
use super::step::{LONGEST, Step};
use super::{
    Actuation, ExternalForce, NoForce, ReducedModel, ReducedModelData, ReducedMotion, ReductionSettings, StepState,
};
use crate::dynamics::stencil::Stencil;
use crate::{
    Chamber, Clamps, DynamicSettings, Elements, Faces, InitialValueProblem, Mesh, RegionProperties, Relaxation, Scheme,
    Springpot, State, StaticSettings, System,
};
use crate::{box_mesh, materials};

/// A clamped beam with a cavity: a box without its inner cells.
fn hollow() -> System {
    let solid = box_mesh::quadratic([0.06, 0.02, 0.02], [6, 4, 4]);
    let Elements::Quadratic(tets) = &solid.elements else { panic!("10-node elements") };
    let inside = |tet: &[u32; 10]| {
        let middle = |axis: usize| tet[..4].iter().map(|n| solid.nodes[*n as usize][axis]).sum::<f64>() / 4.0;
        let within = |x: f64, [low, high]: [f64; 2]| low < x && x < high;
        within(middle(0), [0.01, 0.05]) && within(middle(1), [0.01, 0.015]) && within(middle(2), [0.005, 0.015])
    };
    let (removed, solid_tets): (Vec<[u32; 10]>, Vec<[u32; 10]>) = tets.iter().partition(|tet| inside(tet));
    let mesh = without_unused_nodes(Mesh {
        regions: vec![0; solid_tets.len()],
        chambers: vec![Chamber { faces: Faces::Quadratic(skin(&removed)) }],
        elements: Elements::Quadratic(solid_tets),
        ..solid
    });
    let material = materials::by_name("neo_hookean").expect("a law of this crate");
    let rubber = RegionProperties::elastic(material, 2e5, 0.45, 1000.0);
    let clamps = Clamps::below_x(&mesh, 1e-9);
    System::new(mesh, vec![rubber], clamps).expect("a beam with a cavity")
}

/// Faces of only one of `tets`, with normals into them.
fn skin(tets: &[[u32; 10]]) -> Vec<[u32; 6]> {
    let faces = [[0, 1, 2, 4, 5, 6], [0, 3, 1, 7, 8, 4], [1, 3, 2, 8, 9, 5], [0, 2, 3, 6, 9, 7]];
    let tet_faces: Vec<[u32; 6]> = tets.iter().flat_map(|t| faces.map(|f| f.map(|i| t[i]))).collect();
    let key = |face: &[u32; 6]| {
        let mut key = [face[0], face[1], face[2]];
        key.sort_unstable();
        key
    };
    tet_faces
        .iter()
        .filter(|face| tet_faces.iter().filter(|other| key(other) == key(face)).count() == 1)
        .copied()
        .collect()
}

fn without_unused_nodes(mesh: Mesh) -> Mesh {
    let Elements::Quadratic(tets) = &mesh.elements else { panic!("10-node elements") };
    let mut used = vec![u32::MAX; mesh.nodes.len()];
    let mut nodes = Vec::new();
    let mut number = |node: u32| {
        if used[node as usize] == u32::MAX {
            used[node as usize] = nodes.len() as u32;
            nodes.push(mesh.nodes[node as usize]);
        }
        used[node as usize]
    };
    let tets = tets.iter().map(|tet| tet.map(&mut number)).collect();
    let faces = |chamber: &Chamber| match &chamber.faces {
        Faces::Quadratic(faces) => faces.clone(),
        Faces::Linear(_) | Faces::QuadraticQuadrilaterals(_) => panic!("6-node faces"),
    };
    let chambers: Vec<Vec<[u32; 6]>> = mesh.chambers.iter().map(faces).collect();
    let renumbered = chambers.iter().map(|faces| faces.iter().map(|f| f.map(&mut number)).collect());
    let chambers = renumbered.map(|faces| Chamber { faces: Faces::Quadratic(faces) }).collect();
    Mesh { nodes, elements: Elements::Quadratic(tets), chambers, ..mesh }
}

#[test]
fn the_gradient_of_one_step_is_that_of_differences() {
    use super::{ReducedState, ReducedStep};
    let system = hollow();
    let snapshots = snapshots(&system);
    let snapshots: Vec<&[f64]> = snapshots.iter().map(Vec::as_slice).collect();
    let model = system.reduce(&snapshots, &ReductionSettings::default()).expect("a reduced model");
    let r = model.coordinates();
    let dynamic =
        DynamicSettings { step: 4e-3, mass_damping: 2.0, stiffness_damping: 1e-3, ..DynamicSettings::default() };
    let wave = |part: f64, by: f64| DVector::from_fn(r, |n, _| part * (by * n as f64 + 0.3).sin());
    let size = model.size;
    let start = ReducedState { coordinates: wave(0.1 * size, 0.7), velocity: wave(2.0 * size, 1.9) };
    let loss = ReducedState { coordinates: wave(1.0, 2.3), velocity: wave(0.01, 0.9) };
    let value = |state: &ReducedState, pressure: f64, scale: f64| {
        let reduced_step = ReducedStep { settings: &dynamic, pressures: &[pressure], modulus_scale: &[scale] };
        let next_state = model.step(state, &reduced_step).expect("a step");
        (next_state.coordinates.dot(&loss.coordinates) + next_state.velocity.dot(&loss.velocity), next_state)
    };
    let (pressure, scale) = (1.5e4, 1.1);
    let next_state = value(&start, pressure, scale).1;
    let reduced_step = ReducedStep { settings: &dynamic, pressures: &[pressure], modulus_scale: &[scale] };
    let gradient = model.step_gradient((&start, &next_state), &reduced_step, &loss).expect("a gradient");
    let assert_close = |by: f64, difference: f64| assert!((by / difference - 1.0).abs() < 1e-5, "{by} {difference}");
    assert_close(
        gradient.pressures[0],
        (value(&start, pressure + 5.0, scale).0 - value(&start, pressure - 5.0, scale).0) / 10.0,
    );
    assert_close(
        gradient.modulus_scale[0],
        (value(&start, pressure, 1.101).0 - value(&start, pressure, 1.099).0) / 2e-3,
    );
    let shifted = |sign: f64, which: bool| {
        let mut state = start.clone();
        let entry = if which { &mut state.velocity[0] } else { &mut state.coordinates[0] };
        *entry += sign * 1e-4 * size;
        value(&state, pressure, scale).0
    };
    assert_close(gradient.state.coordinates[0], (shifted(1.0, false) - shifted(-1.0, false)) / (2e-4 * size));
    assert_close(gradient.state.velocity[0], (shifted(1.0, true) - shifted(-1.0, true)) / (2e-4 * size));
}

/// Equilibria under rising pressures, with lateral gravity or without.
fn snapshots(system: &System) -> Vec<Vec<f64>> {
    let mut snapshots = Vec::new();
    let count = system.mesh().nodes.len();
    for pull in [0.0, -20.0, 20.0] {
        let mut solver = system.solver();
        solver.set_gravity([0.0, pull, 0.0]).expect("finite gravity");
        for pressure in [0.0, 8e3, 1.6e4, 2.4e4, 3.2e4, 4e4] {
            if pressure != 0.0 || pull != 0.0 {
                let start =
                    snapshots.last().filter(|_| pressure > 0.0).cloned().unwrap_or_else(|| vec![0.0; 3 * count]);
                let equilibrium = solver.equilibrium(&[pressure], Some(&start), &StaticSettings::default());
                snapshots.push(equilibrium.expect("a moderate load").displacement);
            }
        }
    }
    snapshots
}

fn reduced(system: &System, snapshots: &[Vec<f64>]) -> ReducedModel {
    let snapshots: Vec<&[f64]> = snapshots.iter().map(Vec::as_slice).collect();
    let settings = ReductionSettings { coordinates: 14, tolerance: 1e-4, ..ReductionSettings::default() };
    system.reduce(&snapshots, &settings).expect("snapshots")
}

fn some_coordinates(r: usize, size: f64) -> DVector<f64> {
    DVector::from_fn(r, |i, _| size * (1.0 + 2.3 * i as f64).sin())
}

/// What `of` makes of the static equations under `pressures` (Pa).
fn at_equilibrium<T>(body: &ReducedModel, pressures: &[f64], of: impl FnOnce(&Step) -> T) -> T {
    let zero = || DVector::zeros(body.coordinates());
    of(&Step {
        model: body,
        settings: &DynamicSettings::default(),
        stencil: &Stencil { gamma: 0.0, weights: Vec::new() },
        pressures,
        acting: &body.elastic(&[1.0]),
        contact: None,
        external: &NoForce,
        time: 0.0,
        past: [zero(), zero(), zero()],
    })
}

#[test]
fn a_step_that_is_far_too_short_is_doubled_to_where_the_slope_has_fallen() {
    let system = hollow();
    let body = reduced(&system, &snapshots(&system));
    let undeformed = DVector::zeros(body.coordinates());
    let equilibrium = body.equilibrium(&[2e4], &[1.0], &undeformed).expect("a moderate load");
    let (short, mut residual) = (&equilibrium * -1e-2, undeformed.clone());
    let [whole, doubled] = at_equilibrium(&body, &[2e4], |equations| {
        residual = equations.residual(&undeformed);
        [1.0, LONGEST].map(|longest| equations.line_search(&undeformed, &short, &residual, longest))
    });
    let start = residual.norm();
    assert_eq!(whole.0, 1.0);
    assert!(doubled.0 == 64.0 || doubled.0 == 128.0, "{}", doubled.0);
    assert!(doubled.1.dot(&short).abs() <= 0.5 * residual.dot(&short) && whole.1.norm() > 0.9 * start);
}

#[test]
fn where_the_guess_leads_nowhere_a_step_begins_at_the_shape_before() {
    let system = hollow();
    let body = reduced(&system, &snapshots(&system));
    let undeformed = DVector::zeros(body.coordinates());
    let [before, wanted] = [1.5e4, 2e4].map(|p| body.equilibrium(&[p], &[1.0], &undeformed).expect("a moderate load"));
    let far = some_coordinates(body.coordinates(), 100.0 * body.size);
    let solution = at_equilibrium(&body, &[2e4], |equations| {
        assert!(equations.full_steps(&far, &before, &mut None).is_none());
        equations.solve(&far, &before, &mut None).expect("the shape before is near")
    });
    assert!((solution - wanted).amax() < 1e-7 * body.size);
}

#[test]
fn the_volume_of_a_chamber_is_its_cubic_polynomial() {
    let system = hollow();
    let body = reduced(&system, &snapshots(&system));
    let q = some_coordinates(body.coordinates(), 0.3 * body.size);
    let full = system.chamber_volume(0, &body.displacement(&q));
    assert!((body.chamber_volume(0, &q) / full - 1.0).abs() < 1e-10);
}

#[test]
fn the_projection_of_a_displacement_in_the_span_has_its_coordinates() {
    let system = hollow();
    let body = reduced(&system, &snapshots(&system));
    let q = some_coordinates(body.coordinates(), 0.3 * body.size);
    assert!((body.projected(&body.displacement(&q)) - &q).amax() < 1e-9 * q.amax());
}

#[test]
fn the_sampled_points_give_the_forces_of_all_points() {
    let system = hollow();
    let snapshots = snapshots(&system);
    let body = reduced(&system, &snapshots);
    assert!(body.points()[0] < 300, "{:?} points", body.points());
    let midpoint = |pair: &[Vec<f64>]| pair[0].iter().zip(&pair[1]).map(|(a, b)| 0.5 * (a + b)).collect();
    let unseen: Vec<Vec<f64>> = snapshots.windows(2).map(midpoint).collect();
    for u in snapshots.iter().step_by(4).chain(unseen.iter().step_by(3)) {
        let q = coordinates_of(&body, &system, u);
        let projection = body.displacement(&q);
        let full_forces = body.modes.tr_mul(&DVector::from_vec(system.solver().state.elastic_forces(&projection)));
        let sampled = body.acting_forces(&q, &body.elastic(&[1.0]));
        assert!(
            (&sampled - &full_forces).norm() < 0.01 * full_forces.norm(),
            "{} of {}",
            (&sampled - &full_forces).norm(),
            full_forces.norm()
        );
    }
}

/// q of the nearest V q in the mass metric.
fn coordinates_of(body: &ReducedModel, system: &System, u: &[f64]) -> DVector<f64> {
    let data = &system.data;
    let free = data.pattern.gather(u);
    let mut image = vec![0.0; free.len()];
    data.mass.multiply(&data.pattern, &free, &mut image);
    let mut full = vec![0.0; u.len()];
    data.pattern.scatter(&image, 1.0, &mut full);
    let right_hand_side = body.modes.tr_mul(&DVector::from_vec(full));
    body.mass.clone().lu().solve(&right_hand_side).expect("the mass is positive definite")
}

#[test]
fn between_its_snapshots_the_equilibrium_is_that_of_the_full_model() {
    let system = hollow();
    let snapshots = snapshots(&system);
    let body = reduced(&system, &snapshots);
    let full =
        system.solver().equilibrium(&[2e4], Some(&snapshots[1]), &StaticSettings::default()).expect("a moderate load");
    let coordinates = body.equilibrium(&[2e4], &[1.0], &DVector::zeros(body.coordinates())).expect("a moderate load");
    let reduced = body.displacement(&coordinates);
    let deviation = reduced.iter().zip(&full.displacement).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    let size = full.displacement.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
    assert!(deviation < 5e-3 * size, "off by {deviation} of {size} m");
    let weights = body.points[0].weights().iter();
    let sampled: f64 =
        weights.zip(body.energy_densities(0, &coordinates)).map(|(weight, density)| weight * density).sum();
    let energy = system.solver().elastic_energy(&reduced).expect("a shape of this system");
    assert!((sampled / energy - 1.0).abs() < 0.01, "{sampled} of {energy} J");
    let repeated = body.equilibrium(&[2e4], &[1.0], &coordinates).expect("an equilibrium");
    assert!((repeated - coordinates).amax() < 1e-7 * body.size, "an equilibrium is its own solution");
}

#[test]
fn the_data_of_a_model_restore_the_same_model() {
    let system = hollow();
    let body = reduced(&system, &snapshots(&system));
    let restored = system.restore(&body.data()).expect("data of this system");
    let q = some_coordinates(body.coordinates(), 0.2 * body.size);
    assert_eq!(restored.acting_forces(&q, &restored.elastic(&[1.3])), body.acting_forces(&q, &body.elastic(&[1.3])));
    assert_eq!(restored.mass, body.mass);
    assert_eq!(restored.chamber_volume(0, &q), body.chamber_volume(0, &q));
    assert_eq!(restored.data(), body.data());
}

#[test]
fn data_of_another_system_are_refused() {
    let system = hollow();
    let data = reduced(&system, &snapshots(&system)).data();
    let refused = |data: ReducedModelData, of: &str| {
        let error = system.restore(&data).expect_err("foreign data").to_string();
        assert!(error.contains(of), "{error}");
    };
    refused(ReducedModelData { modes: vec![vec![0.0; 3]], ..data.clone() }, "3 per node");
    refused(ReducedModelData { points: Vec::new(), ..data.clone() }, "points of 0 regions");
    refused(ReducedModelData { points: vec![vec![(u32::MAX, 1e-9)]], ..data.clone() }, "is not in region 0");
    for weight in [f64::NAN, 0.0, -1e-9] {
        refused(ReducedModelData { points: vec![vec![(0, weight)]], ..data.clone() }, "is not in region 0");
    }
    refused(ReducedModelData { size: f64::NAN, ..data.clone() }, "not finite");
}

#[test]
fn the_data_of_a_model_have_no_fault_and_damaged_ones_name_theirs() {
    let system = hollow();
    let data = reduced(&system, &snapshots(&system)).data();
    assert_eq!(data.fault(), None);
    let damaged = |damage: &dyn Fn(&mut ReducedModelData)| {
        let mut damaged = data.clone();
        damage(&mut damaged);
        damaged.fault().expect("a fault")
    };
    assert!(damaged(&|data| data.modes.clear()).contains("0 modes"));
    assert!(damaged(&|data| data.modes[0].truncate(4)).contains("3 numbers per node"));
    assert!(damaged(&|data| data.modes[0][5] = f64::NAN).contains("mode 0"));
    assert!(damaged(&|data| data.points[0][0].1 = f64::INFINITY).contains("must be above 0"));
    assert!(damaged(&|data| data.size = -1.0).contains("must be above 0"));
}

#[test]
fn the_stiffness_is_the_derivative_of_the_forces() {
    let system = hollow();
    let body = reduced(&system, &snapshots(&system));
    let q = some_coordinates(body.coordinates(), 0.2 * body.size);
    let direction = some_coordinates(body.coordinates(), 1.0).map(|x| x * x);
    let h = 1e-5 * body.size;
    let force = |x: f64| body.acting_forces(&(&q + &direction * x), &body.elastic(&[1.3]));
    let difference = (force(h) - force(-h)) / (2.0 * h);
    let exact = body.acting_stiffness(&q, ReducedTangent::Exact, &body.elastic(&[1.3])) * &direction;
    assert!((&difference - &exact).norm() < 1e-7 * exact.norm());
}

fn oscillating(time: f64) -> f64 {
    1.6e4 * (1.0 - (std::f64::consts::TAU * 3.0 * time).cos())
}

fn with_damping(stiffness_damping: f64) -> DynamicSettings {
    DynamicSettings { step: 1.0 / 200.0, scheme: Scheme::Bdf2, stiffness_damping, ..DynamicSettings::default() }
}

/// Displacements of the full model under an oscillating pressure, m.
fn full_motion(system: &System, damping: f64, relaxation: &Relaxation) -> Vec<Vec<f64>> {
    let (settings, rest, mut states) = (with_damping(damping), State::rest(system.mesh().nodes.len()), Vec::new());
    let pressures = |time: f64| vec![oscillating(time)];
    let problem = InitialValueProblem { settings: &settings, initial: &rest, pressures: &pressures };
    let mut solver = system.solver();
    solver.set_relaxation(0, relaxation.clone()).expect("an objective law");
    let mut keep = |_: f64, state: &State| states.push(state.displacement.clone());
    solver.integrate(&problem, 100, &mut keep).expect("a moderate load");
    states
}

/// The oscillating pressure on a body that relaxes.
fn oscillation<'a>(settings: &'a DynamicSettings, relaxation: &'a [Relaxation]) -> ReducedMotion<'a> {
    let actuation = &|time: f64| Actuation { pressures: vec![oscillating(time)] };
    ReducedMotion { settings, modulus_scale: &[1.0], relaxation, stiffening: &[], actuation }
}

/// The same of the reduced model `body`.
fn reduced_motion(body: &ReducedModel, damping: f64, relaxation: &Relaxation) -> Vec<Vec<f64>> {
    let (settings, relaxation, mut states) = (with_damping(damping), [relaxation.clone()], Vec::new());
    let motion = oscillation(&settings, &relaxation);
    let mut keep = |_: f64, q: &DVector<f64>, _: &DVector<f64>| states.push(body.displacement(q));
    body.integrate(&motion, &mut NoForce, 100, &mut keep).expect("a moderate load");
    states
}

#[test]
fn under_an_oscillating_pressure_the_reduced_model_moves_as_the_full_one() {
    let system = hollow();
    let tip = (0..system.mesh().nodes.len())
        .max_by(|a, b| system.mesh().nodes[*a][0].total_cmp(&system.mesh().nodes[*b][0]))
        .expect("nodes");
    let elastic = full_motion(&system, 0.0, &Relaxation::default());
    let shapes: Vec<Vec<f64>> = snapshots(&system).into_iter().chain(elastic.iter().step_by(7).cloned()).collect();
    let body = reduced(&system, &shapes);
    let difference = |a: &[Vec<f64>], b: &[Vec<f64>]| {
        a.iter().zip(b).fold(0.0, |most: f64, (a, b)| most.max((a[3 * tip + 1] - b[3 * tip + 1]).abs()))
    };
    let springpot = Springpot { strength: 0.06, exponent: 0.27, decades: [-3, 1] };
    let relaxing = Relaxation::springpot(springpot).expect("a spectrum of silicone");
    for (damping, relaxation) in [(0.002, Relaxation::default()), (0.0, relaxing)] {
        let full = full_motion(&system, damping, &relaxation);
        let deviation = difference(&full, &reduced_motion(&body, damping, &relaxation));
        let largest = full.iter().fold(0.0, |most: f64, u| most.max(u[3 * tip + 1].abs()));
        assert!(largest > 1e-3 && deviation < 0.01 * largest, "off by {deviation} of {largest} m");
        assert!(difference(&full, &elastic) > 0.05 * largest, "damping and relaxation matter");
    }
}

/// A force without which no step is longer than one over `rate`.
struct ShortSteps {
    rate: f64,
    accepted: usize,
}

impl ExternalForce for ShortSteps {
    fn force(&self, at: &StepState) -> DVector<f64> {
        let force = if at.gamma < self.rate { f64::NAN } else { 0.0 };
        DVector::from_element(at.coordinates.len(), force)
    }

    fn accept(&mut self, _: &StepState) {
        self.accepted += 1;
    }
}

#[test]
fn a_step_that_is_not_found_is_halved_and_observed_at_its_end_alone() {
    let system = hollow();
    let body = reduced(&system, &snapshots(&system));
    let settings = DynamicSettings { scheme: Scheme::ImplicitEuler, ..with_damping(0.002) };
    let relaxation = [Relaxation::default()];
    let motion = oscillation(&settings, &relaxation);
    let times: Vec<f64> = (1..=20).map(|step| f64::from(step) * settings.step).collect();
    let quarters: Vec<f64> = (1..=80).map(|step| f64::from(step) * 0.25 * settings.step).collect();
    let simulate = |times: &[f64], rate: f64| {
        let mut states = Vec::new();
        let mut external = ShortSteps { rate, accepted: 0 };
        let mut see = |time: f64, q: &DVector<f64>, _: &DVector<f64>| states.push((time, q.clone()));
        body.integrate_at(&motion, &mut external, times, &mut see).map(|()| (states, external.accepted))
    };
    let (halved, accepted) = simulate(&times, 3.0 / settings.step).expect("quarters are short enough");
    let (fine, _) = simulate(&quarters, 0.0).expect("a moderate load");
    assert_eq!((halved.len(), accepted), (20, 80));
    for ((time, q), (at, same)) in halved.iter().zip(fine.iter().skip(3).step_by(4)) {
        assert!((time - at).abs() < 1e-12 && (q - same).amax() < 1e-6 * body.size, "{time} s");
    }
    let refused = simulate(&times, 17.0 / settings.step).expect_err("a sixteenth is the shortest");
    assert!(refused.to_string().contains("no step of the reduced model is found after 0.0000 s"), "{refused}");
}

#[test]
fn relaxations_of_another_number_of_regions_are_refused() {
    let system = hollow();
    let body = reduced(&system, &snapshots(&system));
    let none = [Relaxation::default(), Relaxation::default()];
    let settings = DynamicSettings::default();
    let motion = oscillation(&settings, &none);
    let refused = body.integrate(&motion, &mut NoForce, 1, &mut |_, _, _| ()).expect_err("two for one region");
    assert!(refused.to_string().contains("2 relaxations for 1 regions"), "{refused}");
}
