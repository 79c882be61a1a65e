//! `study track` on any film: a part of it, a cut in its scene, and a large ball.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use track::Gray;
use track::video::{Quality, Writer};

struct Film(PathBuf);

impl Film {
    fn new(name: &str, frames: usize, picture: impl Fn(usize) -> Gray) -> Self {
        let folder = std::env::temp_dir().join(format!("track-film-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let mut film = Writer::create(&folder.join("film.mp4"), (320, 240), 60.0, Quality::Quantiser(20)).unwrap();
        (0..frames).for_each(|k| film.push(&picture(k)).unwrap());
        film.finish().unwrap();
        Self(folder)
    }

    fn track(&self, words: &[&str]) -> Output {
        let film = self.0.join("film.mp4");
        Command::new(env!("CARGO_BIN_EXE_study")).arg("track").arg(film).args(words).output().unwrap()
    }

    /// Frame, u and whether it was seen, a line each.
    fn rows(&self) -> Vec<(usize, f64, bool)> {
        let text = fs::read_to_string(self.0.join("film.mp4.tracks/tracks.csv")).unwrap();
        let row = |line: &str| {
            let words: Vec<&str> = line.split(',').collect();
            (words[0].parse().unwrap(), words[3].parse().unwrap(), words[9] == "1")
        };
        text.lines().skip(1).map(row).collect()
    }
}

impl Drop for Film {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A dark ball at `x` on uneven ground.
fn ball(x: f64, radius: f64, ground: f64) -> Gray {
    Gray::from_fn(320, 240, |u, v| {
        let light = 190.0 + 30.0 * ((u as f64 * 0.03 * ground).sin() + (v as f64 * 0.04 * ground).cos());
        let edge = (radius + 0.5 - (u as f64 - x).hypot(v as f64 - 120.0)).clamp(0.0, 1.0);
        light + edge * (40.0 - light)
    })
}

#[test]
fn a_part_of_a_film_is_tracked_with_the_frames_of_the_film() {
    let film = Film::new("part", 30, |k| ball(100.0 + 2.0 * k as f64, 7.0, 1.0));
    let output = film.track(&["--at", "120,120", "--first", "10", "--last", "19"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let rows = film.rows();
    assert_eq!((rows.len(), rows[0].0, rows[9].0), (10, 10, 19));
    assert!((rows[0].1 - 120.0).abs() < 0.1 && (rows[9].1 - 138.0).abs() < 0.1, "{rows:?}");
    let beyond = film.track(&["--at", "120,120", "--first", "40"]);
    let said = String::from_utf8_lossy(&beyond.stderr).into_owned();
    assert!(beyond.status.code() == Some(1) && said.contains("the film has 30 frames"), "{said}");
}

#[test]
fn a_disc_that_holds_no_marker_is_refused() {
    let film = Film::new("disc", 2, |_| ball(100.0, 7.0, 1.0));
    let output = film.track(&["--at", "100,120", "--radius", "3.9"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() != Some(101) && said.contains("3.9 is not in 4..=1000"), "{said}");
}

#[test]
fn a_cut_in_the_scene_is_named_with_its_frame() {
    let film = Film::new("cut", 30, |k| if k < 18 { ball(100.0 + k as f64, 7.0, 1.0) } else { ball(220.0, 7.0, 2.7) });
    let output = film.track(&["--at", "100,120"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(1) && said.contains("the scene is cut at frame 18 (0.300 s)"), "{said}");
    assert!(said.contains("--last 17") && said.contains("--first 18"), "{said}");
    assert!(film.track(&["--at", "100,120", "--last", "17"]).status.success());
}

#[test]
fn a_ball_of_36_pixels_is_seen_in_every_frame() {
    let film = Film::new("ball", 40, |k| ball(120.0 + 3.0 * (0.3 * k as f64).sin() + k as f64, 36.0, 1.0));
    let output = film.track(&["--at", "120,120", "--radius", "52"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let rows = film.rows();
    let truth = |k: usize| 120.0 + 3.0 * (0.3 * k as f64).sin() + k as f64;
    assert!(rows.iter().all(|(_, _, seen)| *seen), "{rows:?}");
    assert!(rows.iter().all(|(k, u, _)| (u - truth(*k)).abs() < 0.15), "{rows:?}");
}

#[test]
fn of_many_films_each_is_tracked_and_a_table_says_what_was_lost_where() {
    let film = Film::new("many", 20, |k| ball(100.0 + k as f64, 7.0, 1.0));
    let path = |name: &str| film.0.join(name);
    let mut other = Writer::create(&path("gone.mp4"), (320, 240), 60.0, Quality::Quantiser(20)).unwrap();
    // the ball leaves the picture in frame 12
    (0..20).for_each(|k| other.push(&ball(if k < 12 { 100.0 + k as f64 } else { 900.0 }, 7.0, 1.0)).unwrap());
    other.finish().unwrap();
    let mut study = Command::new(env!("CARGO_BIN_EXE_study"));
    let films = [path("film.mp4"), path("gone.mp4"), path("absent.mp4")];
    let output = study.arg("track").args(&films).args(["--at", "100,120", "--hidden", "0.05"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.code() == Some(1) && said.contains("3 films, 2 not tracked to their end"), "{said}");
    let table = fs::read_to_string(path("tracked.csv")).unwrap();
    let lines: Vec<&str> = table.lines().collect();
    assert!(lines.len() == 4 && lines[1].contains("film.mp4\",1,"), "{table}");
    assert!(lines[2].contains("gone.mp4\",0,") && lines[2].contains("frame 12"), "{table}");
    assert!(lines[3].contains("absent.mp4\",0,") && lines[3].contains("is not there"), "{table}");
    assert_eq!(film.rows().len(), 20);
}
