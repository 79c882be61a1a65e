//! Sealed gas, gravity, attached masses, adaptive steps and mean dilatation.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use fem::{
    Clamps, DynamicSettings, Forces, InitialValueProblem, Masses, Mesh, Options, RegionProperties, Scheme, State,
    StaticSettings, System,
};
use fem::{box_mesh, materials};
use std::f64::consts::PI;

const AIR: f64 = 101_325.0;

fn silicone(poissons_ratio: f64) -> RegionProperties {
    let material = materials::by_name("neo_hookean").unwrap();
    RegionProperties::elastic(material, 2e5, poissons_ratio, 1070.0)
}

/// A block of 30 × 30 × 30 mm with a cavity of 10 × 10 × 10 mm in its middle.
fn hollow() -> Mesh {
    let air = |cell: [usize; 3]| cell.iter().all(|&at| (2..4).contains(&at));
    let place = |at: [f64; 3]| at.map(|x| 0.03 * x);
    box_mesh::to_quadratic(&box_mesh::grid([6; 3], false, place, |cell| (!air(cell)).then_some(0)))
}

#[test]
fn a_sealed_chamber_conserves_pressure_times_volume() {
    let mesh = hollow();
    let clamps = Clamps::below_x(&mesh, 1e-9);
    let system = System::new(mesh, vec![silicone(0.45)], clamps).unwrap();
    let mut solver = system.solver();
    solver.set_sealed(0, Some(AIR)).unwrap();
    let charge = 4e4;
    let found = solver.equilibrium(&[charge], None, &StaticSettings::default()).unwrap();
    let (rest, now) =
        (system.chamber_volume(0, &vec![0.0; found.displacement.len()]), system.chamber_volume(0, &found.displacement));
    assert!(now > 1.1 * rest, "the cavity swells: {}", now / rest);
    let gauge = solver.chamber_pressure(0, &found.displacement, &[charge]).unwrap();
    assert!(((gauge + AIR) * now / ((charge + AIR) * rest) - 1.0).abs() < 1e-12);
    // the same gauge pressure, held from outside, holds the same shape
    let held = system.solver().equilibrium(&[gauge], None, &StaticSettings::default()).unwrap();
    let apart =
        held.displacement.iter().zip(&found.displacement).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    assert!(apart < 1e-8, "{apart:e}");
    assert!(found.iterations <= 30, "{}", found.iterations);
}

#[test]
fn sealed_air_resists_compression_and_an_open_cavity_does_not() {
    let mesh = hollow();
    let clamps = Clamps::below_x(&mesh, 1e-9);
    let side: Vec<u32> = (0..mesh.nodes.len() as u32).filter(|&n| mesh.nodes[n as usize][0] > 0.03 - 1e-9).collect();
    let push = side
        .iter()
        .fold(Forces::none(&mesh), |all, &node| all.on_node(node, [-20.0 / side.len() as f64, 0.0, 0.0]).unwrap());
    let system = System::new(mesh.clone(), vec![silicone(0.45)], clamps).unwrap();
    let squeezed = |ambient| {
        let mut solver = system.solver();
        solver.set_forces(push.as_slice()).unwrap();
        solver.set_sealed(0, ambient).unwrap();
        let found = solver.equilibrium(&[0.0], None, &StaticSettings::default()).unwrap();
        let gauge = solver.chamber_pressure(0, &found.displacement, &[0.0]).unwrap();
        (system.chamber_volume(0, &found.displacement), gauge)
    };
    let (open, sealed) = (squeezed(None), squeezed(Some(AIR)));
    assert_eq!(open.1, 0.0);
    assert!(sealed.0 > open.0 && sealed.1 > 1e3, "{open:?} {sealed:?}");
}

