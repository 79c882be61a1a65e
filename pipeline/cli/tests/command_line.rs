//! `study simulate` as a program: where it writes, and how it fails.

#![allow(clippy::unwrap_used)]

use std::path::Path;

#[test]
fn the_command_line_writes_where_it_is_told_and_fails_with_the_fault() {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("command");
    let _ = std::fs::remove_dir_all(&out);
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("../simulate/examples/cantilever.toml");
    let study = |arguments: &[&str]| {
        std::process::Command::new(env!("CARGO_BIN_EXE_study")).arg("simulate").args(arguments).output().unwrap()
    };
    let place = out.join("here");
    let done = study(&[case.to_str().unwrap(), "--out", place.to_str().unwrap()]);
    let said = String::from_utf8(done.stderr).unwrap();
    assert!(done.status.success() && said.contains("level 0.1: moved") && said.contains("4200 dofs"), "{said}");
    assert!(place.join("cantilever.csv").is_file() && place.join("cantilever.pvd").is_file());
    let lost = study(&["nowhere.toml"]);
    let said = String::from_utf8(lost.stderr).unwrap();
    assert_eq!(lost.status.code(), Some(1));
    assert!(said.starts_with("error: nowhere.toml: the file cannot be used"), "{said}");
}

#[test]
fn a_body_that_is_stable_throughout_is_not_said_to_snap() {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("stable_finger");
    let _ = std::fs::remove_dir_all(&out);
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/stable_finger.toml");
    let arguments = ["simulate", case.to_str().unwrap(), "--out", out.to_str().unwrap()];
    let done = std::process::Command::new(env!("CARGO_BIN_EXE_study")).args(arguments).output().unwrap();
    let lines = String::from_utf8(done.stderr).unwrap();
    // the iterates of its last level were not, which is all that this search can know
    assert!(done.status.success() && lines.contains("level 1: moved"), "{lines}");
    assert!(lines.contains("the search met unstable shapes") && !lines.contains("snapped"), "{lines}");
    // which elements it got, and what they are worth
    assert!(lines.contains("not hexahedra: sized by the walls they would be longer than mesh.edge"), "{lines}");
    assert!(lines.contains("meshed in 3133 tetrahedra") && out.join("coarser/stable_finger.csv").is_file(), "{lines}");
    let estimate = lines.lines().find(|line| line.contains("on cells longer by 1.5 it is 0.01")).unwrap();
    assert!(estimate.ends_with("about so far it is from converged"), "{estimate}");
    let _ = std::fs::remove_dir_all(&out);
    let quiet =
        std::process::Command::new(env!("CARGO_BIN_EXE_study")).args(arguments).arg("--quiet").output().unwrap();
    assert!(quiet.status.success() && !out.join("coarser").exists());
}

#[test]
fn completions_and_manual_pages_know_every_command() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("manual");
    let _ = std::fs::remove_dir_all(&folder);
    let export = |arguments: &[&str]| {
        let done =
            std::process::Command::new(env!("CARGO_BIN_EXE_study")).arg("export").args(arguments).output().unwrap();
        assert!(done.status.success(), "{done:?}");
        String::from_utf8(done.stdout).unwrap()
    };
    let help = std::process::Command::new(env!("CARGO_BIN_EXE_study")).arg("--help").output().unwrap();
    let help = String::from_utf8(help.stdout).unwrap();
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    // a continued description is indented further than the names
    let commands = listed.filter(|line| !line.starts_with("   ")).filter_map(|line| line.split_whitespace().next());
    let completions = export(&["completions", "bash"]);
    export(&["manual", folder.to_str().unwrap()]);
    let names: Vec<&str> = commands.filter(|name| *name != "help").collect();
    assert!(names.contains(&"simulate") && names.len() > 15, "{names:?}");
    for name in names {
        assert!(
            completions.contains(&format!("study__subcmd__{name}")) || completions.contains(&format!("study__{name}")),
            "{name}"
        );
        let page = std::fs::read_to_string(folder.join(format!("study-{name}.1"))).unwrap();
        assert!(page.contains(".SH DESCRIPTION") || page.contains(".SH SYNOPSIS"), "{page}");
    }
}
