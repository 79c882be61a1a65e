//! A small recording of the whole bench: reproducible, readable by `lab`, and never over a folder of another origin.
#![allow(clippy::unwrap_used)] // a panic fails the test

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use lab::{Specimen, truth};
use rig::progress::Progress;
use rig::record::{Request, STATICS, Status, parts, record, record_part, record_some};
use rig::settings::{Profile, Resolution, Settings};
use rig::specimens::ALL;
use rig::stamp;
use track::video::Reader;

/// A folder of its own for one test, gone afterwards.
struct TestFolder(PathBuf);

impl TestFolder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("rig_{name}_{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }
}

impl Drop for TestFolder {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.0).unwrap();
    }
}

/// The built-in settings with a profile of a few frames and elements.
fn tiny() -> Settings {
    let mut set = Settings::built_in();
    let profile = Profile {
        specimens: vec![ALL[0].name.to_string()],
        resolution: Resolution { edge: 0.010, per_chamber: 1, per_rib: 1, hexahedra: None },
        levels: 4,
        step: 1.0 / 60.0,
        rest: 0.05,
        hold: 0.1,
        pause: 0.05,
        cycles: 1,
        repeats: 1,
        brief: true,
        poses: 1,
    };
    let own = set.specimen.get_mut(&*ALL[0].name).unwrap();
    (own.levels, own.levels_in_water) = (vec![1500.0], vec![1500.0]);
    own.flaps.clear();
    set.calibration.flat = 4;
    set.profile.insert("tiny".to_owned(), profile);
    set
}

fn record_tiny(into: &Path) -> diagnostics::Result<Status> {
    let progress = Progress::new(true);
    record(&ALL[0], &Request { set: &tiny(), profile: "tiny", into, progress: &progress })
}

