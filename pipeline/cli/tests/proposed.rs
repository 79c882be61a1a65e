//! `study doctor FOLDER` and `study init NAME --from FOLDER` on the recordings of one trial.
#![allow(clippy::unwrap_used)]

mod specimen;

use std::fs;
use std::process::Command;

use specimen::{FILM, LATER, LOG, Project, RATE, log};
use track::Gray;

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
    assert!(said.contains("certain  trial.C0001.lag.pressure = 0.10"), "{said}");
    let text = fs::read_to_string(folder.join("specimen.toml")).unwrap();
    assert!(text.contains("# lag of the pressure log = 0.10"), "{text}");
    let card: toml::Table = text.parse().unwrap();
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

/// A film in which a mark follows the pressure of the log, whose clock is later by `later` (s); no lamp is seen.
fn moved_by_pressure(project: &Project, later: f64) {
    let rows: Vec<f64> = log().lines().skip(1).map(|line| line.split(',').nth(3).unwrap().parse().unwrap()).collect();
    project.film(FILM, 66, |frame| {
        let sample = ((frame as f64 / RATE + later) / 0.005) as usize;
        let x = 100.0 + 0.8 * rows[sample.min(rows.len() - 1)];
        Gray::from_fn(320, 240, |u, v| if (u as f64 - x).hypot(v as f64 - 120.0) < 12.0 { 40.0 } else { 200.0 })
    });
}

#[test]
fn without_a_lamp_the_lag_is_that_at_which_picture_and_pressures_change_together() {
    let project = Project::new("lampless");
    let folder = project.0.join("lab");
    fs::create_dir_all(&folder).unwrap();
    for later in [LATER, 0.2] {
        moved_by_pressure(&project, later);
        fs::copy(project.path(FILM), folder.join("a.mp4")).unwrap();
        let dark: String = log().lines().map(|line| line.rsplit_once(',').unwrap().0.to_owned() + "\n").collect();
        fs::write(folder.join("b.csv"), dark).unwrap();
        let (said, code) = study(&project, &["doctor", folder.to_str().unwrap()]);
        assert_eq!(code, Some(0), "{said}");
        let line =
            said.lines().find(|line| line.contains("trial.a.lag.pressure = ")).unwrap_or_else(|| panic!("{said}"));
        let lag: f64 = line.split(" = ").nth(1).unwrap().split(';').next().unwrap().parse().unwrap();
        assert!((lag - later).abs() < 0.03, "{line}");
        assert!(line.starts_with("likely"), "{line}");
        // the mark's edge goes dark, light and dark, but no log has a lamp that is on as long
        assert!(!said.contains("likely   led.centre") && !said.contains("certain  trial"), "{said}");
        fs::remove_file(folder.join("specimen.toml")).unwrap();
    }
}
