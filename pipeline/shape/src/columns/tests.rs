//! Tests: whole meshes from surfaces, against volumes and places that are known otherwise.
//!
//! Stands on: everything of this crate. Never knows: a file.

use super::*;
use crate::stack::tests::assert_conforming;
use crate::surface::tests::{block, with_cavity};
use crate::tail::{Resolution, Tail};
use crate::{BODY, SPINE, SurfaceError, Unfit, embed, quadratic, stl};
use si::Point3;

const EDGE: Metre = 4e-3;

/// A box around a sheet that ends flush with it, with a cavity on each side; millimetres.
fn sandwich() -> (Surface, Surface) {
    let mm = |p: [f64; 3]| p.map(|c| c * 1e-3);
    let below = with_cavity(
        block(mm([0.0, -10.0, -15.0]), mm([60.0, -0.5, 15.0])),
        mm([8.0, -8.0, -11.0]),
        mm([50.0, -2.0, 11.0]),
    );
    let above =
        with_cavity(block(mm([0.0, 0.5, -15.0]), mm([60.0, 10.0, 15.0])), mm([8.0, 2.0, -11.0]), mm([50.0, 8.0, 11.0]));
    (joined(below, &above), block(mm([0.0, -0.5, -15.0]), mm([60.0, 0.5, 15.0])))
}

fn joined(mut one: Surface, other: &Surface) -> Surface {
    let first = one.points.len() as u32;
    one.points.extend(&other.points);
    one.faces.extend(other.faces.iter().map(|f| f.map(|p| p + first)));
    one
}

/// Both solids of the nine-chamber tail, through single precision as a file would bring them.
fn tail() -> (Surface, Surface) {
    let (body, spine) = Tail::nine_chambers().solids(2e-3).unwrap();
    let file = |s: &Surface| stl::read(&stl::write(s, 1e-3, "a tail"), 1e-3).unwrap();
    (file(&body), file(&spine))
}

fn map(surface: &Surface, to: impl Fn(Point3) -> Point3) -> Surface {
    Surface { points: surface.points.iter().map(|&p| to(p)).collect(), faces: surface.faces.clone() }
}

#[test]
fn boxes_with_box_cavities_have_exact_volumes_and_one_chamber_each() {
    let (body, spine) = sandwich();
    let (made, report) = mesh(&body, &spine, &Settings::new(EDGE)).unwrap();
    assert_conforming(&made);
    assert!(report.half && report.chambers.len() == 2);
    let exact = 42e-3 * 6e-3 * 22e-3;
    assert!(report.chambers.iter().all(|c| (c.volume - exact).abs() < 1e-9 * exact));
    assert!((report.volume_spine - 60e-3 * 1e-3 * 30e-3).abs() < 1e-14);
    assert!((report.volume_body - report.volume_body_stl).abs() < 1e-9 * report.volume_body);
    assert!((report.interface_area - 2.0 * 60e-3 * 30e-3).abs() < 1e-9);
    assert!((report.chambers[0].centroid[1] + 5e-3).abs() < 1e-12 && report.chambers[0].centroid[2] == 0.0);
    assert!(report.hausdorff_m < 1e-9);
}

#[test]
fn a_sheet_may_lie_across_any_axis() {
    let (body, spine) = sandwich();
    for turns in 0..3 {
        let turn = |p: Point3| [p[turns % 3], p[(turns + 1) % 3], p[(turns + 2) % 3]];
        let set = Settings { use_symmetry: false, ..Settings::new(EDGE) };
        let (made, report) = mesh(&map(&body, turn), &map(&spine, turn), &set).unwrap();
        assert_conforming(&made);
        assert!((report.volume_body - report.volume_body_stl).abs() < 1e-9 * report.volume_body);
    }
}

#[test]
fn the_tail_from_its_surfaces_has_its_chambers_and_volumes() {
    let (body, spine) = tail();
    for edge in [EDGE, 2.5e-3] {
        let (made, report) = mesh(&body, &spine, &Settings::new(edge)).unwrap();
        assert_conforming(&made);
        assert_eq!(report.chambers.len(), 2);
        assert!((report.volume_body / report.volume_body_stl - 1.0).abs() < 0.01);
        assert!((report.volume_spine / report.volume_spine_stl - 1.0).abs() < 0.01);
        assert!(report.min_dihedral_deg > 1.5, "{}", report.min_dihedral_deg);
        assert!(report.hausdorff_m < 0.4e-3, "{}", report.hausdorff_m);
        assert!(made.nodes.iter().all(|n| n[2] >= 0.0));
    }
}

#[test]
fn the_tail_from_its_surfaces_agrees_with_its_own_mesh() {
    let (body, spine) = tail();
    let nine = Tail::nine_chambers();
    let own = nine.mesh(&Resolution::even(&nine, 2.5e-3)).unwrap();
    let (made, _) = mesh(&body, &spine, &Settings::new(2.5e-3)).unwrap();
    let same = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 0.01, "{a} against {b}");
    same(own.region_volume(BODY), made.region_volume(BODY));
    same(own.region_volume(SPINE), made.region_volume(SPINE));
    (0..2).for_each(|k| same(own.chamber_volume(k), made.chamber_volume(k)));
    assert_ne!(own.nodes.len(), made.nodes.len());
}

#[test]
fn the_same_surfaces_give_the_same_mesh() {
    let (body, spine) = tail();
    let set = Settings::new(EDGE);
    assert_eq!(mesh(&body, &spine, &set).unwrap(), mesh(&body, &spine, &set).unwrap());
}

