//! Self-contact of chamber walls: a roof that suction lays on its floor.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::{
    Clamps, Contact, DynamicSettings, InitialValueProblem, LossGradient, Mesh, Options, Parameter, ReducedModel,
    ReducedSolver, ReductionSettings, RegionProperties, Scheme, SetupError, State, StaticSettings, System, box_mesh,
    materials, wedges,
};
use nalgebra::DVector;
use std::f64::consts::PI;
use std::sync::Arc;

/// Height of the chamber, m.
const HEIGHT: f64 = 0.002;
const CONTACT: Contact = Contact { range: 5e-4, pressure: 4e3 };

/// A block of 40 × 40 × 8 mm, half of it in z, whose chamber has a roof of 1 mm.
fn block(hexahedra: bool) -> Mesh {
    let air = |cell: [usize; 3]| (2..10).contains(&cell[0]) && cell[1] == 1 && cell[2] < 4;
    let levels = [0.0, 0.005, 0.005 + HEIGHT, 0.006 + HEIGHT];
    // between two levels where the middle of an edge lies
    let level =
        |at: f64| 0.5 * (levels[(3.0 * at + 0.01).floor() as usize] + levels[(3.0 * at - 0.01).ceil() as usize]);
    let place = |at: [f64; 3]| [0.04 * at[0], level(at[1]), 0.02 * at[2]];
    let region = |cell| (!air(cell)).then_some(0);
    match hexahedra {
        true => box_mesh::quadratic_hexahedra([12, 3, 6], true, place, region),
        false => box_mesh::to_quadratic(&box_mesh::grid([12, 3, 6], true, place, region)),
    }
}

/// [`block`] of rubber, its floor clamped.
fn body(contact: Option<Contact>) -> Result<System, SetupError> {
    rubber(block(false), contact)
}

fn rubber(mesh: Mesh, contact: Option<Contact>) -> Result<System, SetupError> {
    let clamps = Clamps::where_nodes(&mesh, [true; 3], |at| at[1] < 1e-9);
    let rubber = RegionProperties::elastic(materials::by_name("neo_hookean").unwrap(), 2e5, 0.45, 1070.0);
    System::with(mesh, vec![rubber], clamps, Options { contact, ..Options::default() })
}

/// The node of the wall at height `y` (m) in the middle.
fn middle(system: &System, y: f64) -> usize {
    let nodes = &system.mesh().nodes;
    let off = |n: &usize| (nodes[*n][0] - 0.02).abs() + (nodes[*n][1] - y).abs() + nodes[*n][2];
    (0..nodes.len()).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap()
}

/// Height of the chamber in the middle, m: the mean over the middles of edges in a patch. A wall is wavy between corners, whose part in the
/// mean of a face of second order is small and negative.
fn gap(system: &System, u: &[f64]) -> f64 {
    let nodes = &system.mesh().nodes;
    let half_cells = |at: [f64; 3]| [at[0] / 0.04 * 24.0, at[2] / 0.02 * 12.0].map(|x| x.round() as usize);
    let mean = |y: f64| {
        let is_middle = |at: [f64; 3]| half_cells(at).iter().sum::<usize>() % 2 == 1;
        let is_near = |at: [f64; 3]| (at[0] - 0.02).abs() + at[2] < 0.004 && (at[1] - y).abs() < 1e-9;
        let near = |n: &usize| is_near(nodes[*n]) && is_middle(nodes[*n]);
        let heights: Vec<f64> = (0..nodes.len()).filter(near).map(|n| u[3 * n + 1]).collect();
        heights.iter().sum::<f64>() / heights.len() as f64
    };
    HEIGHT + mean(0.005 + HEIGHT) - mean(0.005)
}

#[test]
fn a_roof_under_suction_comes_to_rest_where_its_floor_presses_back_as_much() {
    for mesh in [block(false), block(true), wedges::split(&block(true))] {
        press(&rubber(mesh, Some(CONTACT)).unwrap());
    }
    // without contact the roof passes through the floor
    let system = body(Some(CONTACT)).unwrap();
    let found = [body(None).unwrap(), system.without_contact()]
        .map(|without| without.solver().equilibrium(&[-1000.0], None, &StaticSettings::default()).unwrap());
    assert!(gap(&system, &found[0].displacement) < -0.5 * HEIGHT && found[0] == found[1]);
}

