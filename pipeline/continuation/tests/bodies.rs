//! Bodies under chamber pressure: derivatives against differences, the path of a roof that snaps through against
//! equilibria at given pressures, and refused loads.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use continuation::{
    BodyLoad, BodyProblem, ContinuationError, CriticalKind, PathEvent, PathPoint, PathSettings, Problem, follow,
};
use fem::{Clamps, Contact, Mesh, Options, RegionProperties, Solver, StaticSettings, System, box_mesh, materials};

/// A block of 40 × 40 × 14 mm, half of it in z, whose chamber has a thin roof in +y that is arched outwards by 6 mm.
fn arched_box() -> System {
    let air = |cell: [usize; 3]| (2..10).contains(&cell[0]) && cell[1] == 1 && cell[2] < 4;
    let place = |at: [f64; 3]| {
        let (x, z) = (0.04 * at[0], 0.02 * at[2]);
        let level = [0.0, 0.005, 0.011, 0.012][(3.0 * at[1]).round() as usize];
        let hump = ((x - 0.02) / 0.02).powi(2) + (z / 0.02).powi(2);
        let arch = if at[1] > 0.5 { 0.006 * (1.0 - hump).max(0.0) } else { 0.0 };
        [x, level + arch, z]
    };
    let mesh = box_mesh::to_quadratic(&box_mesh::grid([12, 3, 6], true, place, |cell| (!air(cell)).then_some(0)));
    rubber(mesh, None)
}

/// A body of rubber, its floor clamped.
fn rubber(mesh: Mesh, contact: Option<Contact>) -> System {
    let clamps = Clamps::where_nodes(&mesh, [true; 3], |at| at[1] < 1e-9);
    let rubber = RegionProperties::elastic(materials::by_name("neo_hookean").unwrap(), 2e5, 0.45, 1070.0);
    System::with(mesh, vec![rubber], clamps, Options { contact, ..Options::default() }).unwrap()
}

fn problem(system: &System, solver: Solver, pressure: f64) -> BodyProblem {
    BodyProblem::new(system, solver, BodyLoad { pressures: vec![pressure], forces: Vec::new() }).unwrap()
}

/// The node in the middle of the roof's outer side.
fn top(mesh: &Mesh) -> usize {
    (0..mesh.nodes.len()).max_by(|&a, &b| mesh.nodes[a][1].total_cmp(&mesh.nodes[b][1])).unwrap()
}

#[test]
fn the_tangent_and_the_load_are_the_differences_of_the_residual_under_pressure_and_dead_forces() {
    let system = arched_box();
    let forces = (0..3 * system.mesh().nodes.len()).map(|at| 1e-4 * (at as f64).sin()).collect();
    let load = BodyLoad { pressures: vec![-900.0], forces };
    let mut problem = BodyProblem::new(&system, system.solver(), load).unwrap();
    let u: Vec<f64> = (0..problem.dofs()).map(|at| 2e-5 * (0.9 * at as f64).cos()).collect();
    let along: Vec<f64> = (0..problem.dofs()).map(|at| (1.7 * at as f64).sin()).collect();
    let mut residual = |part: f64, load_factor: f64| {
        let moved: Vec<f64> = u.iter().zip(&along).map(|(u, v)| u + part * v).collect();
        problem.residual(&moved, load_factor).unwrap()
    };
    let difference = |above: Vec<f64>, below: Vec<f64>, step: f64| -> Vec<f64> {
        above.iter().zip(&below).map(|(above, below)| (above - below) / (2.0 * step)).collect()
    };
    let mut change = difference(residual(1e-8, 0.6), residual(-1e-8, 0.6), 1e-8);
    let by_load = difference(residual(0.0, 0.6 + 1e-3), residual(0.0, 0.6 - 1e-3), 1e-3);
    problem.factorise(&u, 0.6, None).unwrap();
    problem.solve(&mut change);
    assert!(change.iter().zip(&along).all(|(found, exact)| (found - exact).abs() < 1e-5));
    let load = problem.load(&u, 0.6);
    let most = load.iter().fold(0.0, |most: f64, entry| most.max(entry.abs()));
    assert!(load.iter().zip(&by_load).all(|(load, by_load)| (load + by_load).abs() < 1e-9 * most));
}

#[test]
fn the_path_of_a_roof_that_snaps_passes_the_equilibria_on_both_sides_of_the_snap() {
    let system = arched_box();
    let mut problem = problem(&system, system.solver(), -1000.0);
    let settings = PathSettings { levels: vec![0.1], ..Default::default() };
    let mut points: Vec<PathPoint> = Vec::new();
    let path = follow(&mut problem, &settings, &mut |event| {
        if let PathEvent::Point(point) = event {
            points.push(point.clone());
        }
    })
    .unwrap();
    let [before, after] = &path.critical[..] else { panic!("two limit points: {:?}", path.critical.len()) };
    assert!(before.kind == CriticalKind::LimitPoint && after.kind == CriticalKind::LimitPoint);
    assert!(before.load_factor > 0.1 && after.load_factor < 0.1 && before.load_along_mode > 0.05);
    let place = system.mesh().nodes[problem.dof_map().largest_node(&before.mode)];
    assert!((place[0] - 0.02).abs() < 1e-3 && place[1] > 0.015 && place[2] < 1e-9, "{place:?}: the roof's middle");

    let node = top(system.mesh());
    let levels: Vec<&PathPoint> = points.iter().filter(|point| point.is_level).collect();
    assert_eq!(levels.iter().map(|point| point.load_factor).collect::<Vec<_>>(), [0.1, 0.1, 0.1, 1.0]);
    assert_eq!(levels.iter().map(|point| point.negative_eigenvalues).collect::<Vec<_>>(), [0, 1, 0, 0]);
    let mut solver = system.solver();
    for point in levels.iter().filter(|point| point.negative_eigenvalues == 0) {
        let near = problem.dof_map().full(&point.displacement);
        let found =
            solver.equilibrium(&[-1000.0 * point.load_factor], Some(&near), &StaticSettings::default()).unwrap();
        assert!((found.displacement[3 * node + 1] - near[3 * node + 1]).abs() < 1e-9);
        assert_eq!(found.snap_through, []);
    }
}

