//! `study mesh`: a body, an insert and a cavity in files of their own become a mesh file that `study simulate`'s reader takes, with a report.
#![allow(clippy::unwrap_used)] // a panic fails the test

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use mesh::{Surface, stl};
use si::Point3;

/// A closed box, normals outwards.
fn block(low: Point3, high: Point3) -> Surface {
    let corner = |i: u32| [0, 1, 2].map(|k| if i >> k & 1 == 1 { high[k] } else { low[k] });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Surface { points: (0..8).map(corner).collect(), faces }
}

/// A folder of its own with three boxes: a body of 30 × 20 × 20 mm, an insert and a cavity in it.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("study-mesh-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let boxes = [
        ("body", block([0.0; 3], [0.03, 0.02, 0.02])),
        ("insert", block([0.018, 0.005, 0.005], [0.026, 0.015, 0.015])),
        ("cavity", block([0.004, 0.005, 0.005], [0.012, 0.015, 0.015])),
    ];
    for (name, surface) in boxes {
        std::fs::write(folder.join(format!("{name}.stl")), stl::write(&surface, 1e-3, name)).unwrap();
    }
    folder
}

fn study_mesh(folder: &Path, arguments: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_study"));
    command.arg("mesh").args(arguments.split(' ')).current_dir(folder).output().unwrap()
}

#[test]
fn a_body_with_an_insert_and_a_cavity_becomes_a_file_with_two_regions_and_a_chamber() {
    let folder = folder("parts");
    for ending in ["msh", "vtu", "mesh"] {
        let arguments = format!("body.stl insert.stl --cavity cavity.stl --edge 5mm --out made.{ending}");
        let output = study_mesh(&folder, &arguments);
        let report = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(report.contains("1 chambers") && report.contains("interface"), "{report}");
        assert_eq!(report.contains(" MiB"), cfg!(target_os = "linux"), "{report}");
        let read = simulate::raw_mesh(&folder.join(format!("made.{ending}"))).unwrap().check(1.0, false).unwrap();
        assert_eq!((read.regions.len(), read.cavities.len()), (2, 1), "{ending}");
        assert!((read.cavities[0].volume / 8e-7 - 1.0).abs() < 1e-3);
    }
    let parts =
        std::fs::read_dir(&folder).unwrap().flatten().filter(|e| e.path().extension().is_some_and(|e| e == "part"));
    assert_eq!(parts.count(), 0);
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn the_repaired_surface_is_closed_and_the_picture_is_drawn() {
    let folder = folder("repair");
    let output =
        study_mesh(&folder, "body.stl --edge 0.006 --method general --repair-to again.stl --picture cut.svg --quiet");
    assert!(output.status.success() && output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    let again = stl::read(&std::fs::read(folder.join("again.stl")).unwrap(), 1e-3).unwrap();
    assert!((again.shells().unwrap().0[0].volume / 1.2e-5 - 1.0).abs() < 1e-3);
    assert!(std::fs::read_to_string(folder.join("cut.svg")).unwrap().contains("<polygon"));
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn with_layers_auto_is_the_general_method_and_columns_refuse_them() {
    let folder = folder("layers");
    let output = study_mesh(&folder, "body.stl --edge 6mm --layers 2 --smallest 4mm --envelope 0.05mm --quiet");
    let report = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success() && report.contains("method      general"), "{report}");
    let refused = study_mesh(&folder, "body.stl --edge 6mm --layers 2 --method columns");
    let why = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(!refused.status.success() && why.contains("take the method general"), "{why}");
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn too_many_elements_and_other_endings_are_refused_before_anything_is_made() {
    let folder = folder("refused");
    let refused = |arguments: &str| String::from_utf8_lossy(&study_mesh(&folder, arguments).stderr).into_owned();
    let said = refused("body.stl --unit m --edge 5mm --out a.msh");
    assert!(said.contains("m long") || said.contains("elements"), "{said}");
    let said = refused("body.stl --edge 0.01mm --out a.msh");
    assert!(said.contains("elements") && said.contains("the limit is 5e6"), "{said}");
    assert!(refused("body.stl --edge 5mm --out a.obj").contains("cannot be written as .obj"));
    assert!(!folder.join("a.msh").exists());
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn of_a_refused_surface_the_picture_shows_the_place() {
    let folder = folder("refused");
    let mut open = block([0.0; 3], [0.03, 0.02, 0.02]);
    open.faces.truncate(4);
    std::fs::write(folder.join("open.stl"), stl::write(&open, 1e-3, "open")).unwrap();
    for method in ["columns", "general"] {
        let output = study_mesh(&folder, &format!("open.stl --edge 4mm --method {method} --picture {method}.svg"));
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(1) && message.contains("the place → "), "{message}");
        let svg = std::fs::read_to_string(folder.join(format!("{method}.svg"))).unwrap();
        assert_eq!((svg.matches("<polygon").count(), svg.matches("<circle").count()), (4, 1));
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