#[test]
fn a_hanging_bar_elongates_by_its_own_weight_and_an_attached_mass() {
    let (length, side, weight) = (0.1, 0.01, 0.02);
    let mesh = box_mesh::quadratic([length, side, side], [10, 2, 2]);
    let clamps = Clamps::where_nodes(&mesh, [true, false, false], |at| at[0] < 1e-9)
        .and(&Clamps::where_nodes(&mesh, [false, true, true], |at| at.iter().all(|x| *x < 1e-9)))
        .and(&Clamps::where_nodes(&mesh, [false, false, true], |at| at[0] < 1e-9 && at[2] < 1e-9));
    let material = materials::by_name("linear").unwrap();
    let is = RegionProperties::elastic(material, 2e5, 0.0, 1070.0);
    let end = end_faces(&mesh, length);
    let masses = end.iter().fold(Masses::none(), |all, face| all.on_face(&mesh, face, weight / (side * side)).unwrap());
    let options = Options { masses, ..Options::default() };
    let system = System::with(mesh.clone(), vec![is], clamps, options).unwrap();
    assert!((system.mass() - (1070.0 * length * side * side + weight)).abs() < 1e-12);
    let mut solver = system.solver();
    solver.set_gravity([9.81, 0.0, 0.0]).unwrap();
    let found = solver.equilibrium(&[], None, &StaticSettings::default()).unwrap();
    let at_end: Vec<f64> = (0..mesh.nodes.len())
        .filter(|&node| mesh.nodes[node][0] > length - 1e-9)
        .map(|node| found.displacement[3 * node])
        .collect();
    let mean = at_end.iter().sum::<f64>() / at_end.len() as f64;
    let exact = 9.81 * length * (weight / (side * side) + 0.5 * 1070.0 * length) / 2e5;
    assert!((mean / exact - 1.0).abs() < 5e-3, "{}", mean / exact);
}

/// The sides of elements that lie on x = `end`.
fn end_faces(mesh: &Mesh, end: f64) -> Vec<[u32; 6]> {
    let fem::Elements::Quadratic(tets) = &mesh.elements else { unreachable!() };
    let sides = [[0, 1, 2, 4, 5, 6], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 2, 3, 6, 9, 7]];
    let all = tets.iter().flat_map(|tet| sides.map(|side| side.map(|n| tet[n])));
    all.filter(|face| face.iter().all(|&node| mesh.nodes[node as usize][0] > end - 1e-9)).collect()
}

#[test]
fn a_tip_mass_lowers_the_frequency_of_a_beam_to_that_of_a_massless_spring() {
    let (length, side, e, mass) = (0.1f64, 0.008f64, 2e5, 0.05);
    let material = materials::by_name("corotated").unwrap();
    let is = RegionProperties::elastic(material, e, 0.3, 1070.0);
    let own = 1070.0 * length * side * side;
    // Rayleigh: k = 3EI/L³, 33/140 of the beam's own mass moves with its end
    let omega = (3.0 * e * side.powi(4) / 12.0 / length.powi(3) / (mass + 33.0 / 140.0 * own)).sqrt();
    for lumped_mass in [false, true] {
        let mesh = box_mesh::quadratic([length, side, side], [10, 1, 1]);
        let clamps = Clamps::below_x(&mesh, 1e-9);
        let faces = end_faces(&mesh, length);
        let masses =
            faces.iter().fold(Masses::none(), |all, face| all.on_face(&mesh, face, mass / (side * side)).unwrap());
        let tip = mesh.nodes.iter().position(|at| at[0] > length - 1e-9).unwrap();
        let options = Options { lumped_mass, masses, ..Options::default() };
        let system = System::with(mesh.clone(), vec![is.clone()], clamps, options).unwrap();
        let mut solver = system.solver();
        solver.set_forces(Forces::none(&mesh).on_node(tip as u32, [0.0, 1e-5, 0.0]).unwrap().as_slice()).unwrap();
        let bent = solver.equilibrium(&[], None, &StaticSettings { tolerance: 1e-10, ..Default::default() }).unwrap();
        solver.set_forces(&[]).unwrap();
        let settings =
            DynamicSettings { step: 2.0 * PI / omega / 200.0, scheme: Scheme::Bdf2, ..DynamicSettings::default() };
        let start = State { velocity: vec![0.0; bent.displacement.len()], displacement: bent.displacement };
        let mut heights = Vec::new();
        let mut see = |_: f64, state: &State| heights.push(state.displacement[3 * tip + 1]);
        solver
            .integrate(
                &InitialValueProblem { settings: &settings, initial: &start, pressures: &|_| Vec::new() },
                110,
                &mut see,
            )
            .unwrap();
        let low = (0..heights.len()).min_by(|&a, &b| heights[a].total_cmp(&heights[b])).unwrap() + 1;
        assert!(
            (low as f64 / 100.0 - 1.0).abs() < 0.03,
            "lumped {lumped_mass}: half a period after {low} of 100 steps"
        );
    }
}