#[test]
fn a_load_that_moves_nothing_and_a_sealed_chamber_are_refused() {
    let system = arched_box();
    let load = BodyLoad { pressures: vec![0.0], forces: Vec::new() };
    let refused = BodyProblem::new(&system, system.solver(), load).err().unwrap();
    assert!(matches!(refused, ContinuationError::Load { .. }), "{refused}");
    let mut sealed = system.solver();
    sealed.set_sealed(0, Some(101_325.0)).unwrap();
    let load = BodyLoad { pressures: vec![1e3], forces: Vec::new() };
    let refused = BodyProblem::new(&system, sealed, load).err().unwrap().to_string();
    assert!(refused.contains("chamber 0 is sealed") && refused.contains("do:"), "{refused}");
    let wrong = BodyLoad { pressures: vec![1e3, 2e3], forces: Vec::new() };
    assert!(matches!(BodyProblem::new(&system, system.solver(), wrong), Err(ContinuationError::Solver(_))));
}

#[test]
fn a_stiff_sheet_in_large_rotation_keeps_a_stable_path_even_where_one_iteration_suffices() {
    // A strip of 100 × 10 × 0.5 mm under a load across it: the approximate tangent of a long step has other inertia.
    let mesh = box_mesh::quadratic([0.1, 0.01, 5e-4], [16, 1, 1]);
    let clamps = Clamps::below_x(&mesh, 1e-9);
    let material = materials::by_name("neo_hookean").unwrap();
    let end = mesh.nodes.iter().position(|at| *at == [0.1, 0.0, 0.0]).unwrap();
    let mut forces = vec![0.0; 3 * mesh.nodes.len()];
    forces[3 * end + 2] = 5e-3;
    let system = System::new(mesh, vec![RegionProperties::elastic(material, 2e8, 0.3, 1070.0)], clamps).unwrap();
    let load = BodyLoad { pressures: Vec::new(), forces };
    let mut problem = BodyProblem::new(&system, system.solver(), load).unwrap();
    let levels: Vec<f64> = (1..100).map(|n| 0.01 * f64::from(n)).collect();
    let settings = PathSettings { levels, tolerance: 1e-4, ..Default::default() };
    let mut counts = Vec::new();
    let path = follow(&mut problem, &settings, &mut |event| {
        if let PathEvent::Point(point) = event {
            counts.push(point.negative_eigenvalues);
        }
    })
    .unwrap();
    assert!(path.critical.is_empty() && counts.iter().all(|count| *count == 0), "{counts:?}");
}

#[test]
fn a_tangent_that_gains_entries_where_walls_touch_is_still_that_of_the_residual() {
    let air = |cell: [usize; 3]| (2..10).contains(&cell[0]) && cell[1] == 1 && cell[2] < 4;
    let level = |at: f64| [0.0, 0.005, 0.007, 0.008][(3.0 * at).round() as usize];
    let place = |at: [f64; 3]| [0.04 * at[0], level(at[1]), 0.02 * at[2]];
    let mesh = box_mesh::to_quadratic(&box_mesh::grid([12, 3, 6], true, place, |cell| (!air(cell)).then_some(0)));
    let system = rubber(mesh, Some(Contact { range: 5e-4, pressure: 4e3 }));
    let settings = StaticSettings { tolerance: 1e-10, ..StaticSettings::default() };
    let touching = system.solver().equilibrium(&[-1000.0], None, &settings).unwrap().displacement;
    let mut problem = problem(&system, system.solver(), -1000.0).starting_at(&touching);
    let (u, rest) = (problem.start(), vec![0.0; problem.dofs()]);
    // at rest first, where no walls are coupled
    assert!(problem.factorise(&rest, 0.0, None).is_some() && problem.factorise(&u, 1.0, None).is_some());
    let b: Vec<f64> = (0..u.len()).map(|at| 1e-4 * (0.3 * at as f64).sin()).collect();
    let mut x = b.clone();
    problem.solve(&mut x);
    let step = 1e-8 / x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let mut at = |part: f64| {
        let moved: Vec<f64> = u.iter().zip(&x).map(|(u, x)| u + part * x).collect();
        problem.residual(&moved, 1.0).unwrap()
    };
    let (above, below) = (at(step), at(-step));
    for ((above, below), b) in above.iter().zip(&below).zip(&b) {
        assert!(((above - below) / (2.0 * step) - b).abs() < 1e-4 * 1e-4, "{above:e} {below:e} {b:e}");
    }
}
