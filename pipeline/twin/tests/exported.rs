//! The crate as it is exported: it builds by itself, and a loop in C ends where the same loop in Rust does.
#![allow(clippy::unwrap_used)] // tests

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use twin::Twin;
use twin::example::beam;

/// The exported crate in a folder of its own, with the beam's file.
fn exported() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("exported_twin");
    for (path, content) in twin::package::files() {
        fs::create_dir_all(folder.join(path).parent().unwrap()).unwrap();
        fs::write(folder.join(path), content).unwrap();
    }
    twin::file::write(&folder.join("tail.safetensors"), &beam(true)).unwrap();
    folder
}

/// Runs a program in `folder` and returns what it prints.
fn output_of(folder: &Path, program: &str, arguments: &[&str]) -> String {
    let run = Command::new(program)
        .args(arguments)
        .current_dir(folder)
        .env_remove("RUSTFLAGS")
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .output()
        .unwrap();
    let printed = String::from_utf8_lossy(&run.stderr).into_owned();
    assert!(run.status.success(), "{program} {arguments:?}\n{printed}");
    String::from_utf8(run.stdout).unwrap() + &printed
}

/// The loop of `tip_control.c`.
fn controlled_tip(goal: f64) -> f64 {
    let twin = Twin::new(beam(true)).unwrap();
    let output = twin.output_number("tip_y").unwrap();
    let mut loaded = twin.start();
    let highest = twin.chambers()[0].range[1].min(2e4);
    for n in 1..=200 {
        twin.step(&mut loaded, &[highest * f64::from(n) / 200.0, 0.0], 0.005).unwrap();
    }
    let gain = highest / twin.output(&loaded, output);
    let (mut state, mut integral, mut last) = (twin.start(), 0.0, 0.0);
    for _ in 0..3000 {
        let tip = twin.output(&state, output);
        let error = goal - tip;
        let command = gain * (0.5 * error + 5.0 * (integral + error / 1000.0) - 0.04 * (tip - last) * 1000.0);
        last = tip;
        let pressure = command.clamp(-highest, highest);
        if pressure == command {
            integral += error / 1000.0;
        }
        twin.step(&mut state, &[pressure.max(0.0), (-pressure).max(0.0)], 1.0 / 1000.0).unwrap();
    }
    twin.output(&state, output)
}

#[test]
fn a_loop_in_c_ends_where_the_same_loop_in_rust_does() {
    let folder = exported();
    let library = folder.join("c");
    output_of(&library, env!("CARGO"), &["build", "--release"]);
    let linked =
        ["-O2", "-Wall", "-Werror", "tip_control.c", "-o", "tip_control", "-Ltarget/release", "-ltwin_c", "-lm"];
    output_of(&library, "cc", &[&linked[..], &["-Wl,-rpath,target/release"]].concat());
    let printed = output_of(&library, "./tip_control", &["../tail.safetensors", "tip_y", "0.004"]);
    let tip: f64 = printed.split_whitespace().nth(1).unwrap().parse().unwrap();
    assert!((tip - 4e-3).abs() < 1e-4, "the loop brings the tip to its goal: {printed}");
    assert!((tip - controlled_tip(4e-3)).abs() < 1e-9, "{printed}");
    let mut wrong_name = Command::new("./tip_control");
    let refused = wrong_name.args(["../tail.safetensors", "tip", "0.004"]).current_dir(&library).output().unwrap();
    assert!(String::from_utf8(refused.stderr).unwrap().contains("tip_x, tip_y") && !refused.status.success());
}

#[test]
fn a_build_without_its_instructions_says_which_flags_it_needs() {
    let folder = exported();
    // a caller's workspace has none of the flags; the environment's take the place of those in the folder
    let mut build = Command::new(env!("CARGO"));
    build.arg("check").current_dir(&folder).env("RUSTFLAGS", "-C target-cpu=x86-64");
    let printed = String::from_utf8(build.output().unwrap().stderr).unwrap();
    assert!(!cfg!(target_arch = "x86_64") || printed.contains("target-cpu=x86-64-v3"), "{printed}");
}