#[test]
fn adaptive_steps_end_where_many_equal_steps_do() {
    let mesh = hollow();
    let clamps = Clamps::below_x(&mesh, 1e-9);
    let system = System::new(mesh, vec![silicone(0.45)], clamps).unwrap();
    let nodes = system.mesh().nodes.len();
    let kick = |time: f64| vec![if time < 0.01 { 2e6 * time } else { 2e4 }];
    let fine = DynamicSettings { step: 1e-4, stiffness_damping: 2e-4, ..DynamicSettings::default() };
    let exact = system
        .solver()
        .integrate(
            &InitialValueProblem { settings: &fine, initial: &State::rest(nodes), pressures: &kick },
            350,
            &mut |_, _| (),
        )
        .unwrap();
    let mut errors = Vec::new();
    let mut steps = Vec::new();
    for tolerance in [4e-6, 4e-8] {
        let adaptive = fem::StepControl { tolerance, shortest: 2e-5, longest: 0.02 };
        let (end, times) = system
            .solver()
            .integrate_adaptive(
                &InitialValueProblem { settings: &fine, initial: &State::rest(nodes), pressures: &kick },
                &adaptive,
                0.035,
                &mut |_, _| (),
            )
            .unwrap();
        assert!((times[times.len() - 1] - 0.035).abs() < 1e-12);
        let apart = end.displacement.iter().zip(&exact.displacement).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        errors.push(apart);
        steps.push(times.len());
    }
    assert!(errors[0] < 2e-5 && errors[1] < 0.3 * errors[0], "{errors:?} {steps:?}");
    assert!(steps[0] < 60 && steps[1] > steps[0], "{steps:?}");
}

#[test]
fn mean_dilatation_removes_locking_of_thick_quadratic_elements() {
    // Cook's membrane in the small: a tapered panel, clamped on the left, sheared on the right, nearly incompressible
    let corner = |n: usize, mean: bool| {
        let place = |at: [f64; 3]| {
            let (x, low, high) = (0.048 * at[0], 0.044 * at[0], 0.044 + 0.016 * at[0]);
            [x, low + (high - low) * at[1], 0.004 * at[2]]
        };
        let mesh = box_mesh::to_quadratic(&box_mesh::grid([n, n, 1], false, place, |_| Some(0)));
        let clamps = Clamps::below_x(&mesh, 1e-9).and(&Clamps::where_nodes(&mesh, [false, false, true], |_| true));
        let faces = end_faces(&mesh, 0.048);
        let push = faces.iter().fold(Forces::none(&mesh), |all, face| all.on_face(face, [0.0, 100.0, 0.0]).unwrap());
        let material = materials::by_name("linear").unwrap();
        let is = RegionProperties::elastic(material, 2e5, 0.4999, 1070.0);
        let options = Options { mean_dilatation: vec![mean], ..Options::default() };
        let system = System::with(mesh.clone(), vec![is], clamps, options).unwrap();
        let mut solver = system.solver();
        solver.set_forces(push.as_slice()).unwrap();
        let found = solver.equilibrium(&[], None, &StaticSettings::default()).unwrap();
        let top = mesh.nodes.iter().position(|at| at[0] > 0.048 - 1e-9 && at[1] > 0.06 - 1e-9).unwrap();
        found.displacement[3 * top + 1]
    };
    let exact = corner(16, true);
    let (plain, freed) = (corner(4, false) / exact - 1.0, corner(4, true) / exact - 1.0);
    let finer = corner(16, false) / exact - 1.0;
    assert!(finer.abs() < 0.02 && finer > plain, "both ways go to the same limit: {finer}");
    assert!(freed.abs() < 0.5 * plain.abs() && plain < 0.0, "{plain} {freed}");
}
