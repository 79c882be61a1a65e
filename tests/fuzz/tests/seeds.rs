//! Every seed through its target: whole inputs are read, broken ones refused, and none panics or takes long.

#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};

use fuzz::TARGETS;

fn seeds(name: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("seeds").join(name);
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

#[test]
fn every_target_survives_its_seeds() {
    for target in TARGETS {
        let files = seeds(target.name);
        assert!(!files.is_empty(), "`{}` has no seeds", target.name);
        for file in files {
            println!("{}", file.display());
            (target.run)(&std::fs::read(&file).unwrap());
        }
    }
}

#[test]
fn seeds_are_small_enough_to_be_kept() {
    let large = |file: &PathBuf| std::fs::metadata(file).unwrap().len() > 32 << 10;
    let found: Vec<PathBuf> = TARGETS.iter().flat_map(|target| seeds(target.name)).filter(large).collect();
    assert!(found.is_empty(), "{found:?}");
}

#[test]
fn every_seed_cut_anywhere_is_read_or_refused() {
    for target in TARGETS.iter().filter(|target| target.name != "mp4") {
        for file in seeds(target.name) {
            let bytes = std::fs::read(&file).unwrap();
            for part in 1..8 {
                (target.run)(&bytes[..bytes.len() * part / 8]);
            }
        }
    }
}
