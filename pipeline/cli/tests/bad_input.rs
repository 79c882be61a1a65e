//! Bad input on the command line: one message that names file, line or face and the next action, exit
//! code 1 (2 for usage), and nothing already made is lost.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use mesh::stl;
use tail_cad::Tail;
use track::Gray;
use track::video::{Quality, Writer};

/// A small project: a card, two surfaces and one film; each test makes one of them invalid.
struct Project(PathBuf);

const FRAMES: usize = 24;

impl Project {
    fn new(name: &str) -> Self {
        let root = std::env::temp_dir().join(format!("bad-input-{name}-{}", std::process::id()));
        let folder = root.join("data/raw/fish");
        for part in ["cad", "camera", "trials/static_left"] {
            fs::create_dir_all(folder.join(part)).unwrap();
        }
        fs::write(root.join("study.toml"), include_str!("../../../study.toml")).unwrap();
        fs::write(folder.join("specimen.toml"), include_str!("../../study/tests/card.toml")).unwrap();
        let (body, spine) = Tail::nine_chambers().solids(3e-3).unwrap();
        fs::write(folder.join("cad/body.stl"), stl::write(&body, 1e-3, "body")).unwrap();
        fs::write(folder.join("cad/spine.stl"), stl::write(&spine, 1e-3, "spine")).unwrap();
        let project = Self(root);
        project.film();
        project
    }

    fn path(&self, place: &str) -> PathBuf {
        self.0.join("data/raw/fish").join(place)
    }

    /// One dark disc that moves by a pixel a frame on light ground.
    fn film(&self) {
        let path = self.path("trials/static_left/video.mp4");
        let mut film = Writer::create(&path, (320, 240), 60.0, Quality::Quantiser(24)).unwrap();
        for frame in 0..FRAMES {
            let x = 200.0 + frame as f64;
            let level = |u: usize, v: usize| if (u as f64 - x).hypot(v as f64 - 120.0) < 9.0 { 40.0 } else { 200.0 };
            film.push(&Gray::from_fn(320, 240, level)).unwrap();
        }
        film.finish().unwrap();
    }

    fn study(&self, words: &[&str]) -> Output {
        let study = env!("CARGO_BIN_EXE_study");
        Command::new(study).args(words).arg("--root").arg(&self.0).args(["--profile", "paper"]).output().unwrap()
    }

    /// Runs and expects exit code 1 and these pieces in the message.
    fn refuses(&self, words: &[&str], pieces: &[&str]) {
        let output = self.study(words);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        for piece in pieces.iter().chain(&["why:", "do:"]) {
            assert!(said.contains(piece), "`{piece}` is not in:\n{said}");
        }
    }
}

impl Drop for Project {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn sound_input_is_meshed_and_tracked() {
    let project = Project::new("sound");
    let output = project.study(&["run", "mesh", "track"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.contains("1 markers × 24 frames"), "{said}");
}

#[test]
fn an_unknown_key_is_named_with_its_line_and_the_nearest_known_one() {
    let project = Project::new("key");
    let card = include_str!("../../study/tests/card.toml").replace("poissons_ratio = 0.49", "poisson_ratio = 0.49");
    fs::write(project.path("specimen.toml"), &card).unwrap();
    let line = 1 + card.lines().position(|l| l.contains("poisson_ratio")).unwrap();
    project.refuses(&["plan"], &["specimen.toml", &format!("line {line}"), "poisson_ratio", "poissons_ratio"]);
}

#[test]
fn a_surface_with_a_hole_is_refused_with_a_face_and_records_stay() {
    let project = Project::new("hole");
    assert!(project.study(&["run", "mesh"]).status.success());
    let record = project.0.join("data/processed/mesh/fish/record/mesh.json");
    let before = fs::read(&record).unwrap();
    let (mut body, _) = Tail::nine_chambers().solids(3e-3).unwrap();
    body.faces.truncate(body.faces.len() - 1);
    fs::write(project.path("cad/body.stl"), stl::write(&body, 1e-3, "body")).unwrap();
    project.refuses(&["run", "mesh"], &["body", "face"]);
    assert_eq!(fs::read(&record).unwrap(), before);
}

#[test]
fn a_surface_in_metres_read_as_millimetres_is_refused() {
    let project = Project::new("metres");
    let (body, _) = Tail::nine_chambers().solids(3e-3).unwrap();
    fs::write(project.path("cad/body.stl"), stl::write(&body, 1.0, "body")).unwrap();
    project.refuses(&["run", "mesh"], &["body.stl", "unit"]);
}

#[test]
fn a_missing_film_is_named() {
    let project = Project::new("film");
    fs::remove_file(project.path("trials/static_left/video.mp4")).unwrap();
    project.refuses(&["run", "track"], &["data/raw/fish/trials/static_left/video.mp4"]);
}

#[test]
fn a_film_cut_short_is_refused() {
    let project = Project::new("cut");
    let path = project.path("trials/static_left/video.mp4");
    let whole = fs::read(&path).unwrap();
    fs::write(&path, &whole[..whole.len() * 2 / 3]).unwrap();
    project.refuses(&["run", "track"], &["video.mp4"]);
}

#[test]
fn a_marker_clicked_far_off_is_named_with_its_frame() {
    let project = Project::new("click");
    let card =
        include_str!("../../study/tests/card.toml").replace("clicked = [200.0, 120.0]", "clicked = [60.0, 60.0]");
    fs::write(project.path("specimen.toml"), card).unwrap();
    project.refuses(&["run", "track"], &["marker `m1`", "frame 0", "contrast_limit"]);
}

#[test]
fn a_marker_that_is_lost_in_a_film_without_a_project_is_named_with_the_film() {
    let project = Project::new("lost");
    let film = project.path("trials/static_left/video.mp4");
    project.refuses(&["track", film.to_str().unwrap(), "--at", "60,60"], &["static_left/video.mp4: marker 0 is lost"]);
}

#[test]
fn a_setting_that_no_stage_reads_is_refused() {
    let project = Project::new("setting");
    let text = include_str!("../../../study.toml").replace("[mesh]", "[mash]");
    fs::write(project.0.join("study.toml"), text).unwrap();
    project.refuses(&["plan"], &["[mash]", "mesh"]);
}

#[test]
fn a_slip_on_the_command_line_ends_with_code_2() {
    let project = Project::new("usage");
    assert_eq!(project.study(&["rum"]).status.code(), Some(2));
}

#[test]
fn a_card_that_cannot_be_read_is_not_taken_for_a_missing_specimen() {
    let project = Project::new("card");
    let card = fs::read_to_string(project.path("specimen.toml")).unwrap();
    fs::write(project.path("specimen.toml"), card.replace("length = 0.1", "length = 100.0")).unwrap();
    for command in ["run", "plan"] {
        project.refuses(&[command, "--specimen", "fish"], &["specimen.toml, line 3", "length = 100 m is out of range"]);
    }
}

/// `study init` leaves a card of questions: it stops the specimen that it is of, and no other.
#[test]
fn an_unfilled_card_stops_no_other_specimen() {
    let project = Project::new("unfilled");
    assert!(project.study(&["init", "second"]).status.success());
    let plan = |specimen: &str| {
        let output = project.study(&["plan", "--specimen", specimen]);
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, said) = plan("fish");
    assert!(code == Some(0) && said.contains("another specimen is left out") && said.contains("second"), "{said}");
    assert_eq!(plan("second").0, Some(1));
    assert_eq!(project.study(&["plan"]).status.code(), Some(1));
}
