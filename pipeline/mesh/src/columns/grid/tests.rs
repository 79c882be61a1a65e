//! Hexahedra of boxes and of bodies whose outlines end in the plan.

use crate::surface::tests::{block, with_cavity};
use crate::{Grading, Settings, Skin, Surface, mesh_in_hexahedra};

/// A box around a sheet with two cavities on each side, joined to none; millimetres.
fn chambers() -> (Surface, Surface) {
    let mm = |p: [f64; 3]| p.map(|c| c * 1e-3);
    let side = |sign: f64| {
        let wall = |a: f64, b: f64| if sign > 0.0 { [a, b] } else { [-b, -a] };
        let [low, high] = wall(0.5, 10.0);
        let mut solid = block(mm([0.0, low, -15.0]), mm([60.0, high, 15.0]));
        for x in [[8.0, 20.0], [22.0, 34.0]] {
            let [low, high] = wall(1.0, 8.0);
            solid = with_cavity(solid, mm([x[0], low, -11.0]), mm([x[1], high, 11.0]));
        }
        solid
    };
    let (mut both, other) = (side(-1.0), side(1.0));
    let first = both.points.len() as u32;
    both.points.extend(&other.points);
    both.faces.extend(other.faces.iter().map(|face| face.map(|point| point + first)));
    (both, block(mm([0.0, -0.5, -15.0]), mm([60.0, 0.5, 15.0])))
}

#[test]
fn a_body_with_chambers_beside_a_sheet_is_divided_into_hexahedra_of_its_volume() {
    let (body, spine) = chambers();
    let (mesh, report) = mesh_in_hexahedra(&body, Some(&spine), &Settings::new(4e-3), &Grading::COARSE).unwrap();
    assert!(mesh.half && report.chambers.len() == 4);
    let exact = 12e-3 * 7e-3 * 22e-3;
    assert!(report.chambers.iter().all(|chamber| (chamber.volume / exact - 1.0).abs() < 1e-9));
    assert!((report.volume_body / report.volume_body_stl - 1.0).abs() < 1e-9 && report.hausdorff_m < 1e-9);
    assert_eq!(mesh.cut_hexahedra().unwrap().nonconformity(), None);
    let on = |on: Skin| mesh.skin.iter().filter(|face| face.on == on).count();
    assert!(on(Skin::Symmetry) > 0 && on(Skin::Outer) > 0 && on(Skin::Chamber(0)) == on(Skin::Chamber(2)));
}

#[test]
fn both_sides_of_a_symmetric_body_mirror_each_other() {
    let (body, spine) = chambers();
    let (mesh, _) = mesh_in_hexahedra(&body, Some(&spine), &Settings::new(4e-3), &Grading::COARSE).unwrap();
    let key = |at: &[f64; 3]| at.map(|x| (x * 1e9).round() as i64);
    let mut nodes: Vec<_> = mesh.nodes.iter().map(key).collect();
    let mut mirrored: Vec<_> = nodes.iter().map(|[x, y, z]| [*x, -y, *z]).collect();
    nodes.sort_unstable();
    mirrored.sort_unstable();
    assert_eq!(nodes, mirrored);
}

#[test]
fn a_finer_grading_has_more_elements_of_the_same_volume() {
    let (body, spine) = chambers();
    let of = |grading: &Grading| mesh_in_hexahedra(&body, Some(&spine), &Settings::new(4e-3), grading).unwrap();
    let (coarse, fine) = (of(&Grading::COARSE), of(&Grading::COARSE.finer(1.5)));
    assert!(fine.0.elements.len() > 3 * coarse.0.elements.len() / 2);
    assert!((fine.1.volume_body / coarse.1.volume_body - 1.0).abs() < 1e-9);
}
