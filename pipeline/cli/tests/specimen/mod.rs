//! A small valid specimen: a film of one mark and a lamp, a board, two solids and a log.
#![allow(clippy::unwrap_used)]

pub mod print;

use std::fmt::Write;
use std::fs;
use std::path::PathBuf;
use std::sync::LazyLock;

use mesh::{Surface, stl};
use tail_cad::Tail;
use track::Gray;
use track::video::{Quality, Writer};

pub const RATE: f64 = 60.0;
/// When the lamp lights and goes out, s in the film: half way between two frames.
pub const LIT: [f64; 2] = [14.5 / RATE, 53.5 / RATE];
/// How much later the log's clock is, s.
pub const LATER: f64 = 0.1;

/// A project with one specimen of one trial.
pub struct Project(pub PathBuf);

impl Project {
    pub fn new(name: &str) -> Self {
        let project = Self(std::env::temp_dir().join(format!("doctor-{name}-{}", std::process::id())));
        for part in ["cad", "camera", "trials/static_left"] {
            fs::create_dir_all(project.path(part)).unwrap();
        }
        fs::write(project.0.join("study.toml"), include_str!("../../../../study.toml")).unwrap();
        project.write("specimen.toml", &card());
        let (body, spine) = solids();
        project.solid("body", &body, 1e-3);
        project.solid("spine", &spine, 1e-3);
        project.calibration(board);
        project.film(FILM, 66, picture);
        project.write(LOG, &log());
        project
    }

    pub fn path(&self, place: &str) -> PathBuf {
        self.0.join("data/raw/fish").join(place)
    }

    pub fn write(&self, place: &str, text: &str) {
        fs::write(self.path(place), text).unwrap();
    }

    pub fn solid(&self, word: &str, surface: &Surface, unit: f64) {
        fs::write(self.path(&format!("cad/{word}.stl")), stl::write(surface, unit, word)).unwrap();
    }

    /// The film of a board: on its plane as `flat` shows it, then the board of nine by six squares in several poses.
    pub fn calibration(&self, flat: impl Fn(usize) -> Gray) {
        let frames = ON_PLANE + VIEW * print::POSES;
        let posed = |k: usize| POSED[(k - ON_PLANE) / VIEW].clone();
        self.film("camera/calibration.mp4", frames, |k| if k < ON_PLANE { flat(k) } else { posed(k) });
    }

    pub fn film(&self, place: &str, frames: usize, picture: impl Fn(usize) -> Gray) {
        let mut film = Writer::create(&self.path(place), (320, 240), RATE, Quality::Quantiser(20)).unwrap();
        (0..frames).for_each(|k| film.push(&picture(k)).unwrap());
        film.finish().unwrap();
    }
}

/// The board of nine by six squares in its poses.
static POSED: LazyLock<Vec<Gray>> = LazyLock::new(|| {
    let board = |at| print::checkerboard([9, 6], 20.0, at);
    (0..print::POSES).map(|pose| print::posed(&board, pose)).collect()
});

/// Frames of the calibration in which the board lies on its plane, and frames of each pose.
const ON_PLANE: usize = 30;
const VIEW: usize = 6;

impl Drop for Project {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

pub const FILM: &str = "trials/static_left/video.mp4";
pub const LOG: &str = "trials/static_left/pressure.csv";

pub fn card() -> String {
    let lamp = ("centre = [600.0, 40.0]", "centre = [40.0, 40.0]");
    let times = ("hold = 1.0  # s\npause = 0.5", "hold = 0.2  # s\npause = 0.1");
    let plane = ("seconds = [5.0, 6.0]", "seconds = [0.0, 0.4]");
    let card = include_str!("../../../study/tests/card.toml");
    // so that the marker is seen where it is painted
    let origin = ("origin = [0.0, 0.0]  # m", "origin = [0.0263, -0.0242]  # m");
    [lamp, times, plane, origin].iter().fold(card.to_owned(), |text, (from, to)| changed(&text, from, to))
}

/// A text with a change; fails when nothing changes.
pub fn changed(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "`{from}` is not there");
    text.replace(from, to)
}

pub fn solids() -> (Surface, Surface) {
    Tail::nine_chambers().solids(3e-3).unwrap()
}

/// Fraction of the sampling interval during which the lamp is lit.
pub fn lit(film_time: f64, width: f64) -> f64 {
    let (from, to) = (film_time - 0.5 * width, film_time + 0.5 * width);
    ((to.min(LIT[1]) - from.max(LIT[0])) / width).clamp(0.0, 1.0)
}

/// One dark disc that moves by a quarter of a pixel a frame on light ground, and the lamp.
pub fn picture(frame: usize) -> Gray {
    with_lamp(frame, 110.0 + 140.0 * lit(frame as f64 / RATE, 0.9 / RATE))
}

pub fn with_lamp(frame: usize, lamp: f64) -> Gray {
    let x = 200.0 + 0.25 * frame as f64;
    Gray::from_fn(320, 240, |u, v| {
        let from = |at: [f64; 2]| (u as f64 - at[0]).hypot(v as f64 - at[1]);
        if from([40.0, 40.0]) < 16.0 {
            lamp
        } else if from([x, 120.0]) < 9.0 {
            40.0
        } else {
            200.0
        }
    })
}

/// Nine by six squares.
pub fn board(_: usize) -> Gray {
    shown(0.0, 1.0)
}

/// The same, carried by `along` px and with its squares so much narrower than high.
pub fn shown(along: f64, narrow: f64) -> Gray {
    Gray::from_fn(320, 240, |u, v| {
        let square = (f64::from(u as u32) - 70.0 - along) / (20.0 * narrow);
        let inside = (0.0..9.0).contains(&square) && (60..180).contains(&v);
        let dark = inside && (square as usize + v.wrapping_sub(60) / 20).is_multiple_of(2);
        if dark { 30.0 } else { 220.0 }
    })
}

/// Two levels on the left, 200 samples a second.
pub fn log() -> String {
    let mut text = "time_s,left_command_mbar,right_command_mbar,left_mbar,right_mbar,led\n".to_owned();
    let mut measured = 0.0;
    for i in 0..260 {
        let time = f64::from(i) * 0.005;
        let asked = |from: f64| (from..from + 0.2).contains(&time);
        let command = if asked(0.4) {
            50.0
        } else if asked(0.7) {
            100.0
        } else {
            0.0
        };
        measured += (command - measured) * 0.2;
        let lamp = lit(time - LATER, 0.005);
        writeln!(text, "{time:.4},{command:.2},0.00,{measured:.2},0.20,{lamp:.3}").unwrap();
    }
    text
}
