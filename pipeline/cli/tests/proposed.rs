//! `study doctor FOLDER` and `study init NAME --from FOLDER` on the recordings of one trial.
#![allow(clippy::unwrap_used)]

mod specimen;

use std::fs;
use std::process::Command;

use specimen::{FILM, LOG, Project};

/// Output and exit code of a command in the project.
fn study(project: &Project, words: &[&str]) -> (String, Option<i32>) {
    let output = Command::new(env!("CARGO_BIN_EXE_study")).args(words).arg("--root").arg(&project.0).output().unwrap();
    let text = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    (text, output.status.code())
}

#[test]
fn a_folder_without_a_card_gets_one_that_is_never_written_over() {
    let project = Project::new("proposed");
    let folder = project.0.join("from the lab");
    fs::create_dir_all(&folder).unwrap();
    fs::copy(project.path(FILM), folder.join("C0001.MP4")).unwrap();
    fs::copy(project.path(LOG), folder.join("DAQ 7.txt")).unwrap();
    fs::copy(project.path("cad/body.stl"), folder.join("Part1.STL")).unwrap();
    let (said, code) = study(&project, &["doctor", folder.to_str().unwrap()]);
    assert_eq!(code, Some(0), "{said}");
    assert!(
        said.contains("certain  trial.C0001.pressure = \"DAQ 7.txt\"")
            || said.contains("certain  trial.C0001.pressure = DAQ 7.txt"),
        "{said}"
    );
    assert!(said.contains("question camera.calibration"), "{said}");
    let card: toml::Table = fs::read_to_string(folder.join("specimen.toml")).unwrap().parse().unwrap();
    let trial = &card["trial"][0];
    assert_eq!(
        trial["levels"].as_array().unwrap().iter().map(|l| l.as_float().unwrap()).collect::<Vec<_>>(),
        [5e3, 1e4]
    );
    assert_eq!((trial["kind"].as_str(), trial["channels"][0].as_str()), (Some("staircase"), Some("left")));
    let lamp = &card["led"]["centre"];
    assert!((lamp[0].as_float().unwrap() - 40.0).hypot(lamp[1].as_float().unwrap() - 40.0) < 2.0, "{lamp}");
    let (said, code) = study(&project, &["doctor", folder.to_str().unwrap()]);
    assert!(code == Some(1) && said.contains("exists already") && said.contains("do:"), "{said}");
}

#[test]
fn a_beginning_from_a_folder_has_its_card_and_the_files_that_it_names() {
    let project = Project::new("begun");
    let folder = project.path("");
    let (said, code) = study(&project, &["init", "copy", "--from", folder.to_str().unwrap()]);
    assert_eq!(code, Some(0), "{said}");
    let begun = project.0.join("data/raw/copy");
    assert_eq!(fs::read(begun.join(FILM)).unwrap(), fs::read(project.path(FILM)).unwrap());
    assert!(begun.join(LOG).is_file() && begun.join("cad/spine.stl").is_file());
    let card: toml::Table = fs::read_to_string(begun.join("specimen.toml")).unwrap().parse().unwrap();
    assert_eq!((card["name"].as_str(), card["trial"][0]["video"].as_str()), (Some("copy"), Some(FILM)));
    let (said, code) = study(&project, &["init", "copy", "--from", folder.to_str().unwrap()]);
    assert!(code == Some(1) && said.contains("never overwritten"), "{said}");
    let (said, code) = study(&project, &["init", "none", "--from", project.path("cad").to_str().unwrap()]);
    assert!(code == Some(1) && said.contains("holds no recordings"), "{said}");
}
