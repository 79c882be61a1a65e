//! Folders and truths: what lies under `data/raw` is found by name, and a truth is read back as it was written.
#![allow(clippy::unwrap_used)] // a test may fail where it stands

use std::path::PathBuf;

use lab::truth::{self, TrueTrack, Truth};
use lab::{Specimen, folder};

/// A folder of its own for one test, gone afterwards.
struct World(PathBuf);

impl World {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("lab_{name}_{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn put(&self, file: &str, text: &str) -> PathBuf {
        let path = self.0.join(file);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, text).unwrap();
        path
    }
}

impl Drop for World {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.0).unwrap();
    }
}

const TRUTH: &str = r#"
origin = "virtual bench"
specimen = "pike"
seed = 7
body = { youngs_modulus = 2e5, poissons_ratio = 0.485, density = 1070.0 }
spine = { youngs_modulus = 3e9, poissons_ratio = 0.37, density = 1410.0 }
lens = { fx = 980.0, fy = 982.0, cx = 640.0, cy = 360.0, k1 = -0.1, k2 = 0.02, p1 = 1e-4, p2 = 0.0, k3 = 0.0 }
pose = { rotation = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]], translation = [0.0, 0.0, 0.3] }
trial = [{ id = "flap", tracks = "truth/flap.csv", clock_offset = 1.5, clock_scale = 1.00002, led_on = 0.5 }]
"#;

fn track(marker: &str) -> TrueTrack {
    TrueTrack {
        marker: marker.to_owned(),
        time: vec![0.0, 0.5],
        pixel: vec![[1.0, 2.0], [1.25, 2.5]],
        at: vec![[0.05, 0.0, 0.015], [0.05, 0.001, 0.015]],
    }
}

#[test]
fn a_truth_that_is_written_is_read_back_the_same() {
    let world = World::new("truth");
    let first: Truth = truth::read(&world.put("given.toml", TRUTH)).unwrap();
    let again = truth::read(&world.put("written.toml", &truth::write(&first))).unwrap();
    assert_eq!(first, again);
}

#[test]
fn true_tracks_that_are_written_are_read_back_the_same() {
    let world = World::new("tracks");
    let tracks = vec![track("m1"), track("m2")];
    let path = world.put("truth/flap.csv", &truth::write_tracks(&tracks, "virtual bench"));
    assert_eq!(truth::read_tracks(&path).unwrap(), tracks);
}

#[test]
fn only_folders_with_a_card_are_specimens_and_they_come_by_name() {
    let world = World::new("list");
    world.put("pike/specimen.toml", "");
    world.put("bass/specimen.toml", "");
    world.put("notes/readme.txt", "");
    world.put(".half/specimen.toml", "");
    assert_eq!(folder::list(&world.0).unwrap(), [world.0.join("bass"), world.0.join("pike")]);
}

#[test]
fn a_folder_without_a_card_is_refused_with_the_name_of_the_card() {
    let world = World::new("bare");
    let said = Specimen::open(&world.0).unwrap_err().to_string();
    assert!(said.contains("specimen.toml") && said.contains("do:"), "{said}");
}
