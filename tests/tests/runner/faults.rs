//! What a run must survive: being killed at any moment, a bit that flips, a disk that is full.
//!
//! The runs that are killed or starved are this very program, called again for one test that does nothing unless it is asked to.

use std::fs;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use workflow::runner::Goal;

use crate::small::{Project, SETTINGS, summary};

/// Names the project in which a second program is to run.
const ASKED: &str = "A_STUDY_TO_RUN_AGAIN_AND_AGAIN";
/// Holds the settings of every one of its runs; without it they alternate.
const ITS_SETTINGS: &str = "SETTINGS_OF_THE_STUDY_TO_RUN";
/// How often a run is killed.
const KILLS: u64 = 50;

/// Settings that make every record stale, and others that do.
fn turned(turn: usize) -> String {
    SETTINGS.replace("step = 1", &format!("step = {}", 1 + turn % 2))
}

#[test]
fn a_second_program_runs_the_study_until_it_is_killed() {
    let Some(root) = std::env::var_os(ASKED) else { return };
    let project = std::mem::ManuallyDrop::new(Project(PathBuf::from(root)));
    for turn in 1.. {
        let settings = std::env::var(ITS_SETTINGS).unwrap_or_else(|_| turned(turn));
        match study::run(&project.runner(&settings), &Goal::default(), false) {
            Ok(summary) if summary.failed == 0 => {}
            _ => std::process::exit(1),
        }
    }
}

/// This program, made to run the study again and again in `project`, after the words of a shell.
fn second(project: &Project, shell: &str) -> Child {
    command(project, shell).spawn().unwrap()
}

fn command(project: &Project, shell: &str) -> Command {
    let own = std::env::current_exe().unwrap();
    let words = format!("{shell} exec {:?} --exact faults::a_second_program_runs_the_study_until_it_is_killed", own);
    let mut command = Command::new("sh");
    command.args(["-c", &words]).env(ASKED, &project.0).stdout(Stdio::null()).stderr(Stdio::null());
    command
}

/// The exit code of a program that ends within a minute; none of one that hangs, which is killed.
fn code(child: &mut Child) -> Option<i32> {
    for _ in 0..6000 {
        if let Some(status) = child.try_wait().unwrap() {
            return status.code();
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    None
}

/// What a whole run of the study leaves, with no record but those of now.
fn it_ends_as_if_nothing_had_happened(project: &Project) {
    let after = project.run(SETTINGS);
    assert_eq!((after.failed, after.skipped), (0, 0));
    let counts = [("letters", "12"), ("halved", "6"), ("alone", "1")];
    for (stage, count) in counts {
        assert_eq!(fs::read_to_string(project.record(stage).join("count.json")).unwrap().trim(), count);
    }
    assert_eq!(project.run(SETTINGS), summary(0, 3, 0, 0));
}

#[test]
fn fifty_runs_killed_at_any_moment_leave_nothing_stale_and_nothing_half_written() {
    let project = Project::new("fifty");
    project.run(SETTINGS);
    for kill in 0..KILLS {
        let mut child = second(&project, "");
        // steps of a golden section spread the moments evenly over the life of a short run
        let moment = (kill as f64 * 0.618_034).fract();
        std::thread::sleep(Duration::from_micros(5_000 + (40_000.0 * moment) as u64));
        child.kill().unwrap();
        child.wait().unwrap();
        it_ends_as_if_nothing_had_happened(&project);
    }
}

#[test]
fn a_bit_that_flips_in_any_file_of_a_record_is_found_and_mended() {
    let project = Project::new("flip");
    project.run(SETTINGS);
    let folder = project.record("letters");
    for entry in fs::read_dir(&folder).unwrap() {
        let file = entry.unwrap().path();
        let mut bytes = fs::read(&file).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 4;
        fs::write(&file, bytes).unwrap();
        it_ends_as_if_nothing_had_happened(&project);
    }
}

#[test]
fn a_disk_that_takes_no_more_ends_a_run_and_harms_no_record() {
    let project = Project::new("full");
    project.run(SETTINGS);
    let ended = second(&project, "trap '' XFSZ; ulimit -f 0;").wait().unwrap();
    assert_eq!(ended.code(), Some(1), "no file can grow, so that the run has to say so");
    assert_eq!(project.run(SETTINGS), summary(0, 3, 0, 0));
    it_ends_as_if_nothing_had_happened(&project);
}

#[test]
fn a_stage_that_fails_or_panics_or_makes_what_cannot_be_read_while_nobody_listens_ends_the_run_and_releases_the_lock() {
    let project = Project::new("unread");
    for step in ["13", "14", "15"] {
        let settings = SETTINGS.replace("[halved]\nstep = 1", &format!("[halved]\nstep = {step}"));
        let mut child = command(&project, "").env(ITS_SETTINGS, settings).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stderr.take());
        assert_eq!(code(&mut child), Some(1));
        it_ends_as_if_nothing_had_happened(&project);
    }
}

#[test]
fn a_metric_that_is_altered_in_a_record_is_found_and_made_again() {
    let project = Project::new("altered");
    project.run(SETTINGS);
    let file = project.record("letters").join("record.json");
    let text = fs::read_to_string(&file).unwrap();
    let altered = text.replace("\"seconds\": ", "\"seconds\": 1");
    assert_ne!(altered, text);
    fs::write(&file, altered).unwrap();
    assert_eq!(project.run(SETTINGS), summary(1, 2, 0, 0));
}
