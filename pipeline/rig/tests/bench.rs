//! The bench as a whole, on a recording small enough for a test: same bytes, readable by `lab`, never over a stranger.
//!
//! Stands on: `rig`, `lab`, `track`. Never knows: the pipeline.
#![allow(clippy::unwrap_used)] // a test may fail where it stands

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use lab::{Specimen, truth};
use rig::progress::Progress;
use rig::record::{Outcome, record};
use rig::settings::{Profile, Resolution, Settings};
use rig::specimens::ALL;
use rig::stamp;
use track::video::Reader;

/// A folder of its own for one test, gone afterwards.
struct World(PathBuf);

impl World {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("rig_{name}_{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for World {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.0).unwrap();
    }
}

/// The built-in bench with a profile of a few frames and elements.
fn tiny() -> Settings {
    let mut set = Settings::built_in();
    let profile = Profile {
        resolution: Resolution { edge: 0.010, per_chamber: 1, per_rib: 1 },
        rungs: 4,
        step: 1.0 / 60.0,
        rest: 0.05,
        hold: 0.1,
        pause: 0.05,
        cycles: 1,
        repeats: 1,
        brief: true,
        poses: 1,
    };
    let own = set.specimen.get_mut(ALL[0].name).unwrap();
    (own.levels, own.levels_in_water) = (vec![1500.0], vec![1500.0]);
    own.flaps.clear();
    set.calibration.flat = 4;
    set.profile.insert("tiny".to_owned(), profile);
    set
}

fn recorded(into: &Path) -> Outcome {
    record(&ALL[0], &tiny(), "tiny", into, &Progress::new(true)).unwrap_or_else(|fault| panic!("{fault}"))
}

/// Every file under `folder` with its bytes.
fn bytes(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => found
                .extend(bytes(&path).into_iter().map(|(name, b)| (Path::new(path.file_name().unwrap()).join(name), b))),
            false => drop(found.insert(PathBuf::from(path.file_name().unwrap()), std::fs::read(&path).unwrap())),
        }
    }
    found
}

#[test]
fn a_recording_is_read_by_lab_and_has_the_same_bytes_when_made_again() {
    let world = World::new("twice");
    let (first, second) = (world.0.join("a"), world.0.join("b"));
    assert_eq!((recorded(&first), recorded(&second), recorded(&first)), (Outcome::Made, Outcome::Made, Outcome::Kept));
    let (a, b) = (bytes(&first), bytes(&second));
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    let differing: Vec<&PathBuf> = a.keys().filter(|name| a[*name] != b[*name]).collect();
    assert!(differing.is_empty(), "{differing:?}");
    the_folder_is_whole(&first.join(ALL[0].name));
}

/// Logs of the load cell and their truth fit each other, and the taps are in both logs at once.
fn the_cell_was_read(specimen: &Specimen) {
    let truth = truth::read(&specimen.folder.join(lab::folder::TRUTH)).unwrap();
    let cell = truth.cell.unwrap();
    assert!((10.0..20.0).contains(&((cell.stiffness / cell.mass).sqrt() / std::f64::consts::TAU)));
    for fixture in &specimen.card.fixture {
        let log = lab::force::read(&specimen.file(&fixture.force)).unwrap();
        let hidden = truth.force.iter().find(|f| f.id == fixture.id).unwrap();
        assert!((log.rate() - 80.0).abs() < 1e-3);
        if let lab::card::FixtureOf::Taps { hammer } = &fixture.of {
            let struck = lab::force::read(&specimen.file(hammer)).unwrap();
            let first = struck.time[struck.force.iter().position(|f| *f > 1.0).unwrap()];
            let begins = hidden.clock_offset + hidden.clock_scale * hidden.taps[0].time;
            assert!((first - begins).abs() < 3e-3 && log.force.iter().any(|f| f.abs() > 0.3));
        }
    }
}

/// Card, log, film, truth and tracks fit each other.
fn the_folder_is_whole(folder: &Path) {
    let specimen = Specimen::open(folder).unwrap();
    assert_eq!(specimen.missing(), []);
    the_cell_was_read(&specimen);
    let truth = truth::read(&folder.join(lab::folder::TRUTH)).unwrap();
    for (trial, hidden) in specimen.card.trial.iter().zip(&truth.trial) {
        let log = lab::pressure::read(&specimen.file(&trial.pressure)).unwrap();
        let film = Reader::open(&specimen.file(&trial.video)).unwrap().info();
        let tracks = truth::read_tracks(&specimen.file(&hidden.tracks)).unwrap();
        assert_eq!((film.width, film.height, film.frames), (1280, 720, tracks[0].time.len()));
        assert!(log.time[log.time.len() - 1] > hidden.clock_offset + film.frames as f64 / film.rate);
        for (marker, track) in specimen.card.marker.iter().zip(&tracks) {
            let [du, dv] = [0, 1].map(|k| marker.clicked.unwrap()[k] - track.pixel[0][k]);
            let near = if trial.medium == lab::card::Medium::Water { 60.0 } else { 10.0 }; // clicked in air, once
            assert!(marker.name == track.marker && du.hypot(dv) < near, "{} {du} {dv}", track.marker);
        }
    }
}

#[test]
fn a_folder_that_the_bench_did_not_make_is_refused_and_left_alone() {
    let world = World::new("stranger");
    let folder = world.0.join(ALL[0].name);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("specimen.toml"), "a laboratory's card").unwrap();
    let fault = record(&ALL[0], &tiny(), "tiny", &world.0, &Progress::new(true)).unwrap_err().to_string();
    assert!(fault.contains("was not made by the virtual bench") && fault.contains("do:"), "{fault}");
    assert_eq!(bytes(&world.0).len(), 1);
}

#[test]
fn a_recording_with_other_settings_or_with_a_lost_file_is_stale() {
    let world = World::new("stale");
    let stamped = stamp::text(&ALL[0], "quick");
    std::fs::write(world.0.join(stamp::FILE), &stamped).unwrap();
    assert_eq!(stamp::look(&world.0, &stamped).unwrap(), stamp::Found::Stale, "its card is lost");
    assert_ne!(stamped, stamp::text(&ALL[0], "paper"));
    assert_eq!(stamp::look(&world.0.join("absent"), &stamped).unwrap(), stamp::Found::Nothing);
}
