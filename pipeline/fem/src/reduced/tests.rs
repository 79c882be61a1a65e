//! The reduced body against the whole one: volumes, forces and their slopes, shapes at rest and in motion.
//!
//! Stands on: `fem` alone. Never knows: a specimen.

use nalgebra::DVector;

use super::forces::Stress;
use super::{Drive, Kept, Reduced, Reduction, Still};
use crate::{Chamber, Clamps, Elements, Faces, March, Mesh, RegionProperties, Scheme, State, StaticSettings, System};
use crate::{boxes, materials};

/// A held beam with a cavity: a box whose inner cells are left out.
fn hollow() -> System {
    let solid = boxes::quadratic([0.06, 0.02, 0.02], [6, 4, 4]);
    let Elements::Quadratic(tets) = &solid.elements else { panic!("boxes::quadratic makes 10-node elements") };
    let inside = |tet: &[u32; 10]| {
        let middle = |axis: usize| tet[..4].iter().map(|n| solid.nodes[*n as usize][axis]).sum::<f64>() / 4.0;
        let within = |x: f64, [low, high]: [f64; 2]| low < x && x < high;
        within(middle(0), [0.01, 0.05]) && within(middle(1), [0.01, 0.015]) && within(middle(2), [0.005, 0.015])
    };
    let (gone, kept): (Vec<[u32; 10]>, Vec<[u32; 10]>) = tets.iter().partition(|tet| inside(tet));
    let mesh = without_loose_nodes(Mesh {
        regions: vec![0; kept.len()],
        chambers: vec![Chamber { faces: Faces::Quadratic(skin(&gone)) }],
        elements: Elements::Quadratic(kept),
        ..solid
    });
    let material = materials::by_name("neo_hookean").expect("a law of this crate");
    let rubber = RegionProperties { material, youngs_modulus: 2e5, poissons_ratio: 0.45, density: 1000.0 };
    let clamps = Clamps::below_x(&mesh, 1e-9);
    System::new(mesh, vec![rubber], clamps).expect("a beam with a cavity")
}

/// Faces that only one of `tets` has, turned to look into them.
fn skin(tets: &[[u32; 10]]) -> Vec<[u32; 6]> {
    let faces = [[0, 1, 2, 4, 5, 6], [0, 3, 1, 7, 8, 4], [1, 3, 2, 8, 9, 5], [0, 2, 3, 6, 9, 7]];
    let all: Vec<[u32; 6]> = tets.iter().flat_map(|t| faces.map(|f| f.map(|i| t[i]))).collect();
    let key = |face: &[u32; 6]| {
        let mut key = [face[0], face[1], face[2]];
        key.sort_unstable();
        key
    };
    all.iter().filter(|face| all.iter().filter(|other| key(other) == key(face)).count() == 1).copied().collect()
}

fn without_loose_nodes(mesh: Mesh) -> Mesh {
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
        Faces::Linear(_) => panic!("6-node faces"),
    };
    let chambers: Vec<Vec<[u32; 6]>> = mesh.chambers.iter().map(faces).collect();
    let renumbered = chambers.iter().map(|faces| faces.iter().map(|f| f.map(&mut number)).collect());
    let chambers = renumbered.map(|faces| Chamber { faces: Faces::Quadratic(faces) }).collect();
    Mesh { nodes, elements: Elements::Quadratic(tets), chambers, ..mesh }
}

/// Shapes at rest under rising pressures, with a sideways pull or without.
fn shapes(system: &System) -> Vec<Vec<f64>> {
    let mut shapes = Vec::new();
    let count = system.mesh().nodes.len();
    for pull in [0.0, -20.0, 20.0] {
        let mut solver = system.solver();
        solver.set_gravity([0.0, pull, 0.0]).expect("a finite pull");
        for pressure in [0.0, 8e3, 1.6e4, 2.4e4, 3.2e4, 4e4] {
            if pressure != 0.0 || pull != 0.0 {
                let start = shapes.last().filter(|_| pressure > 0.0).cloned().unwrap_or_else(|| vec![0.0; 3 * count]);
                let found = solver.equilibrium(&[pressure], Some(&start), &StaticSettings::default());
                shapes.push(found.expect("a soft load").displacement);
            }
        }
    }
    shapes
}

fn reduced(system: &System, shapes: &[Vec<f64>]) -> Reduced {
    let shapes: Vec<&[f64]> = shapes.iter().map(Vec::as_slice).collect();
    system.reduce(&shapes, &Reduction { coordinates: 14, tolerance: 1e-4, ..Reduction::default() }).expect("shapes")
}

fn some_shape(r: usize, size: f64) -> DVector<f64> {
    DVector::from_fn(r, |i, _| size * (1.0 + 2.3 * i as f64).sin())
}

#[test]
fn a_chamber_s_volume_is_the_cubic_that_is_kept() {
    let system = hollow();
    let body = reduced(&system, &shapes(&system));
    let q = some_shape(body.coordinates(), 0.3 * body.size);
    let whole = system.chamber_volume(0, &body.displacement(&q));
    assert!((body.chamber_volume(0, &q) / whole - 1.0).abs() < 1e-10);
}

#[test]
fn the_chosen_points_push_as_all_points_do() {
    let system = hollow();
    let shapes = shapes(&system);
    let body = reduced(&system, &shapes);
    assert!(body.points()[0] < 300, "{:?} points", body.points());
    let between = |pair: &[Vec<f64>]| pair[0].iter().zip(&pair[1]).map(|(a, b)| 0.5 * (a + b)).collect();
    let unseen: Vec<Vec<f64>> = shapes.windows(2).map(between).collect();
    for u in shapes.iter().step_by(4).chain(unseen.iter().step_by(3)) {
        let q = coordinates_of(&body, &system, u);
        let near = body.displacement(&q);
        let all = body.modes.tr_mul(&DVector::from_vec(system.solver().elastic_forces(&near)));
        let chosen = body.elastic_forces(&q, &[1.0]);
        assert!((&chosen - &all).norm() < 0.01 * all.norm(), "{} of {}", (&chosen - &all).norm(), all.norm());
    }
}

