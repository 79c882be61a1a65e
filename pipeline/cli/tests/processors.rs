//! The programs on other processors than the one at hand, emulated by `qemu-x86_64`: where there is none, the tests say so.

#![allow(clippy::unwrap_used)] // tests
#![cfg(target_arch = "x86_64")]

use std::path::{Path, PathBuf};
use std::process::Command;

/// Processors that have AVX2 and FMA, but no AVX-512.
const NEW_ENOUGH: [&str; 2] = ["Haswell", "EPYC"];
/// Without AVX, and with AVX alone.
const TOO_OLD: [&str; 3] = ["Nehalem", "SandyBridge", "Opteron_G4"];

/// The files that `study simulate` writes for the beam, by name, run by `emulator`.
fn beam(name: &str, emulator: &[&str]) -> Vec<(PathBuf, Vec<u8>)> {
    let out = Path::new(env!("CARGO_TARGET_TMPDIR")).join("processors").join(name);
    let _ = std::fs::remove_dir_all(&out);
    let case = Path::new(env!("CARGO_MANIFEST_DIR")).join("../simulate/examples/cantilever.toml");
    let command: Vec<&str> = emulator.iter().copied().chain([env!("CARGO_BIN_EXE_study"), "simulate"]).collect();
    let done = Command::new(command[0]).args(&command[1..]).arg(&case).arg("--out").arg(&out).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let mut files: Vec<PathBuf> = std::fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files.iter().map(|file| (PathBuf::from(file.file_name().unwrap()), std::fs::read(file).unwrap())).collect()
}

fn qemu_is_here() -> bool {
    let here = Command::new("qemu-x86_64").arg("--version").output().is_ok_and(|done| done.status.success());
    if !here {
        println!("no qemu-x86_64 is at hand: other processors are not tested");
    }
    here
}

#[test]
fn every_processor_that_runs_the_program_gives_the_same_bytes() {
    if qemu_is_here() {
        let here = beam("here", &[]);
        for processor in NEW_ENOUGH {
            assert!(beam(processor, &["qemu-x86_64", "-cpu", processor]) == here, "{processor} gives other bytes");
        }
    }
}

#[test]
fn an_older_processor_is_told_in_one_diagnostic() {
    if !qemu_is_here() || !cfg!(target_feature = "avx2") {
        return;
    }
    for processor in TOO_OLD {
        let done = Command::new("qemu-x86_64").args(["-cpu", processor, env!("CARGO_BIN_EXE_study"), "plan"]).output();
        let (code, said) = done.map(|done| (done.status.code(), String::from_utf8(done.stderr).unwrap())).unwrap();
        assert_eq!(code, Some(1), "{processor}: {said}");
        let sentence = "error: this program cannot run on this processor";
        assert!(said.lines().any(|line| line == sentence) && !said.contains("panicked"), "{processor}: {said}");
    }
}