fn recorded(into: &Path) -> Status {
    record_tiny(into).unwrap_or_else(|error| panic!("{error}"))
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
fn a_recording_is_read_by_lab_and_is_reproducible_to_the_byte() {
    let folder = TestFolder::new("twice");
    let (first, second) = (folder.0.join("a"), folder.0.join("b"));
    assert_eq!((recorded(&first), recorded(&second)), (Status::Recorded, Status::Recorded));
    // what a process that is killed after its last step leaves is removed by the next
    let left = first.join(&*ALL[0].name).join("checkpoints");
    std::fs::create_dir(&left).unwrap();
    std::fs::write(left.join("statics"), "equilibria").unwrap();
    assert_eq!(recorded(&first), Status::UpToDate);
    let (a, b) = (bytes(&first), bytes(&second));
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    let differing: Vec<&PathBuf> = a.keys().filter(|name| a[*name] != b[*name]).collect();
    assert!(differing.is_empty(), "{differing:?}");
    assert_complete(&first.join(&*ALL[0].name));
}

/// Logs of the load cell agree with their ground truth, and the taps are in both logs at the same time.
fn assert_force_logs(specimen: &Specimen) {
    let truth = truth::read(&specimen.folder.join(lab::folder::TRUTH)).unwrap();
    let cell = truth.cell.unwrap();
    assert!((10.0..20.0).contains(&((cell.stiffness / cell.mass).sqrt() / std::f64::consts::TAU)));
    for fixture in &specimen.card.fixture {
        let log = lab::force::read(&specimen.file(&fixture.force)).unwrap();
        let hidden = truth.force.iter().find(|f| f.id == fixture.id).unwrap();
        assert!((log.rate() - 80.0).abs() < 1e-3);
        if let lab::card::FixtureOf::Taps { hammer, .. } = &fixture.of {
            let struck = lab::force::read(&specimen.file(hammer)).unwrap();
            let first = struck.time[struck.force.iter().position(|f| *f > 1.0).unwrap()];
            let begins = hidden.clock_offset + hidden.clock_scale * hidden.taps[0].time;
            assert!((first - begins).abs() < 3e-3 && log.force.iter().any(|f| f.abs() > 0.3));
        }
    }
}

/// Card, logs, film, ground truth and tracks agree.
fn assert_complete(folder: &Path) {
    let specimen = Specimen::open(folder).unwrap();
    assert_eq!(specimen.missing(), []);
    assert_force_logs(&specimen);
    let truth = truth::read(&folder.join(lab::folder::TRUTH)).unwrap();
    for (trial, hidden) in specimen.card.trial.iter().zip(&truth.trial) {
        let log = lab::pressure::read(&specimen.file(&trial.pressure), &specimen.card.channels()).unwrap();
        let film = Reader::open(&specimen.file(trial.video.as_ref().unwrap())).unwrap().info();
        let tracks = truth::read_tracks(&specimen.file(&hidden.tracks)).unwrap();
        assert_eq!((film.width, film.height, film.frames), (1280, 720, tracks[0].time.len()));
        assert!(log.time[log.time.len() - 1] > hidden.clock_offset + film.frames as f64 / film.rate);
        for (marker, track) in specimen.card.marker.iter().zip(&tracks) {
            let [du, dv] = [0, 1].map(|k| marker.clicked.unwrap()[k] - track.pixel[0][k]);
            let near = if trial.medium == lab::card::Medium::Water { 60.0 } else { 10.0 }; // clicked in air
            assert!(marker.name == track.marker && du.hypot(dv) < near, "{} {du} {dv}", track.marker);
        }
    }
}

#[test]
fn a_recording_made_part_by_part_side_by_side_has_the_bytes_of_one_made_whole() {
    let folder = TestFolder::new("parts");
    let (whole, parted) = (folder.0.join("a"), folder.0.join("b"));
    recorded(&whole);
    let (set, progress) = (tiny(), Progress::new(true));
    let request = Request { set: &set, profile: "tiny", into: &parted, progress: &progress };
    let (others, trials) = parts(&ALL[0], &request);
    let made = |part: &str| record_part(&ALL[0], &request, part).unwrap_or_else(|error| panic!("{error}"));
    // every part is asked for twice at once, and trials before what they need
    let all: Vec<&str> = trials.iter().map(String::as_str).chain(others).collect();
    std::thread::scope(|scope| {
        let parts = all.iter().chain(&all);
        parts.for_each(|part| drop(scope.spawn(|| assert_eq!(made(part), Status::Recorded))));
    });
    assert_eq!((recorded(&parted), made(STATICS)), (Status::Recorded, Status::UpToDate));
    assert!(bytes(&whole) == bytes(&parted));
    let error = record_part(&ALL[0], &request, "static_up").unwrap_err().to_string();
    assert!(
        error.contains("no part `static_up`") && error.contains("it has statics, calibration, static_left"),
        "{error}"
    );
}

#[test]
fn some_trials_can_be_read_and_what_is_left_has_the_bytes_of_a_recording_made_whole() {
    let folder = TestFolder::new("some");
    let (whole, some) = (folder.0.join("a"), folder.0.join("b"));
    recorded(&whole);
    let (set, progress) = (tiny(), Progress::new(true));
    let request = Request { set: &set, profile: "tiny", into: &some, progress: &progress };
    let record = |trials: &[&str]| {
        let trials: Vec<String> = trials.iter().map(ToString::to_string).collect();
        record_some(&ALL[0], &request, &trials)
    };
    assert_eq!([record(&[]).unwrap(), record(&[]).unwrap()], [Status::Recorded, Status::UpToDate]);
    let specimen = some.join(&*ALL[0].name);
    assert!(Specimen::open(&specimen).is_ok() && !specimen.join("trials").exists());
    assert_eq!(
        [record(&["static_left"]).unwrap(), record(&["static_left"]).unwrap()],
        [Status::Recorded, Status::UpToDate]
    );
    for file in
        ["trials/static_left/video.mp4", "trials/static_left/pressure.csv", "camera/calibration.mp4", "cad/body.stl"]
    {
        let read = |into: &Path| std::fs::read(into.join(&*ALL[0].name).join(file)).unwrap();
        assert!(read(&whole) == read(&some), "{file}");
    }
    assert!(!specimen.join("trials/static_right/video.mp4").exists() && !specimen.join("truth.toml").exists());
    assert_eq!(record(&["calibration", "taps"]).unwrap(), Status::UpToDate);
    let error = record(&["static_up"]).unwrap_err().to_string();
    assert!(error.contains("no part `static_up`") && error.contains("static_left"), "{error}");
    assert_eq!((recorded(&some), record(&["static_left"]).unwrap()), (Status::Recorded, Status::UpToDate));
    assert!(bytes(&whole) == bytes(&some));
}

#[test]
fn a_folder_that_the_bench_did_not_make_is_an_error_and_is_not_changed() {
    let folder = TestFolder::new("other");
    let own = folder.0.join(&*ALL[0].name);
    std::fs::create_dir_all(&own).unwrap();
    std::fs::write(own.join("specimen.toml"), "a laboratory's card").unwrap();
    let error = record_tiny(&folder.0).unwrap_err().to_string();
    assert!(error.contains("was not made by the virtual bench") && error.contains("do:"), "{error}");
    assert_eq!(bytes(&folder.0).len(), 1);
}

#[test]
fn a_recording_with_other_settings_or_a_missing_file_is_stale() {
    let folder = TestFolder::new("stale");
    let stamped = stamp::stamp_text(&ALL[0], "quick");
    std::fs::write(folder.0.join(stamp::FILE), &stamped).unwrap();
    assert_eq!(stamp::inspect_folder(&folder.0, &stamped).unwrap(), stamp::FolderState::Stale, "its card is missing");
    assert_ne!(stamped, stamp::stamp_text(&ALL[0], "paper"));
    assert_eq!(stamp::inspect_folder(&folder.0.join("absent"), &stamped).unwrap(), stamp::FolderState::Absent);
}
