//! Bodies of the kinds that columns refuse, clean and dirty: meshed with their volume, no element flat, the same bytes twice.
#![allow(clippy::unwrap_used)] // a panic fails the test

use std::f64::consts::{PI, TAU};

use si::Point3;
use tetrahedralize::{Fill, Part, Refusal, Repair, Settings, Tetrahedra, tetrahedralize};

/// A surface of revolution-like quads: `place(i, j)`, closed in both directions.
fn closed_grid([rows, columns]: [u32; 2], place: impl Fn(f64, f64) -> Point3) -> Part {
    let number = |i: u32, j: u32| (i % rows) * columns + j % columns;
    let at = |i: u32, j: u32| place(TAU * f64::from(i) / f64::from(rows), TAU * f64::from(j) / f64::from(columns));
    let quads = (0..rows).flat_map(|i| (0..columns).map(move |j| [i, j]));
    let halves = |[i, j]: [u32; 2]| {
        let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    let points = (0..rows).flat_map(|i| (0..columns).map(move |j| [i, j])).map(|[i, j]| at(i, j)).collect();
    Part { points, faces: quads.flat_map(halves).collect(), fill: Fill::Region(0) }
}

fn torus(large: f64, small: f64) -> Part {
    closed_grid([48, 24], |u, v| {
        let radius = large + small * v.cos();
        [radius * u.cos(), radius * u.sin(), small * v.sin()]
    })
}

fn block(low: Point3, high: Point3) -> Part {
    let corner = |i: u32| [0, 1, 2].map(|k| if i >> k & 1 == 1 { high[k] } else { low[k] });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Part { points: (0..8).map(corner).collect(), faces, fill: Fill::Region(0) }
}

/// Both surfaces in one, the second inside out if it is a cavity.
fn joined(mut body: Part, other: &Part, cavity: bool) -> Part {
    let first = body.points.len() as u32;
    body.points.extend(&other.points);
    let turned = |[a, b, c]: [u32; 3]| if cavity { [a, c, b] } else { [a, b, c] };
    body.faces.extend(other.faces.iter().map(|f| turned(f.map(|n| n + first))));
    body
}

fn sound(part: Part, edge: f64, volume: f64) -> Tetrahedra {
    let solid = tetrahedralize(&[part], &Settings::new(edge)).unwrap();
    let mut angles = solid.smallest_angles();
    angles.sort_by(f64::total_cmp);
    let [least, usual] = [angles[0], angles[angles.len() / 1000]].map(f64::to_degrees);
    assert!(least > 1.0 && usual > 5.0, "{least}° and {usual}°");
    let error = solid.volume(0) / volume - 1.0;
    assert!(error.abs() < 5e-3, "volume off by {error}");
    solid
}

#[test]
fn a_torus_keeps_its_volume_without_flat_elements_and_is_the_same_twice() {
    let faces: f64 = 0.022 * 0.008 * 0.008 * TAU * PI;
    // inscribed in 48 × 24: sin(x)/x of both angles
    let chords = (TAU / 24.0).sin() / (TAU / 24.0) * (TAU / 48.0).sin() / (TAU / 48.0);
    let first = sound(torus(0.022, 0.008), 5e-3, faces * chords);
    assert_eq!(first, tetrahedralize(&[torus(0.022, 0.008)], &Settings::new(5e-3)).unwrap());
}

#[test]
fn a_wall_of_one_millimetre_between_two_boxes_is_filled() {
    let hollow = joined(block([0.0; 3], [0.04, 0.02, 0.012]), &block([1e-3; 3], [0.039, 0.019, 0.011]), true);
    let volume = 0.04 * 0.02 * 0.012 - 0.038 * 0.018 * 0.010;
    sound(hollow, 4e-3, volume);
}

#[test]
fn a_flipped_patch_and_faces_that_lie_twice_are_repaired_and_reported() {
    let mut dirty = block([0.0; 3], [0.03, 0.02, 0.02]);
    dirty.faces[4].swap(0, 1);
    let again = dirty.faces[7];
    dirty.faces.push(again);
    let solid = sound(dirty, 5e-3, 1.2e-5);
    assert!(matches!(solid.repairs[..], [Repair::Turned { faces: 1, .. }]), "{:?}", solid.repairs);
}

#[test]
fn shells_whose_faces_look_any_way_become_a_body_with_its_cavity() {
    let mut hollow = joined(block([0.0; 3], [0.03, 0.03, 0.03]), &block([0.01; 3], [0.02; 3]), true);
    for flipped in [vec![0, 3, 5, 6, 8, 9, 10], vec![12, 14, 15, 17, 20, 22], (0..24).collect()] {
        flipped.into_iter().for_each(|face: usize| hollow.faces[face].swap(0, 1));
        sound(hollow.clone(), 5e-3, 2.6e-5);
    }
}

#[test]
fn a_closed_part_within_another_is_a_cavity_and_is_reported() {
    let nested = joined(block([0.0; 3], [0.03, 0.03, 0.03]), &block([0.01; 3], [0.02; 3]), false);
    let solid = sound(nested, 5e-3, 2.6e-5);
    assert!(matches!(solid.repairs[..], [Repair::Cavity { .. }]), "{:?}", solid.repairs);
}

#[test]
fn parts_of_one_file_that_overlap_are_united() {
    let crossed = joined(block([0.0; 3], [0.03, 0.01, 0.01]), &block([0.01, -0.01, 0.002], [0.02, 0.02, 0.008]), false);
    sound(crossed, 4e-3, 3e-6 + 1.8e-6 - 6e-7);
}

#[test]
fn an_insert_of_another_triangulation_is_a_region_and_a_void_is_none() {
    let body = block([0.0; 3], [0.03, 0.02, 0.02]);
    let insert = Part { fill: Fill::Region(1), ..block([0.01, 0.0, 0.0], [0.02, 0.02, 0.01]) };
    let void = Part { fill: Fill::Void, ..block([0.004, 0.004, 0.013], [0.026, 0.016, 0.017]) };
    let solid = tetrahedralize(&[body, insert, void], &Settings::new(4e-3)).unwrap();
    let volumes = [solid.volume(0), solid.volume(1)];
    let expected = [1.2e-5 - 2e-6 - 0.022 * 0.012 * 0.004, 2e-6];
    assert!(volumes.iter().zip(expected).all(|(v, e)| (v / e - 1.0).abs() < 5e-3), "{volumes:?} for {expected:?}");
}

#[test]
fn a_body_of_two_metres_with_edges_of_five_millimetres_is_refused_before_it_is_made() {
    let refusal = tetrahedralize(&[block([0.0; 3], [2.0; 3])], &Settings::new(5e-3)).unwrap_err();
    assert!(matches!(refusal, Refusal::TooLarge { .. }), "{refusal}");
}

#[test]
fn a_surface_that_encloses_nothing_is_refused() {
    let mut open = block([0.0; 3], [0.03; 3]);
    open.faces.truncate(2);
    let refusal = tetrahedralize(&[open], &Settings::new(5e-3)).unwrap_err();
    assert!(matches!(refusal, Refusal::Nothing { .. }), "{refusal}");
}