fn press(system: &System) {
    let mut solver = system.solver();
    assert!(!system.walls_touch(&vec![0.0; 3 * system.mesh().nodes.len()]));
    let mut start: Option<Vec<f64>> = None;
    for suction in [200.0, 1000.0, 4000.0, 8000.0] {
        let found = solver.equilibrium(&[-suction], start.as_deref(), &StaticSettings::default()).unwrap();
        assert!(found.residual < 1e-6, "{}", found.residual);
        let (gap, c) = (gap(system, &found.displacement), CONTACT.range);
        // p(g) = 2π k g (c/g − 1)³ with p(c/2) given; the roof is flat in the middle
        let pressure = 2.0 * PI * CONTACT.pressure / (PI * c) * gap * (c / gap - 1.0).powi(3);
        assert!(suction < 4000.0 || (pressure / suction - 1.0).abs() < 0.1, "{suction}: {gap} {pressure}");
        assert_eq!(system.walls_touch(&found.displacement), gap < c, "{suction}: {gap}");
        assert!(!system.without_contact().walls_touch(&found.displacement));
        start = Some(found.displacement);
    }
}

#[test]
fn adjoint_and_sensitivity_of_a_body_in_contact_are_differences() {
    for hexahedra in [false, true] {
        differ(&rubber(block(hexahedra), Some(CONTACT)).unwrap());
    }
}

fn differ(system: &System) {
    let settings = StaticSettings { tolerance: 1e-11, ..StaticSettings::default() };
    let mut solver = system.solver();
    let row = 3 * middle(system, 0.006 + HEIGHT) + 1;
    let first = solver.equilibrium(&[-1500.0], None, &settings).unwrap();
    let mut at = |e: f64, pressure: f64| {
        solver.set_elastic(0, e, 0.45).unwrap();
        let found = solver.equilibrium(&[pressure], Some(&first.displacement), &settings).unwrap();
        found.displacement[row]
    };
    let by_modulus = (at(2.002e5, -1500.0) - at(1.998e5, -1500.0)) / 400.0;
    let by_pressure = (at(2e5, -1499.0) - at(2e5, -1501.0)) / 2.0;
    let mut solver = system.solver();
    let mut along = vec![0.0; first.displacement.len()];
    along[row] = 1.0;
    let gradient = solver.adjoint(&first, &along).unwrap()[0].youngs_modulus;
    assert!((gradient / by_modulus - 1.0).abs() < 3e-5, "{gradient:e} {by_modulus:e}");
    let sensitivity = solver.sensitivity(&first, Parameter::Pressure(0)).unwrap()[row];
    assert!((sensitivity / by_pressure - 1.0).abs() < 1e-5, "{sensitivity:e} {by_pressure:e}");
}

#[test]
fn a_roof_that_falls_on_its_floor_bounces_and_its_motion_has_the_gradient_of_differences() {
    let system = body(Some(CONTACT)).unwrap();
    let settings = DynamicSettings { step: 1e-3, scheme: Scheme::Bdf2, tolerance: 1e-11, ..DynamicSettings::default() };
    let rest = State::rest(system.mesh().nodes.len());
    let pressures = |t: f64| vec![-1500.0 * (t / 5e-3).min(1.0)];
    let (steps, row) = (14, 3 * middle(&system, 0.006 + HEIGHT) + 1);
    let problem = InitialValueProblem { settings: &settings, initial: &rest, pressures: &pressures };
    let end = |e: f64| {
        let mut solver = system.solver();
        solver.set_elastic(0, e, 0.45).unwrap();
        let mut least = f64::INFINITY;
        let end =
            solver.integrate(&problem, steps, &mut |_, state| least = least.min(gap(&system, &state.displacement)));
        (end.unwrap().displacement[row], least)
    };
    let (_, least) = end(2e5);
    assert!(least > 0.0 && least < CONTACT.range, "{least}");
    let difference = (end(2.0002e5).0 - end(1.9998e5).0) / 40.0;
    let mut solver = system.solver();
    let trajectory = solver.record(&problem, steps, 1 << 30).unwrap();
    let mut loss = |n: usize, _: &State| {
        let mut by = vec![0.0; if n == steps { 3 * system.mesh().nodes.len() } else { 0 }];
        by.get_mut(row).into_iter().for_each(|entry| *entry = 1.0);
        LossGradient { displacement: by, velocity: Vec::new() }
    };
    let gradient = solver.trajectory_adjoint(&trajectory, &mut loss).unwrap().regions[0].youngs_modulus;
    assert!((gradient / difference - 1.0).abs() < 1e-4, "{gradient:e} {difference:e}");
}

#[test]
fn a_range_of_contact_that_cannot_be_is_refused() {
    for (range, pressure) in [(0.0, 1e3), (0.02, 1e3), (f64::NAN, 1e3), (5e-4, -1.0), (5e-4, f64::INFINITY)] {
        let refused = body(Some(Contact { range, pressure }));
        assert!(matches!(refused, Err(SetupError::Contact { .. })), "{range} {pressure}");
    }
}

