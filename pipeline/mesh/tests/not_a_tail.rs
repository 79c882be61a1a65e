//! Bodies other than a tail, from STL: a beam, a ball with a cavity, a finger with three chambers, a bellows; and one whose
//! layers have no common order, which is refused.
#![allow(clippy::unwrap_used)] // a test may fail where it stands

use std::f64::consts::{PI, TAU};

use mesh::{
    Assembly, MeshError, Method, Report, Settings, Surface, TetMesh, mesh, mesh_assembly, mesh_without_sheet, stl,
};
use si::{Metre, Point3};

/// Faces around the axis of a body of revolution.
const AROUND: usize = 48;

/// As a file would bring it.
fn through_a_file(surface: &Surface) -> Surface {
    stl::read(&stl::write(surface, 1e-3, "no tail"), 1e-3).unwrap()
}

fn alone(body: &Surface, edge: Metre) -> (TetMesh, Report) {
    mesh_without_sheet(&through_a_file(body), &Settings::new(edge)).unwrap()
}

fn joined(mut one: Surface, other: Surface) -> Surface {
    let first = one.points.len() as u32;
    one.points.extend(other.points);
    one.faces.extend(other.faces.iter().map(|f| f.map(|p| p + first)));
    one
}

/// The same surface around a cavity.
fn hollow(mut surface: Surface) -> Surface {
    surface.faces.iter_mut().for_each(|f| f.swap(1, 2));
    surface
}

fn block(low: Point3, high: Point3) -> Surface {
    let corner = |i: usize| [0, 1, 2].map(|k| 1e-3 * if i >> k & 1 == 1 { high[k] } else { low[k] });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Surface { points: (0..8).map(corner).collect(), faces }
}

