//! A clamped column under a dead axial force: Euler's load, both branches of the elastica, and convergence with the mesh.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

use continuation::{
    BodyLoad, BodyProblem, Branch, CriticalKind, CriticalPoint, PathEnd, PathEvent, PathSettings, follow,
};
use fem::{Clamps, Elements, Forces, Mesh, RegionProperties, System, box_mesh, materials};
use std::f64::consts::PI;

const LENGTH: f64 = 0.1;
const WIDTH: f64 = 0.004;
const HEIGHT: f64 = 0.002;
const YOUNGS_MODULUS: f64 = 2e5;

/// π² E I / 4 L² [timoshenko1961, section 2.1].
fn euler() -> f64 {
    PI * PI * YOUNGS_MODULUS * WIDTH * HEIGHT.powi(3) / 12.0 / (4.0 * LENGTH * LENGTH)
}

/// Forces of the traction with the resultant `force` (N) along x on the side x = `LENGTH`.
fn end_load(mesh: &Mesh, force: f64) -> Vec<f64> {
    let Elements::Quadratic(tets) = &mesh.elements else { unreachable!("the mesh is quadratic") };
    let is_end = |node: &u32| mesh.nodes[*node as usize][0] > LENGTH - 1e-9;
    let mut forces = Forces::none(mesh);
    for tet in tets {
        for [a, b, c, ab, bc, ca] in [[0, 1, 2, 4, 5, 6], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 2, 3, 6, 9, 7]] {
            let face = [a, b, c, ab, bc, ca].map(|n| tet[n]);
            if face.iter().all(is_end) {
                forces = forces.on_face(&face, [force / (WIDTH * HEIGHT), 0.0, 0.0]).unwrap();
            }
        }
    }
    forces.as_slice().to_vec()
}

/// A column of so many elements along its length, under `force` times Euler's load at the load factor 1.
fn column(elements: usize, force: f64) -> BodyProblem {
    let mesh = box_mesh::quadratic([LENGTH, WIDTH, HEIGHT], [elements, 1, 1]);
    let clamps = Clamps::where_nodes(&mesh, [true, false, false], |at| at[0] < 1e-9)
        .and(&Clamps::where_nodes(&mesh, [false, true, true], |at| {
            at[0] < 1e-9 && at[1] == 0.5 * WIDTH && at[2] == 0.5 * HEIGHT
        }))
        .and(&Clamps::where_nodes(&mesh, [false, true, false], |at| at[0] < 1e-9 && at[1] == 0.5 * WIDTH));
    let forces = end_load(&mesh, -force * euler());
    let material = materials::by_name("neo_hookean").unwrap();
    let regions = vec![RegionProperties::elastic(material, YOUNGS_MODULUS, 0.3, 1070.0)];
    let system = System::new(mesh, regions, clamps).unwrap();
    BodyProblem::new(&system, system.solver(), BodyLoad { pressures: Vec::new(), forces }).unwrap()
}

fn first_critical(problem: &mut BodyProblem) -> CriticalPoint {
    let settings = PathSettings { branch: Branch::Primary, first_step: 0.5, ..Default::default() };
    follow(problem, &settings, &mut |_| {}).unwrap().critical.swap_remove(0)
}

#[test]
fn a_column_buckles_under_eulers_load_at_its_free_end() {
    let mut problem = column(8, 1.1);
    let found = first_critical(&mut problem);
    assert_eq!((found.kind, found.multiplicity, found.negative_eigenvalues), (CriticalKind::Bifurcation, 1, [0, 1]));
    assert!((1.1 * found.load_factor - 1.0).abs() < 0.01, "{}", 1.1 * found.load_factor);
    assert!(found.load_along_mode < 1e-4, "{:e}", found.load_along_mode);
    let (mode, tip) = (problem.dof_map().full(&found.mode), problem.dof_map().largest_node(&found.mode));
    let amplitude = mode[3 * tip + 2];
    let mesh = box_mesh::quadratic([LENGTH, WIDTH, HEIGHT], [8, 1, 1]);
    for (node, at) in mesh.nodes.iter().enumerate().filter(|(_, at)| at[2] == 0.5 * HEIGHT) {
        let exact = amplitude * (1.0 - (0.5 * PI * at[0] / LENGTH).cos());
        assert!((mode[3 * node + 2] - exact).abs() < 0.01 * amplitude.abs(), "{at:?}");
    }
    assert!(mesh.nodes[tip][0] == LENGTH);
}

#[test]
fn the_buckling_load_converges_with_the_mesh() {
    let errors = [2, 4, 8].map(|n| 1.5 * first_critical(&mut column(n, 1.5)).load_factor - 1.0);
    assert!(errors.windows(2).all(|pair| pair[0] / pair[1] > 3.5), "second order: {errors:?}");
}

/// The complete elliptic integral of the first kind by the arithmetic-geometric mean.
fn elliptic(k: f64) -> f64 {
    let (mut a, mut g) = (1.0, (1.0 - k * k).sqrt());
    for _ in 0..30 {
        (a, g) = (0.5 * (a + g), (a * g).sqrt());
    }
    0.5 * PI / a
}

/// Deflection of the free end over the length under `load` times the buckling load [timoshenko1961, section 2.7]: with
/// K(k) = ½ π √load it is 2 k / K.
fn elastica(load: f64) -> f64 {
    let (mut low, mut high) = (0.0, 0.999_999);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if elliptic(middle) < 0.5 * PI * load.sqrt() { low = middle } else { high = middle }
    }
    2.0 * low / elliptic(low)
}

#[test]
fn both_branches_follow_the_elastica() {
    for (branch, side) in [(Branch::AlongMode, 1.0), (Branch::AgainstMode, -1.0)] {
        let mut problem = column(16, 1.3);
        let settings = PathSettings { branch, levels: vec![0.85], first_step: 0.5, ..Default::default() };
        let (mut levels, mut critical) = (Vec::new(), Vec::new());
        let path = follow(&mut problem, &settings, &mut |event| match event {
            PathEvent::Point(point) if point.is_level => levels.push(point.clone()),
            PathEvent::Point(_) => {}
            PathEvent::Critical(point) => critical.push(point.clone()),
        });
        assert_eq!(path.unwrap().end, PathEnd::LoadFactor);
        let tip = problem.dof_map().largest_node(&critical[0].mode);
        let sign = problem.dof_map().full(&critical[0].mode)[3 * tip + 2].signum();
        for point in &levels {
            let load = point.load_factor / critical[0].load_factor;
            let deflection = side * sign * problem.dof_map().full(&point.displacement)[3 * tip + 2] / LENGTH;
            assert!((deflection / elastica(load) - 1.0).abs() < 0.02, "{load} {deflection} {}", elastica(load));
            assert_eq!(point.negative_eigenvalues, 0, "a buckled column is stable");
        }
        assert_eq!((levels.len(), critical.len()), (2, 1));
    }
}