/// A reduced model of `system`, trained under these suctions (Pa), and the shapes that trained it.
fn reduced(system: &System, suctions: &[f64]) -> (Arc<ReducedModel>, Vec<Vec<f64>>) {
    let mut solver = system.solver();
    let mut shapes: Vec<Vec<f64>> = Vec::new();
    for suction in suctions {
        let start = shapes.last().map(Vec::as_slice);
        let equilibrium = solver.equilibrium(&[-suction], start, &StaticSettings::default()).unwrap();
        let by_modulus = solver.sensitivity(&equilibrium, Parameter::YoungsModulus(0)).unwrap();
        // the equilibrium last: the next one starts from it
        shapes.extend([by_modulus.iter().map(|by| 2e4 * by).collect(), equilibrium.displacement]);
    }
    let snapshots: Vec<&[f64]> = shapes.iter().map(Vec::as_slice).collect();
    let settings = ReductionSettings { coordinates: 18, tolerance: 1e-4, ..ReductionSettings::default() };
    (Arc::new(system.reduce(&snapshots, &settings).unwrap()), shapes)
}

#[test]
fn a_reduced_model_in_contact_has_the_equilibria_and_derivatives_of_the_whole_body() {
    let system = body(Some(CONTACT)).unwrap();
    // before and after the roof lies on the floor
    let suctions = [100.0, 200.0, 400.0, 600.0, 800.0, 1000.0, 1300.0, 1700.0, 2200.0, 3000.0];
    let (model, shapes) = reduced(&system, &suctions);
    let shapes: Vec<&[f64]> = shapes.iter().map(Vec::as_slice).collect();
    let contact = system.reduced_contact(&model, &shapes).unwrap();
    let regions = system.regions().to_vec();
    let mut reduced = ReducedSolver::new(Arc::clone(&model), regions.clone()).in_contact(contact.map(Arc::new));
    let undeformed = DVector::zeros(model.coordinates());
    for suction in [900.0, 1500.0, 2600.0] {
        let full_shape =
            system.solver().equilibrium(&[-suction], None, &StaticSettings::default()).unwrap().displacement;
        let equilibrium = reduced.equilibrium_near(&[-suction], &undeformed, &undeformed).unwrap();
        let gaps = [&full_shape, &model.displacement(&equilibrium.coordinates)].map(|u| gap(&system, u));
        assert!((gaps[0] - gaps[1]).abs() < 0.03 * CONTACT.range, "{suction}: {gaps:?}");
    }
    // without contact the roof passes through the floor
    let free =
        ReducedSolver::new(Arc::clone(&model), regions).equilibrium_near(&[-1500.0], &undeformed, &undeformed).unwrap();
    assert!(gap(&system, &model.displacement(&free.coordinates)) < 0.0);
    let equilibrium = reduced.equilibrium_near(&[-1500.0], &undeformed, &undeformed).unwrap();
    let loss = DVector::from_fn(undeformed.len(), |mode, _| (0.3 + 1.3 * mode as f64).sin());
    let loss_under = |solver: &ReducedSolver, pressure: f64| {
        let end = solver.equilibrium_near(&[pressure], &equilibrium.coordinates, &equilibrium.coordinates).unwrap();
        end.coordinates.dot(&loss)
    };
    let by_pressure = (loss_under(&reduced, -1499.0) - loss_under(&reduced, -1501.0)) / 2.0;
    let gradient = reduced.pressure_gradient(&equilibrium, &loss)[0];
    assert!((gradient / by_pressure - 1.0).abs() < 1e-4, "{gradient:e} {by_pressure:e}");
    let adjoint = reduced.adjoint(&equilibrium, &loss, &[Parameter::YoungsModulus(0)]).unwrap()[0];
    let mut loss_of_modulus = |e: f64| {
        reduced.set_elastic(0, e, 0.45).unwrap();
        loss_under(&reduced, -1500.0)
    };
    let by_modulus = (loss_of_modulus(2.001e5) - loss_of_modulus(1.999e5)) / 200.0;
    assert!((adjoint / by_modulus - 1.0).abs() < 1e-4, "{adjoint:e} {by_modulus:e}");
}

#[test]
fn the_contact_of_a_reduced_model_is_refused_for_another_body_and_absent_where_walls_stay_apart() {
    let system = body(Some(CONTACT)).unwrap();
    let (model, shapes) = reduced(&system, &[50.0]);
    assert!(system.reduced_contact(&model, &[&shapes[0][1..]]).is_err());
    assert!(system.reduced_contact(&model, &[&vec![0.0; shapes[0].len()]]).unwrap().is_none());
    assert!(system.without_contact().reduced_contact(&model, &[&shapes[0]]).unwrap().is_none());
}