/// q of the nearest V q in the metric of the mass.
fn coordinates_of(body: &Reduced, system: &System, u: &[f64]) -> DVector<f64> {
    let parts = &system.parts;
    let mut free = Vec::new();
    parts.pattern.gather(u, &mut free);
    let mut pushed = vec![0.0; free.len()];
    parts.mass.multiply(&parts.pattern, &free, &mut pushed);
    let mut full = vec![0.0; u.len()];
    parts.pattern.spread(&pushed, 1.0, &mut full);
    let right = body.modes.tr_mul(&DVector::from_vec(full));
    body.mass.clone().lu().solve(&right).expect("a mass is positive")
}

#[test]
fn under_a_pressure_between_its_shapes_it_rests_where_the_whole_body_rests() {
    let system = hollow();
    let shapes = shapes(&system);
    let body = reduced(&system, &shapes);
    let whole = system.solver().equilibrium(&[2e4], Some(&shapes[1]), &StaticSettings::default()).expect("a soft load");
    let found = body.equilibrium(&[2e4], &[1.0], &DVector::zeros(body.coordinates())).expect("a soft load");
    let rests = body.displacement(&found);
    let off = rests.iter().zip(&whole.displacement).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    let size = whole.displacement.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
    assert!(off < 5e-3 * size, "off by {off} of {size} m");
    let again = body.equilibrium(&[2e4], &[1.0], &found).expect("it is at rest");
    assert!((again - found).amax() < 1e-7 * body.size, "what rests does not move");
}

#[test]
fn what_is_kept_is_restored_to_the_same_body() {
    let system = hollow();
    let body = reduced(&system, &shapes(&system));
    let again = system.restore(&body.kept()).expect("kept of this system");
    let q = some_shape(body.coordinates(), 0.2 * body.size);
    assert_eq!(again.elastic_forces(&q, &[1.3]), body.elastic_forces(&q, &[1.3]));
    assert_eq!(again.mass, body.mass);
    assert_eq!(again.chamber_volume(0, &q), body.chamber_volume(0, &q));
    assert_eq!(again.kept(), body.kept());
}

#[test]
fn what_was_kept_of_another_body_is_refused() {
    let system = hollow();
    let kept = reduced(&system, &shapes(&system)).kept();
    let refused = |kept: Kept, of: &str| {
        let error = system.restore(&kept).expect_err("it does not fit").to_string();
        assert!(error.contains(of), "{error}");
    };
    refused(Kept { modes: vec![vec![0.0; 3]], ..kept.clone() }, "3 a node");
    refused(Kept { points: Vec::new(), ..kept.clone() }, "points of 0 regions");
    refused(Kept { points: vec![vec![(u32::MAX, 1e-9)]], ..kept.clone() }, "is not one of region 0");
    for weight in [f64::NAN, 0.0, -1e-9] {
        refused(Kept { points: vec![vec![(0, weight)]], ..kept.clone() }, "is not one of region 0");
    }
    refused(Kept { size: f64::NAN, ..kept.clone() }, "not finite");
}

#[test]
fn the_stiffness_is_the_slope_of_the_forces() {
    let system = hollow();
    let body = reduced(&system, &shapes(&system));
    let q = some_shape(body.coordinates(), 0.2 * body.size);
    let along = some_shape(body.coordinates(), 1.0).map(|x| x * x);
    let h = 1e-5 * body.size;
    let force = |x: f64| body.elastic_forces(&(&q + &along * x), &[1.3]);
    let slope = (force(h) - force(-h)) / (2.0 * h);
    let exact = body.stiffness(&q, Stress::Present, &[1.3]) * &along;
    assert!((&slope - &exact).norm() < 1e-7 * exact.norm());
}

#[test]
fn a_pressure_that_beats_moves_the_reduced_body_as_the_whole_one() {
    let system = hollow();
    let body = reduced(&system, &shapes(&system));
    let march = March { step: 1.0 / 200.0, scheme: Scheme::Bdf2, stiffness_damping: 0.002, ..March::default() };
    let beat = |t: f64| 1.6e4 * (1.0 - (std::f64::consts::TAU * 3.0 * t).cos());
    let tip = (0..system.mesh().nodes.len())
        .max_by(|a, b| system.mesh().nodes[*a][0].total_cmp(&system.mesh().nodes[*b][0]))
        .expect("nodes");
    let (mut whole, mut less) = (Vec::new(), Vec::new());
    let rest = State::rest(system.mesh().nodes.len());
    let mut keep = |_: f64, state: &State| whole.push(state.displacement[3 * tip + 1]);
    system.solver().march(&march, &rest, &|t| vec![beat(t)], 100, &mut keep).expect("a soft beat");
    let mut keep = |_: f64, q: &DVector<f64>, _: &DVector<f64>| less.push(body.displacement(q)[3 * tip + 1]);
    let drive = |t: f64| Drive { pressures: vec![beat(t)] };
    body.march(&march, &[1.0], &drive, &mut Still, 100, &mut keep).expect("a soft beat");
    let largest = whole.iter().fold(0.0, |most: f64, y| most.max(y.abs()));
    let off = whole.iter().zip(&less).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    assert!(largest > 1e-3 && off < 0.02 * largest, "off by {off} of {largest} m");
}
