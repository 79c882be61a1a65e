//! `study` while its reader goes away or its disk is full.

#![allow(clippy::unwrap_used)]
#![cfg(unix)]

use std::fs::File;
use std::process::{Command, Output, Stdio};

fn study(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_study"));
    command.args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn message(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

#[test]
fn a_reader_that_has_seen_enough_is_no_error() {
    let mut child = study(&["list"]).spawn().unwrap();
    drop(child.stdout.take());
    let ended = child.wait_with_output().unwrap();
    assert_eq!((ended.status.code(), message(&ended)), (Some(0), String::new()));
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_behind_the_output_is_reported_once() {
    let full = || File::options().write(true).open("/dev/full").unwrap();
    let ended = study(&["list"]).stdout(full()).output().unwrap();
    assert_eq!(ended.status.code(), Some(1));
    assert_eq!(message(&ended).matches("error:").count(), 1, "{}", message(&ended));
    assert!(message(&ended).contains("the output is not whole"), "{}", message(&ended));
    // Nothing is left that could report it, and nothing panics (101).
    let ended = study(&["why", "nothing"]).stdout(full()).stderr(full()).status().unwrap();
    assert_eq!(ended.code(), Some(1));
}

#[test]
fn a_count_that_is_absurd_is_refused_as_usage() {
    let absurd = [
        vec!["plan", "--jobs", "18446744073709551615"],
        vec!["plan", "--jobs", "0"],
        vec!["plan", "--min-free-memory", "nan"],
        vec!["track", "film.mp4", "--at", "1,inf"],
        vec!["track", "film.mp4", "--find", "1", "--radius", "1e300"],
    ];
    for arguments in absurd {
        let ended = study(&arguments).output().unwrap();
        assert_eq!(ended.status.code(), Some(2), "{arguments:?}: {}", message(&ended));
    }
}

#[test]
fn a_specimen_is_not_named_like_an_option() {
    let ended = study(&["init", "--", "-x"]).output().unwrap();
    assert!(
        ended.status.code() == Some(1) && message(&ended).contains("`-x` is not a valid name"),
        "{}",
        message(&ended)
    );
}
