//! Recordings of an actuator with known moduli, as a laboratory with a motion capture system writes them: a film of the lamp, a pressure log
//! and the markers' places in space.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use lab::card::{self, Card, Experiment};
use sysid::{Attached, Body, Elastic, Meshed, Model, NamedRegion};
use track::Gray;
use track::video::{Quality, Writer};

/// Frames and positions a second.
const RATE: f64 = 50.0;
/// Time at which the lamp lights and the first command is given, s: half way between two frames.
const LIT: f64 = 0.51;
/// Samples of the pressure log a second.
const LOG_RATE: f64 = 200.0;

/// A project with one specimen.
pub struct Project {
    root: PathBuf,
    card: Card,
}

impl Project {
    /// A project with the card in `text` and further files of the specimen, which begins without a recording.
    pub fn new(text: &str, files: &[(&str, Vec<u8>)]) -> Self {
        let card = card::parse(text, Path::new("specimen.toml")).unwrap();
        let root = std::env::temp_dir().join(format!("actuator-{}-{}", card.name, std::process::id()));
        let project = Self { root, card };
        project.write("specimen.toml", text.as_bytes());
        files.iter().for_each(|(place, bytes)| project.write(place, bytes));
        fs::write(project.root.join("study.toml"), include_str!("../../../../study.toml")).unwrap();
        project
    }

    fn write(&self, place: &str, bytes: &[u8]) {
        let path = self.root.join("data/raw").join(&self.card.name).join(place);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }

    /// Records every trial of a specimen with this mesh and these moduli, Pa.
    pub fn record(&self, meshed: &Meshed, moduli: &[f64]) {
        let solid = &meshed.solid;
        let skins: Vec<u16> = self.card.chamber.iter().map(|c| mesh::chamber_at(solid, c.at).unwrap()).collect();
        let spots = self.card.marker.iter().map(|m| mesh::embed(solid, m.at).0).collect();
        let whole = mesh::Solid::Quadratic(solid.clone());
        let clamped = self.card.clamp.surface.as_ref().map_or(Vec::new(), |surface| meshed.clamped(surface).unwrap());
        let model =
            Model::new(&whole, Attached { chambers: &skins, clamped: &clamped }, spots, &Body::of(&self.card)).unwrap();
        let hidden = Elastic { youngs_moduli: moduli.to_vec(), ..model.nominal.clone() };
        for trial in &self.card.trial {
            if let Some(video) = &trial.video {
                self.film(trial, video);
            }
            self.write(&trial.pressure, self.log(trial).as_bytes());
            let tracks = self.card.tracks.iter().find(|tracks| tracks.trial == trial.id).unwrap();
            self.write(&tracks.file, self.places(trial, &model, &hidden).as_bytes());
        }
    }

    /// The level of a trial at a time (s) of the film, Pa.
    fn level(trial: &card::Trial, time: f64) -> f64 {
        let Experiment::Staircase { levels, hold, pause, .. } = &trial.experiment else { panic!("a staircase") };
        let since = time - LIT;
        let index = (since / (hold + pause)).floor();
        let held = since >= 0.0 && since - index * (hold + pause) < *hold;
        if held { levels.get(index as usize).copied().unwrap_or(0.0) } else { 0.0 }
    }

    fn lasts(trial: &card::Trial) -> f64 {
        LIT + trial.experiment.duration()
    }

    fn film(&self, trial: &card::Trial, video: &str) {
        let path = self.root.join("data/raw").join(&self.card.name).join(video);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        let mut film = Writer::create(&path, (160, 120), RATE, Quality::Quantiser(20)).unwrap();
        for frame in 0..((Self::lasts(trial) + 0.5) * RATE) as usize {
            let time = frame as f64 / RATE;
            let on = (LIT..Self::lasts(trial)).contains(&time);
            let lamp = if on { 250.0 } else { 110.0 };
            let from = |u: usize, v: usize| (u as f64 - 40.0).hypot(v as f64 - 40.0);
            film.push(&Gray::from_fn(160, 120, |u, v| if from(u, v) < 16.0 { lamp } else { 200.0 })).unwrap();
        }
        film.finish().unwrap();
    }

