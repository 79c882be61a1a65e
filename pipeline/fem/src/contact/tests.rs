//! Two flat walls: the pressure between them in closed form, and what their mirror images add.

use super::surface::Surface;
use super::{Contact, SelfContact};
use crate::loads::Load;
use crate::mesh::{Chamber, Elements, Faces, Mesh};
use std::f64::consts::PI;

const SIDE: f64 = 0.02;
const CONTACT: Contact = Contact { range: 1e-3, pressure: 2e4 };
/// Far enough apart at rest to meet each other.
const REST: f64 = 5e-3;
const CELLS: usize = 5;

/// The walls y = 0 and y = `REST` of `SIDE` in x, from z = `low` to `SIDE`: quadratic triangles that face each other.
fn walls(low: f64, rows: usize) -> Mesh {
    let (wide, high) = (2 * CELLS + 1, 2 * rows + 1);
    let (mut nodes, mut faces) = (Vec::new(), Vec::new());
    for (wall, y) in [0.0, REST].into_iter().enumerate() {
        let node = |i: usize, k: usize| (wall * wide * high + k * wide + i) as u32;
        for (k, i) in (0..high).flat_map(|k| (0..wide).map(move |i| (k, i))) {
            let part = k as f64 / (high - 1) as f64;
            nodes.push([SIDE * i as f64 / (wide - 1) as f64, y, low + (SIDE - low) * part]);
        }
        for (k, i) in (0..rows).flat_map(|k| (0..CELLS).map(move |i| (2 * k, 2 * i))) {
            let lower = [[0, 0], [2, 0], [0, 2], [1, 0], [1, 1], [0, 1]];
            let upper = lower.map(|[a, b]| [2 - a, 2 - b]);
            faces.extend([lower, upper].map(|face| face.map(|[a, b]| node(i + a, k + b))));
        }
    }
    let chambers = vec![Chamber { faces: Faces::Quadratic(faces) }];
    Mesh {
        nodes,
        elements: Elements::Quadratic(Vec::new()),
        regions: Vec::new(),
        chambers,
        symmetry_plane_z: low == 0.0,
    }
}

/// The same walls of quadrilaterals of 8 nodes, four times as long as wide.
fn long_quadrilaterals() -> Mesh {
    const LONG: usize = 4;
    const WIDE: usize = 4 * LONG * 2;
    let (wide, high) = (2 * LONG + 1, 2 * WIDE + 1);
    let (mut nodes, mut faces) = (Vec::new(), Vec::new());
    for (wall, y) in [0.0, REST].into_iter().enumerate() {
        let node = |[i, k]: [usize; 2]| (wall * wide * high + k * wide + i) as u32;
        let part = |step: usize, steps: usize| SIDE * step as f64 / (steps - 1) as f64;
        let grid = (0..high).flat_map(|k| (0..wide).map(move |i| (i, k)));
        nodes.extend(grid.map(|(i, k)| [part(i, wide), y, 2.0 * part(k, high) - SIDE]));
        for (k, i) in (0..WIDE).flat_map(|k| (0..LONG).map(move |i| (2 * k, 2 * i))) {
            let places = [[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1]];
            faces.push(places.map(|[a, b]| node([i + a, k + b])));
        }
    }
    let chambers = vec![Chamber { faces: Faces::QuadraticQuadrilaterals(faces) }];
    Mesh { chambers, nodes, ..walls(-SIDE, 1) }
}

/// The displacement that leaves `gap` (m) between the walls.
fn closed(mesh: &Mesh, gap: f64) -> Vec<f64> {
    mesh.nodes.iter().flat_map(|at| [0.0, if at[1] > 0.0 { gap - REST } else { 0.0 }, 0.0]).collect()
}

