//! A small recording of the bench: two staircases and two flapping trials of a coarse tail.

use std::path::PathBuf;

use lab::Specimen;
use lab::card::Medium;
use rig::progress::Progress;
use rig::record::{Request, record};
use rig::settings::{FlappingTrial, Profile, Resolution, Settings};
use rig::specimens::ALL;

/// The recording in a folder of its own, removed at the end.
pub struct Recorded {
    pub root: PathBuf,
    pub specimen: Specimen,
}

impl Recorded {
    pub fn new() -> Self {
        let root = std::env::temp_dir().join(format!("proposal-{}", std::process::id()));
        std::fs::create_dir_all(&root).unwrap();
        let raw = root.join("raw");
        let set = settings();
        let progress = Progress::new(true);
        record(&ALL[0], &Request { set: &set, profile: "small", into: &raw, progress: &progress }).unwrap();
        let specimen = Specimen::open(&raw.join(&*ALL[0].name)).unwrap();
        Self { root, specimen }
    }
}

impl Drop for Recorded {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.root);
    }
}

fn settings() -> Settings {
    let mut set = Settings::built_in();
    let profile = Profile {
        specimens: vec![ALL[0].name.to_string()],
        resolution: Resolution { edge: 0.010, per_chamber: 1, per_rib: 1, hexahedra: None },
        levels: 4,
        step: 1.0 / 60.0,
        rest: 0.1,
        hold: 0.25,
        pause: 0.15,
        cycles: 2,
        repeats: 1,
        brief: false,
        poses: 3,
    };
    let own = set.specimen.get_mut(&*ALL[0].name).unwrap();
    (own.levels, own.levels_in_water) = (vec![1500.0, 3000.0], vec![1500.0]);
    let flap = |frequency| FlappingTrial {
        medium: Medium::Air,
        pressure: 2000.0,
        frequency,
        validate: true,
        split: None,
        brief: true,
    };
    own.flaps = vec![flap(2.0), flap(4.0)];
    set.profile.insert("small".to_owned(), profile);
    set
}