    fn log(&self, trial: &card::Trial) -> String {
        let channels = self.card.channels();
        let mut titles = lab::pressure::titles(&channels);
        // without a film there is no lamp, and the log's clock is as far ahead of the places as the card says
        titles.truncate(titles.len() - usize::from(trial.video.is_none()));
        let ahead = self.card.in_space(trial).map_or(0.0, |(_, axes)| axes.start);
        let mut text = titles.join(",") + "\n";
        for i in 0..((Self::lasts(trial) + 0.5) * LOG_RATE) as usize {
            let time = i as f64 / LOG_RATE;
            let level = Self::level(trial, time) / 100.0;
            let driven = |name: &String| if trial.experiment.channels().contains(name) { level } else { 0.0 };
            let both = channels.iter().map(driven).chain(channels.iter().map(driven));
            let fields: String = both.map(|mbar| format!(",{mbar:.2}")).collect();
            let lamp = u8::from((LIT..Self::lasts(trial)).contains(&time));
            let lamp = trial.video.as_ref().map_or(String::new(), |_| format!(",{lamp}"));
            writeln!(text, "{:.4}{fields}{lamp}", time + ahead).unwrap();
        }
        text
    }

    fn places(&self, trial: &card::Trial, model: &Model, hidden: &Elastic) -> String {
        let Experiment::Staircase { levels, .. } = &trial.experiment else { panic!("a staircase") };
        let mut solver = model.system.solver();
        hidden.apply(&mut solver).unwrap();
        let mut shape = |level: f64| -> Vec<[f64; 3]> {
            let driven = |c: &card::Chamber| trial.experiment.channels().contains(&c.channel);
            let pressures: Vec<f64> = self.card.chamber.iter().map(|c| if driven(c) { level } else { 0.0 }).collect();
            let found = solver.equilibrium(&pressures, None, &Default::default()).unwrap();
            let moved = |spot: &mesh::Spot| {
                let at = Model::in_plane(spot, &found.displacement);
                [at[0], at[1], 0.0]
            };
            model.markers.iter().map(moved).collect()
        };
        let shapes: Vec<(f64, Vec<[f64; 3]>)> =
            levels.iter().chain([&0.0]).map(|level| (*level, shape(*level))).collect();
        let mut text = "frame,time_s,marker,x_mm,y_mm,z_mm\n".to_owned();
        for frame in 0..((Self::lasts(trial) + 0.5) * RATE) as usize {
            let time = frame as f64 / RATE;
            let level = Self::level(trial, time);
            let moved = &shapes.iter().find(|(of, _)| *of == level).unwrap().1;
            for (marker, by) in self.card.marker.iter().zip(moved) {
                let [x, y, z] = [0, 1, 2].map(|k| 1e3 * (marker.at[k] + by[k]));
                writeln!(text, "{frame},{time:.4},{},{x:.5},{y:.5},{z:.5}", marker.name).unwrap();
            }
        }
        text
    }

    /// Runs `study` on it.
    pub fn study(&self, words: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_study")).args(words).arg("--root").arg(&self.root).output().unwrap()
    }

    /// A metric of the specimen after `study run`.
    pub fn metric(&self, id: &str) -> f64 {
        let text = fs::read_to_string(self.root.join("data/processed/metrics.json")).unwrap();
        let all: Vec<serde_json::Value> = serde_json::from_str(&text).unwrap();
        let found = all.iter().find(|metric| metric["id"] == id).unwrap_or_else(|| panic!("{id} in {text}"));
        found["value"].as_f64().unwrap()
    }
}

impl Drop for Project {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.root);
    }
}

/// The regions of a card.
pub fn regions(text: &str) -> Vec<NamedRegion> {
    NamedRegion::all(&card::parse(text, Path::new("specimen.toml")).unwrap().solid)
}