/// A body of revolution about x through (x, radius), mm, from end to end.
fn turned(profile: &[(f64, f64)]) -> Surface {
    let mut points: Vec<Point3> = Vec::new();
    for &(x, r) in profile {
        let place = |k: usize| (TAU * k as f64 / AROUND as f64).sin_cos();
        points.extend((0..AROUND).map(place).map(|(s, c)| [1e-3 * x, 1e-3 * r * c, 1e-3 * r * s]));
    }
    let ends = [profile[0].0, profile[profile.len() - 1].0].map(|x| [1e-3 * x, 0.0, 0.0]);
    points.extend(ends);
    let (first, last) = ((points.len() - 2) as u32, (points.len() - 1) as u32);
    let at = |ring: usize, k: usize| (ring * AROUND + k % AROUND) as u32;
    let mut faces = Vec::new();
    for k in 0..AROUND {
        faces.push([first, at(0, k + 1), at(0, k)]);
        faces.push([last, at(profile.len() - 1, k), at(profile.len() - 1, k + 1)]);
        for ring in 1..profile.len() {
            let [a, b, c, d] = [at(ring - 1, k), at(ring - 1, k + 1), at(ring, k + 1), at(ring, k)];
            faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    Surface { points, faces }
}

/// A ball's profile, its poles cut off a hair.
fn ball(radius: f64) -> Vec<(f64, f64)> {
    let angle = |i: usize| PI * (f64::from(i as u32) + 0.5) / 24.0;
    (0..24).map(|i| (-radius * angle(i).cos(), radius * angle(i).sin())).collect()
}

/// A bellows' profile: four waves between two ends, walls so thick (mm).
fn bellows(wall: f64) -> Vec<(f64, f64)> {
    let from = 3.0 - wall;
    let length = 46.0 - 2.0 * from;
    let place = |i: usize| {
        let x = from + length * i as f64 / 64.0;
        (x, 10.0 + wall + 2.5 * (TAU * 4.0 * (x - 3.0) / 40.0).sin())
    };
    (0..=64).map(place).collect()
}

/// Volumes as their surfaces enclose them; the mesher itself has checked them, and its distance from the surfaces.
fn has_chambers(report: &Report, body: &Surface, count: usize) {
    assert_eq!(report.chambers.len(), count);
    assert!((report.volume_body / body.volume() - 1.0).abs() < 0.02, "{} m³", report.volume_body);
    // where a round body's layers end, at its rim, elements are flat
    assert!(report.min_dihedral_deg > 0.1, "{}°", report.min_dihedral_deg);
    assert_eq!((report.volume_spine, report.interface_area), (0.0, 0.0));
}

#[test]
fn a_beam() {
    let body = block([0.0, -5.0, -10.0], [100.0, 5.0, 10.0]);
    let (_, report) = alone(&body, 5e-3);
    has_chambers(&report, &body, 0);
}

#[test]
fn a_ball_with_a_cavity() {
    let body = joined(turned(&ball(20.0)), hollow(turned(&ball(12.0))));
    let (_, report) = alone(&body, 3e-3);
    has_chambers(&report, &body, 1);
}

#[test]
fn a_finger_with_three_chambers() {
    let chamber = |i: usize| {
        let from = 6.0 + 26.0 * i as f64;
        hollow(block([from, 3.0, -7.0], [from + 20.0, 13.0, 7.0]))
    };
    let body = (0..3).map(chamber).fold(block([0.0, 0.0, -10.0], [84.0, 16.0, 10.0]), joined);
    let (_, report) = alone(&body, 4e-3);
    has_chambers(&report, &body, 3);
    // and with a sheet below it that does not stretch
    let sheet = block([0.0, -0.5, -10.0], [84.0, 0.0, 10.0]);
    let (_, report) = mesh(&through_a_file(&body), &through_a_file(&sheet), &Settings::new(4e-3)).unwrap();
    assert_eq!(report.chambers.len(), 3);
}

#[test]
fn a_bellows() {
    let body = joined(turned(&bellows(1.5)), hollow(turned(&bellows(0.0))));
    let (_, report) = alone(&body, 2e-3);
    has_chambers(&report, &body, 1);
}

#[test]
fn a_slanted_ball_with_a_cavity_is_meshed_by_the_general_method_where_a_half_of_columns_was_wished_for() {
    let mut body = joined(turned(&ball(20.0)), hollow(turned(&ball(12.0))));
    body.points.iter_mut().for_each(|p| *p = [p[0] + 0.3 * p[1], p[1] + 0.4 * p[2], p[2] - 0.5 * p[0]]);
    let set = Settings { method: Method::Auto, use_symmetry: true, ..Settings::new(1e-2) };
    let parts = Assembly { body: &body, inserts: Vec::new(), cavities: Vec::new() };
    let chosen = mesh_assembly(&parts, &set, &|_| ()).unwrap();
    assert!(chosen.not_columns.is_some() && !chosen.solid.half, "{:?}", chosen.report);
    assert_eq!(chosen.report.chambers.len(), 1);
}

#[test]
fn a_block_with_a_cavity_of_two_cones() {
    let body = joined(block([0.0, 0.0, 0.0], [40.0, 30.0, 20.0]), hollow(turned_up()));
    let (_, report) = alone(&body, 2.5e-3);
    has_chambers(&report, &body, 1);
}

/// Two cones, back to back and upright.
fn turned_up() -> Surface {
    let cones = turned(&[(6.0, 3.0), (10.0, 6.0), (14.0, 3.0)]);
    let up = |p: &Point3| [p[1] + 0.02, p[2] + 0.015, p[0]];
    Surface { points: cones.points.iter().map(up).collect(), faces: cones.faces }
}

#[test]
fn an_open_surface_is_refused_with_its_face() {
    let mut body = block([0.0; 3], [10.0; 3]);
    body.faces.pop();
    let refused = mesh_without_sheet(&body, &Settings::new(3e-3)).unwrap_err();
    assert!(
        matches!(&refused, MeshError::Surface { role: "body", .. }) && refused.to_string().contains("do:"),
        "{refused}"
    );
}

/// A sphere of this radius, m.
fn sphere(radius: Metre) -> Surface {
    let profile: Vec<(f64, f64)> = (1..24).map(|k| PI * f64::from(k) / 24.0).map(|a| (-a.cos(), a.sin())).collect();
    let mut surface = turned(&profile);
    surface.points.iter_mut().for_each(|at| *at = at.map(|x| 1e3 * radius * x));
    surface
}

#[test]
fn a_sphere_in_millimetres_is_refused_before_it_is_meshed() {
    let error = mesh_without_sheet(&sphere(60.0), &Settings::new(0.005)).unwrap_err();
    assert!(matches!(error, MeshError::TooLarge { elements, .. } if elements > 1e13), "{error}");
    let text = error.to_string();
    assert!(text.contains("edges of 5.000e-3 m") && text.contains("not in millimetres"), "{text}");
    assert!(mesh_without_sheet(&sphere(0.06), &Settings::new(0.01)).is_ok());
}

#[test]
fn an_edge_of_zero_below_zero_or_no_number_is_refused() {
    for edge in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = mesh_without_sheet(&sphere(0.06), &Settings::new(edge)).unwrap_err();
        assert!(matches!(error, MeshError::Settings { name: "edge", .. }), "{error}");
    }
    let tiny = mesh_without_sheet(&sphere(0.06), &Settings::new(f64::MIN_POSITIVE)).unwrap_err();
    assert!(matches!(tiny, MeshError::TooLarge { .. }), "{tiny}");
    let set = Settings { tolerance: f64::NAN, ..Settings::new(0.01) };
    assert!(matches!(mesh_without_sheet(&sphere(0.06), &set), Err(MeshError::Settings { name: "tolerance", .. })));
}

#[test]
fn a_face_of_a_point_that_does_not_exist_and_a_point_that_lies_nowhere_are_refused() {
    let mut beyond = sphere(0.06);
    beyond.faces[3][1] = beyond.points.len() as u32;
    let mut nowhere = sphere(0.06);
    nowhere.points[7][2] = f64::NAN;
    for (surface, words) in [(beyond, "face 3 refers to point"), (nowhere, "point 7 lies at")] {
        for error in [
            mesh_without_sheet(&surface, &Settings::new(0.01)).unwrap_err(),
            mesh(&surface, &surface, &Settings::new(0.01)).unwrap_err(),
        ] {
            assert!(error.to_string().contains(words) && error.to_string().contains("body"), "{error}");
        }
        assert!(surface.shells().is_err());
    }
}
