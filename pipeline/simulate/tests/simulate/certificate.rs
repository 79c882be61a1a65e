//! Certificates of resolution: what a finer mesh of the same surfaces says, and cases that have none.

use std::path::Path;

use mesh::Surface;
use simulate::{Difference, RunOptions, certify};

use super::{example, folder};

/// A beam of 100 × 10 × 6 mm, held at x = 0 and pulled down at its end: bends by 7.8 mm, as Timoshenko has it.
fn beam(folder: &Path, edge: &str) -> Result<Vec<Difference>, String> {
    let corner = |i: u32| [0, 1, 2].map(|k| if i >> k & 1 == 1 { [0.1, 0.01, 0.006][k] } else { 0.0 });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let surface = Surface { points: (0..8).map(corner).collect(), faces };
    std::fs::write(folder.join("beam.stl"), mesh::stl::write(&surface, 1e-3, "beam")).unwrap();
    let case = example("cantilever.toml").replace("file = \"cantilever.msh\"", "body = \"beam.stl\"");
    let case = case.replace("order = \"quadratic\"", edge).replace("name = \"beam\"", "name = \"body\"");
    std::fs::write(folder.join("case.toml"), case).unwrap();
    let options = RunOptions { quiet: true, ..RunOptions::default() };
    certify(&folder.join("case.toml"), options).map(|done| done.1).map_err(|diagnostic| diagnostic.to_string())
}

#[test]
fn a_finer_mesh_says_how_far_a_beam_is_from_converged_and_its_results_lie_beside_the_others() {
    let folder = folder("certified");
    let [coarse, fine] = ["edge = 0.02", "edge = 0.005"].map(|edge| beam(&folder, edge).unwrap().remove(0));
    assert!((coarse.moved - 7.8e-3).abs() < 6e-4 && (fine.moved - 7.8e-3).abs() < 2e-4, "{coarse} {fine}");
    assert!(coarse.apart > 3.0 * fine.apart && fine.apart > 0.0 && fine.apart < 0.005 * fine.moved, "{coarse} {fine}");
    assert!(folder.join("case.out/case.csv").is_file() && folder.join("case.out/finer/case.csv").is_file());
}

#[test]
fn a_case_without_a_finer_mesh_a_level_or_a_marker_is_refused_before_it_is_solved() {
    let folder = folder("not_certified");
    let refused = |case: String| {
        std::fs::write(folder.join("case.toml"), case).unwrap();
        certify(&folder.join("case.toml"), RunOptions::default()).unwrap_err().to_string()
    };
    let file = refused(example("cantilever.toml"));
    assert!(file.contains("read from a file") && file.contains("do:"), "{file}");
    let surfaces = example("cantilever.toml").replace("file = \"cantilever.msh\"", "body = \"beam.stl\"\nedge = 0.01");
    let unnamed = refused(surfaces.replace("node = [{ name = \"tip\", near = [0.1, 0.0, 0.0] }]", ""));
    assert!(unnamed.contains("names no node and no marker"), "{unnamed}");
    assert!(!folder.join("case.out").exists());
}
