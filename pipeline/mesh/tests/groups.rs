//! Physical groups of gmsh: names, numbers, and entities that are in no group.
//!
//! `data/bars_*.msh` are two bars end to end, 40 × 10 × 10 each, volume 1 at x < 40 and volume 2 beyond, with all entities saved
//! (`Mesh.SaveAll`) or in four partitions. gmsh 4.15 wrote them.

#![allow(clippy::unwrap_used)]

use std::path::Path;

use mesh::foreign::{self, ForeignMesh};

fn text(name: &str) -> String {
    std::fs::read_to_string(format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

fn mesh(text: &str) -> ForeignMesh {
    foreign::gmsh(text.as_bytes()).unwrap().check(1e-3, false).unwrap()
}

/// Tag, name and mean x (mm) of each region.
fn regions(mesh: &ForeignMesh) -> Vec<(i64, String, f64)> {
    let solid = &mesh.solid;
    let middle = |number: usize| {
        let elements: Vec<usize> = (0..solid.len()).filter(|e| usize::from(solid.regions()[*e]) == number).collect();
        let x = |e: &usize| solid.element(*e)[..4].iter().map(|n| solid.nodes()[*n as usize][0]).sum::<f64>() / 4.0;
        let volume = elements.iter().map(x).sum::<f64>() / elements.len() as f64;
        (1e4 * volume).round() * 0.1
    };
    let region = |(number, region): (usize, &foreign::Region)| {
        (region.tag, region.name.clone().unwrap_or_default(), middle(number))
    };
    mesh.regions.iter().enumerate().map(region).collect()
}

fn near(found: &[(i64, String, f64)], expected: &[(i64, &str, f64)]) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for ((tag, name, x), (expected_tag, expected_name, expected_x)) in found.iter().zip(expected) {
        assert_eq!((tag, name.as_str()), (expected_tag, *expected_name), "{found:?}");
        assert!((x - expected_x).abs() < 2.0, "{found:?}");
    }
}

/// Group 2 is volume 1, and volume 2 is in no group.
#[test]
fn a_volume_in_no_group_is_not_taken_for_the_group_of_its_number() {
    near(&regions(&mesh(&text("bars_ungrouped.msh"))), &[(-2, "volume 2", 60.0), (2, "soft", 20.0)]);
}

/// gmsh leaves the groups out where it saves all entities in version 2.2: nothing says which volume is the group 2.
#[test]
fn a_name_of_which_no_element_is_left_names_no_volume() {
    near(&regions(&mesh(&text("bars_ungrouped_legacy.msh"))), &[(1, "volume 1", 20.0), (2, "volume 2", 60.0)]);
}

/// The same list of elements where those of volume 1 do have their group.
#[test]
fn the_two_name_spaces_are_apart_in_version_2_as_well() {
    let grouped = text("bars_ungrouped_legacy.msh").replace(" 4 2 0 1 ", " 4 2 2 1 ");
    near(&regions(&mesh(&grouped)), &[(-2, "volume 2", 60.0), (2, "soft", 20.0)]);
}

#[test]
fn a_mesh_in_partitions_has_the_groups_and_the_surfaces_of_the_whole() {
    let mesh = mesh(&text("bars_partitions.msh"));
    near(&regions(&mesh), &[(1, "soft", 20.0), (2, "stiff", 60.0)]);
    let holder = foreign::surface(&mesh.surfaces, "holder").unwrap();
    let solid = &mesh.solid;
    let nodes = holder.nodes((0..solid.len()).map(|e| solid.element(e)));
    assert!(nodes.len() >= 9 && nodes.iter().all(|n| solid.nodes()[*n as usize][0].abs() < 1e-9), "{nodes:?}");
}

#[test]
fn a_group_whose_number_has_a_minus_is_the_same_group() {
    let turned = text("bars_ungrouped.msh").replace(" 1 2 6 1 2 3 4 5 6", " 1 -2 6 1 2 3 4 5 6");
    assert_ne!(turned, text("bars_ungrouped.msh"));
    near(&regions(&mesh(&turned)), &[(-2, "volume 2", 60.0), (2, "soft", 20.0)]);
}

#[test]
fn endings_are_read_in_either_case() {
    let read = foreign::read(Path::new("BARS.MSH"), text("bars_partitions.msh").as_bytes(), None);
    assert!(read.is_ok_and(|raw| raw.len() > 100));
    assert_eq!(foreign::nodes_of(Path::new("a/BAR.ELE")), Some("a/BAR.NODE".into()));
    assert_eq!(foreign::nodes_of(Path::new("a/bar.ele")), Some("a/bar.node".into()));
}