#[test]
fn two_flat_walls_press_on_each_other_as_their_closed_form_says() {
    let [triangles, quadrilaterals] = [walls(-SIDE, 2 * CELLS), long_quadrilaterals()];
    // samples that lie opposite each other add most: at a third of the range the sum exceeds its integral by 14 %, and those of
    // quadrilaterals, 0.42 of it apart, by 51 %
    assert_pressure_of_closed_form(&triangles, [0.15, 0.02, 0.02]);
    assert_pressure_of_closed_form(&quadrilaterals, [0.55, 0.08, 0.02]);
    let samples = |mesh: &Mesh| {
        let surface = Surface::new(mesh, 0.6 * CONTACT.range);
        (0..mesh.chambers[0].faces.len() as u32).map(|face| surface.shapes(face).len()).sum::<usize>()
    };
    let [triangles, quadrilaterals] = [samples(&triangles), samples(&quadrilaterals)];
    assert!(quadrilaterals <= triangles, "as many samples on the same walls: {quadrilaterals} {triangles}");
}

fn assert_pressure_of_closed_form(mesh: &Mesh, within: [f64; 3]) {
    let contact = SelfContact::new(mesh, CONTACT);
    let c = CONTACT.range;
    for (gap, within) in [0.3 * c, 0.5 * c, 0.7 * c].into_iter().zip(within) {
        let mut gradient = vec![0.0; 3 * mesh.nodes.len()];
        contact.add_energy(&closed(mesh, gap), 1.0, &mut gradient);
        // the virtual work of a push that fades out towards the edges
        let push =
            |at: &[f64; 3]| (PI * at[0] / SIDE).sin().powi(2) * (PI * (at[2] + SIDE) / (2.0 * SIDE)).sin().powi(2);
        let upper = mesh.nodes.iter().enumerate().filter(|(_, at)| at[1] > 0.0);
        let work: f64 = upper.map(|(node, at)| -gradient[3 * node + 1] * push(at)).sum();
        let pressure = work / (0.25 * SIDE * 2.0 * SIDE);
        let exact = 2.0 * PI * CONTACT.pressure / (PI * c) * gap * (c / gap - 1.0).powi(3);
        assert!((pressure / exact - 1.0).abs() < within, "{gap}: {pressure} {exact}");
    }
    assert_eq!(contact.potential(&closed(mesh, 1.01 * c)), 0.0);
}

#[test]
fn walls_of_a_half_model_meet_as_those_of_the_whole() {
    let [whole, half] = [walls(-SIDE, 2 * CELLS), walls(0.0, CELLS)];
    let energy = |mesh: &Mesh| SelfContact::new(mesh, CONTACT).potential(&closed(mesh, 4e-4));
    let (whole, half) = (energy(&whole), energy(&half));
    assert!((2.0 * half / whole - 1.0).abs() < 1e-3, "{whole:e} {half:e}");
}

#[test]
fn no_step_carries_a_wall_through_the_other_and_a_common_one_is_whole() {
    let mesh = walls(0.0, CELLS);
    let contact = SelfContact::new(&mesh, CONTACT);
    let u = closed(&mesh, 1e-3);
    let lifted = |by: [f64; 2]| -> Vec<f64> {
        mesh.nodes.iter().flat_map(|at| [0.0, by[usize::from(at[1] > 0.0)], 0.0]).collect()
    };
    assert_eq!(contact.admissible_part(&u, &lifted([0.01, 0.01])), 1.0);
    assert_eq!(contact.admissible_part(&u, &lifted([0.0, -7e-4])), 1.0);
    let part = contact.admissible_part(&u, &lifted([1e-3, -1e-3]));
    assert!((part - 0.4).abs() < 0.01, "{part}");
}

#[test]
fn walls_within_the_range_couple_their_nodes_and_no_others() {
    let mesh = walls(0.0, CELLS);
    let contact = SelfContact::new(&mesh, CONTACT);
    assert!(contact.couplings(&closed(&mesh, 1.2e-3), 0.0).is_empty());
    let wall = |node: u32| mesh.nodes[node as usize][1] > 0.0;
    for couplings in [contact.couplings(&closed(&mesh, 1.2e-3), 0.5e-3), contact.couplings(&closed(&mesh, 5e-4), 0.0)] {
        assert!(!couplings.is_empty() && couplings.iter().all(|&(a, b)| wall(a) != wall(b)));
    }
}
