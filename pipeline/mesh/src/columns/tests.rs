//! Meshes from surfaces with known volumes and centroids.

use super::*;
use crate::surface::tests::{block, with_cavity};
use crate::{SurfaceError, ValidationError};
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

fn map(surface: &Surface, to: impl Fn(Point3) -> Point3) -> Surface {
    Surface { points: surface.points.iter().map(|&p| to(p)).collect(), faces: surface.faces.clone() }
}

#[test]
fn boxes_with_box_cavities_have_exact_volumes_and_one_chamber_each() {
    let (body, spine) = sandwich();
    let (made, report) = mesh(&body, &spine, &Settings::new(EDGE)).unwrap();
    assert_eq!(made.nonconformity(), None);
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
fn a_sheet_may_be_normal_to_any_axis() {
    let (body, spine) = sandwich();
    for turns in 0..3 {
        let turn = |p: Point3| [p[turns % 3], p[(turns + 1) % 3], p[(turns + 2) % 3]];
        let set = Settings { use_symmetry: false, ..Settings::new(EDGE) };
        let (made, report) = mesh(&map(&body, turn), &map(&spine, turn), &set).unwrap();
        assert_eq!(made.nonconformity(), None);
        assert!((report.volume_body - report.volume_body_stl).abs() < 1e-9 * report.volume_body);
    }
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
    assert_eq!(made.nonconformity(), None);
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
    assert!(matches!(error, MeshError::Invalid(ValidationError::NoContact)), "{error}");
}
