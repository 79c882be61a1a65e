//! STL as other programs write it: forms of text and bytes, several solids in a file, faces that lie twice.
//!
//! The files of `data/stl` are one block of 40 × 10 × 20; `h3_…` has a second solid, a chamber of 20 × 4 × 10 with its normals into it.

#![allow(clippy::unwrap_used)]

use mesh::{Settings, Solid, Surface, SurfaceError, cavities, mesh_without_sheet, stl};

fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(format!("{}/tests/data/stl/{name}.stl", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn near(value: f64, truth: f64) {
    assert!((value / truth - 1.0).abs() < 1e-6, "{value} is not {truth}");
}

#[test]
fn one_block_is_read_from_every_form() {
    for name in
        ["b_solid_alone", "c_upper", "e_bin_solidcube_nl", "f2_cr_only", "g4_bom", "g7_name_latin1", "k2_nan_normals"]
    {
        let block = stl::read(&bytes(name), 1e-3).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!((block.points.len(), block.faces.len()), (8, 12), "{name}");
        near(block.volume(), 8e-6);
    }
}

#[test]
fn units_of_length_are_those_of_the_case() {
    for (unit, volume) in [(1e-2, 8e-3), (0.0254, 8000.0 * 0.0254_f64.powi(3))] {
        near(stl::read(&bytes("b_solid_alone"), unit).unwrap().volume(), volume);
    }
}

/// Each part of a body may be exported as a solid of its own, one after the other.
#[test]
fn all_solids_of_a_file_are_shells_of_one_body() {
    let body = stl::read(&bytes("h3_solid_cavity_separate"), 1e-3).unwrap();
    assert_eq!((body.points.len(), body.faces.len(), body.shells().unwrap().0.len()), (16, 24, 2));
    near(body.volume(), 7.2e-6);
    let set = Settings { use_symmetry: false, ..Settings::new(4e-3) };
    let meshed = Solid::Linear(mesh_without_sheet(&body, &set).unwrap().0);
    let chambers = cavities(&meshed);
    assert_eq!(chambers.len(), 1);
    near(chambers[0].volume, 8e-7);
}

/// A chamber whose normals point out of it, as a solid by itself has them, is no chamber.
#[test]
fn a_part_within_a_part_with_normals_outwards_is_refused_as_such() {
    let mut body = stl::read(&bytes("h3_solid_cavity_separate"), 1e-3).unwrap();
    body.faces[12..].iter_mut().for_each(|face| face.swap(1, 2));
    let error = body.shells().unwrap_err();
    assert!(matches!(error, SurfaceError::Nested { .. }) && error.to_string().contains("turn the normals"), "{error}");
    // beside each other they are two parts
    body.points[8..].iter_mut().for_each(|at| at[0] += 0.1);
    assert_eq!(body.shells().unwrap().0.len(), 2);
}

#[test]
fn a_body_that_would_take_too_many_elements_is_refused_by_their_estimate() {
    let body = stl::read(&bytes("i_inch"), 1e-3).unwrap();
    let said = mesh_without_sheet(&body, &Settings::new(5e-3)).unwrap_err().to_string();
    assert!(said.contains("about 7e7 elements") && said.contains("the limit is 5e6"), "{said}");
}

/// Two blocks that touch along an edge: nothing is open there.
#[test]
fn an_edge_of_four_faces_is_no_hole() {
    let block = stl::read(&bytes("b_solid_alone"), 1e-3).unwrap();
    let mut touching = block.clone();
    let moved = block.points.iter().map(|[x, y, z]| [x + 0.04, y + 0.01, *z]);
    touching.points.extend(moved);
    touching.faces.extend(block.faces.iter().map(|face| face.map(|corner| corner + 8)));
    let error = stl::read(&stl::write(&touching, 1e-3, "touching"), 1e-3).unwrap().shells().unwrap_err();
    assert!(matches!(error, SurfaceError::Open { faces: 4, count: 1, .. }), "{error}");
    let said = error.to_string();
    assert!(said.contains("nothing is open") && !said.contains("close the hole"), "{said}");
    let hole = Surface { faces: block.faces[1..].to_vec(), ..block };
    assert!(hole.shells().unwrap_err().to_string().contains("close the hole"));
}
