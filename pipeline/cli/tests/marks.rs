//! Detected markers and imported positions, from the command line to records.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use track::Gray;
use track::video::{Quality, Writer};

/// A project with a film of three discs that move by half a pixel a frame.
struct Project(PathBuf);

const FRAMES: usize = 30;
const CARD: &str = include_str!("../../study/tests/card.toml");
const CLICKED: &str = "clicked = [200.0, 120.0]  # px\n";

impl Project {
    fn new(name: &str, card: &str) -> Self {
        let root = std::env::temp_dir().join(format!("markers-{name}-{}", std::process::id()));
        let project = Self(root);
        fs::create_dir_all(project.path("trials/static_left")).unwrap();
        fs::write(project.0.join("study.toml"), include_str!("../../../study.toml")).unwrap();
        fs::write(project.path("specimen.toml"), card).unwrap();
        let film = project.path("trials/static_left/video.mp4");
        let mut film = Writer::create(&film, (320, 240), 60.0, Quality::Quantiser(20)).unwrap();
        (0..FRAMES).for_each(|k| film.push(&picture(k)).unwrap());
        film.finish().unwrap();
        project
    }

    fn path(&self, place: &str) -> PathBuf {
        self.0.join("data/raw/fish").join(place)
    }

    fn run(&self, stage: &str) -> Output {
        let study = env!("CARGO_BIN_EXE_study");
        Command::new(study).args(["run", stage, "--root"]).arg(&self.0).args(["--profile", "paper"]).output().unwrap()
    }

    /// The record's markers by name.
    fn names(&self, stage: &str) -> Vec<String> {
        let place =
            format!("data/processed/{stage}/fish/static_left/record/{}.json", NAMES[usize::from(stage != "track")]);
        let text = fs::read_to_string(self.0.join(place)).unwrap();
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        value["markers"].as_array().unwrap().iter().map(|m| m.as_str().unwrap().to_owned()).collect()
    }
}

const NAMES: [&str; 2] = ["tracks", "markers"];

impl Drop for Project {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn picture(frame: usize) -> Gray {
    let shift = 0.5 * frame as f64;
    Gray::from_fn(320, 240, |u, v| {
        let dark = [80.0, 150.0, 220.0].iter().any(|x| (u as f64 - x - shift).hypot(v as f64 - 120.0) < 9.0);
        if dark { 40.0 } else { 200.0 }
    })
}

/// A card of three markers that are detected.
fn searching(region: &str) -> String {
    let one = "[[marker]]\nname = \"m1\"\nat = [0.05, 0.0, 0.0174]  # m\ndiameter = 0.004  # m\n";
    let three = ["m1", "m2", "m3"].map(|name| one.replace("m1", name)).concat();
    let (before, after) = CARD.split_once("[[marker]]").unwrap();
    let (_, rest) = after.split_once("\n[camera]").unwrap();
    format!("{before}{three}\n[search]\nregion = {region}\norder = \"leftwards\"\n\n[camera]{rest}")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn markers_without_a_click_are_detected_and_tracked() {
    let project = Project::new("found", &searching("[40.0, 60.0, 280.0, 180.0]"));
    let output = project.run("track");
    assert!(output.status.success() && said(&output).contains("3 markers × 30 frames"), "{}", said(&output));
    assert_eq!(project.names("track"), ["m1", "m2", "m3"]);
}

#[test]
fn another_number_of_markers_than_on_the_card_is_refused_with_their_places() {
    let project = Project::new("two", &searching("[40.0, 60.0, 190.0, 180.0]"));
    let output = project.run("track");
    let said = said(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    for piece in
        ["shows 2 markers in frame 0: (80, 120) (150, 120); the card has 3", "why:", "do:", "region", "video.mp4"]
    {
        assert!(said.contains(piece), "`{piece}` is not in:\n{said}");
    }
}

/// A card whose trial was captured in space, and its places in `unit`.
fn captured(unit: &str, scale: f64) -> (String, String) {
    let tracks = "[[tracks]]\ntrial = \"static_left\"\nfile = \"trials/static_left/places.csv\"\nsigma = 1e-4\n\n[tracks.space]\nstart = 0.1\n";
    let mut places = format!("frame,time_s,marker,x_{unit},y_{unit},z_{unit}\n");
    for k in 0..20 {
        let (t, x) = (0.01 * f64::from(k), scale * (0.05 + 1e-4 * f64::from(k)));
        places += &format!("{k},{t:.2},m1,{x},0.0,{}\n", 0.0174 * scale);
    }
    (format!("{}\n{tracks}", CARD.replace(CLICKED, "")), places)
}

#[test]
fn places_of_another_instrument_need_no_camera() {
    let (card, places) = captured("mm", 1e3);
    let project = Project::new("space", &card);
    fs::write(project.path("trials/static_left/places.csv"), places).unwrap();
    let output = project.run("markers");
    assert!(output.status.success() && said(&output).contains("displacement up to 1.9 mm"), "{}", said(&output));
    assert_eq!(project.names("markers"), ["m1"]);
}

#[test]
fn places_in_the_wrong_unit_are_refused_with_the_file_and_the_marker() {
    let (card, places) = captured("m", 1e-3 * 1e3 / 20.0);
    let project = Project::new("unit", &card);
    fs::write(project.path("trials/static_left/places.csv"), places).unwrap();
    let output = project.run("markers");
    let said = said(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    for piece in ["places.csv", "marker `m1` at (0.0025, 0.0000) m", "the limit is 0.0200 m", "unit", "do:"] {
        assert!(said.contains(piece), "`{piece}` is not in:\n{said}");
    }
}
