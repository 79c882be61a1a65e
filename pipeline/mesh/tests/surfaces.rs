//! Named surfaces: the ends of one bar in each format that has them.
//!
//! The bar of `data/` has 40 × 10 × 10 mm and elements of ten nodes; its end x = 0 is the physical surface 11 "holder", both ends are the
//! surface 12 "both ends". gmsh 4.15 wrote all files; in `bar.mesh` the end x = 0 has the reference 1 and no name.

#![allow(clippy::unwrap_used)]

use std::path::Path;

use mesh::Solid;
use mesh::foreign::{self, ForeignMesh, surface};

fn read(name: &str) -> ForeignMesh {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name);
    foreign::read(&path, &std::fs::read(&path).unwrap(), None)
        .unwrap()
        .check(if name.starts_with("ball") { 1.0 } else { 1e-3 }, false)
        .unwrap()
}

const BARS: [&str; 4] = ["bar.msh", "bar_binary.msh", "bar_legacy.msh", "bar_legacy_binary.msh"];

fn nodes(solid: &Solid, read: &ForeignMesh, word: &str) -> Vec<u32> {
    surface(&read.surfaces, word).unwrap().nodes((0..solid.len()).map(|element| solid.element(element)))
}

/// The nodes at one of these x, m.
fn at(solid: &Solid, ends: &[f64]) -> Vec<u32> {
    let on = |at: &[f64; 3]| ends.iter().any(|x| (at[0] - x).abs() < 1e-9);
    (0..solid.nodes().len() as u32).filter(|node| on(&solid.nodes()[*node as usize])).collect()
}

#[test]
fn a_surface_of_gmsh_is_found_by_name_and_by_number_in_every_form_of_the_format() {
    for name in BARS {
        let bar = read(name);
        let (holder, ends) = (at(&bar.solid, &[0.0]), at(&bar.solid, &[0.0, 0.04]));
        // nine corners and the middles of their sixteen edges at least
        assert!(holder.len() >= 25 && ends.len() == 2 * holder.len(), "{name}: {} nodes", holder.len());
        assert_eq!(nodes(&bar.solid, &bar, "holder"), holder, "{name}");
        assert_eq!(nodes(&bar.solid, &bar, "11"), holder, "{name}");
        assert_eq!(nodes(&bar.solid, &bar, "both ends"), ends, "{name}");
    }
}

#[test]
fn the_references_of_medit_are_numbers_of_surfaces() {
    let bar = read("bar.mesh");
    assert_eq!(nodes(&bar.solid, &bar, "1"), at(&bar.solid, &[0.0]));
}

#[test]
fn a_surface_is_the_same_on_elements_of_four_nodes_and_on_those_that_were_made_of_them() {
    let bar = read("bar.msh");
    let linear = Solid::Linear(bar.solid.clone().to_linear());
    let again = Solid::Quadratic(linear.clone().to_quadratic());
    for solid in [linear, again] {
        assert_eq!(nodes(&solid, &bar, "holder"), at(&solid, &[0.0]));
    }
}

#[test]
fn a_surface_that_is_not_there_is_refused_with_those_that_are() {
    let refused = surface(&read("bar_legacy.msh").surfaces, "clamp").unwrap_err().to_string();
    let said = ["no surface `clamp`", "its surfaces are `holder` (11), `both ends` (12)", "do:"];
    assert!(said.iter().all(|word| refused.contains(word)), "{refused}");
    let unnamed = surface(&read("ball_ascii.vtu").surfaces, "clamp").unwrap_err().to_string();
    assert!(unnamed.contains("it names no surface"), "{unnamed}");
}