#[test]
fn a_half_model_has_half_the_volume_and_is_closed_by_the_cut() {
    let (body, spine) = tail();
    let (half, _) = mesh(&body, &spine, &Settings::new(EDGE)).unwrap();
    let (whole, report) = mesh(&body, &spine, &Settings { use_symmetry: false, ..Settings::new(EDGE) }).unwrap();
    assert!(half.half && !whole.half && !report.half);
    assert_conforming(&whole);
    for region in [BODY, SPINE] {
        let ratio = 2.0 * half.region_volume(region) / whole.region_volume(region);
        assert!((ratio - 1.0).abs() < 0.005, "{ratio}");
    }
    assert!(half.skin.iter().any(|f| f.on == crate::Skin::Symmetry));
    assert!(whole.skin.iter().all(|f| f.on != crate::Skin::Symmetry));
}

#[test]
fn a_marker_on_the_back_is_embedded_within_a_tenth_of_a_millimetre() {
    let (body, spine) = tail();
    let (made, _) = mesh(&body, &spine, &Settings::new(EDGE)).unwrap();
    let fine = quadratic(&made);
    for x in [40e-3, 52e-3, 64e-3] {
        let at = Tail::nine_chambers().back_point(x);
        let (spot, distance) = embed(&fine, at);
        assert!(distance < 1e-4, "{distance}");
        assert!(si::vec3::norm(si::vec3::sub(spot.at(&fine.nodes), at)) <= distance + 1e-12);
    }
}

#[test]
fn a_tail_with_one_thicker_wall_is_meshed_as_it_is() {
    let uneven = Tail { wall: [2e-3, 2.4e-3], ..Tail::nine_chambers() };
    let (body, spine) = uneven.solids(2e-3).unwrap();
    let (_, report) = mesh(&body, &spine, &Settings::new(EDGE)).unwrap();
    assert!(report.chambers[0].volume > 1.03 * report.chambers[1].volume);
}

/// An ellipsoid with half axes (m), `rows` × 2 `rows` faces, outwards.
fn ellipsoid(axes: Point3, rows: usize) -> Surface {
    let around = 2 * rows;
    let point = |i: usize, j: usize| {
        let (t, f) = (std::f64::consts::PI * i as f64 / rows as f64, std::f64::consts::PI * j as f64 / rows as f64);
        [axes[0] * t.cos(), axes[1] * t.sin() * f.cos(), axes[2] * t.sin() * f.sin()]
    };
    let mut points = vec![point(0, 0), point(rows, 0)];
    (1..rows).for_each(|i| points.extend((0..around).map(|j| point(i, j))));
    let at = |i: usize, j: usize| match i {
        0 => 0,
        i if i == rows => 1,
        i => (2 + (i - 1) * around + j % around) as u32,
    };
    let quads = (0..rows).flat_map(|i| (0..around).map(move |j| (i, j)));
    let faces = quads
        .flat_map(|(i, j)| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]);
    Surface { points, faces: faces.filter(|[a, b, c]| a != b && b != c && c != a).collect() }
}

#[test]
fn a_round_body_with_a_buried_sheet_is_meshed_to_its_rim() {
    let sheet = ([-0.02, -0.5e-3, -0.006], [0.02, 0.5e-3, 0.006]);
    let body = with_cavity(ellipsoid([0.04, 0.01, 0.015], 40), sheet.0, sheet.1);
    let spine = block(sheet.0, sheet.1);
    let (made, report) = mesh(&body, &spine, &Settings::new(EDGE)).unwrap();
    assert_conforming(&made);
    assert!(report.half && report.chambers.is_empty() && report.min_dihedral_deg > 1.5);
    assert!((report.volume_body / report.volume_body_stl - 1.0).abs() < 0.02);
}

#[test]
fn a_gap_between_body_and_sheet_is_refused_with_its_width() {
    let (body, spine) = sandwich();
    let thin = map(&spine, |p| [p[0], 0.9 * p[1], p[2]]);
    match mesh(&body, &thin, &Settings::new(EDGE)) {
        Err(MeshError::Gap { width, .. }) => assert!((width - 0.05e-3).abs() < 1e-9),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_sheet_that_was_not_cut_out_of_the_body_is_refused() {
    let (body, spine) = sandwich();
    let thick = map(&spine, |p| [p[0], 1.5 * p[1], p[2]]);
    let error = mesh(&body, &thick, &Settings::new(EDGE)).unwrap_err();
    assert!(matches!(error, MeshError::Overlap { .. }), "{error}");
    assert!(error.to_string().contains("subtract the spine from the body"));
}

#[test]
fn an_open_body_is_refused_by_its_name() {
    let (mut body, spine) = sandwich();
    body.faces.pop();
    let error = mesh(&body, &spine, &Settings::new(EDGE)).unwrap_err();
    assert!(matches!(error, MeshError::Surface { role: "body", source: SurfaceError::Open { .. } }));
}

#[test]
fn a_body_beside_its_sheet_is_refused() {
    let (body, spine) = sandwich();
    let away = map(&spine, |p| [p[0], p[1] + 0.1, p[2]]);
    let error = mesh(&body, &away, &Settings::new(EDGE)).unwrap_err();
    assert!(matches!(error, MeshError::Unfit(Unfit::Loose)), "{error}");
}
