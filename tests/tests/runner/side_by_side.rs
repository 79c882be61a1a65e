//! Several processes on one folder: single records from what lies in the store, none of them made twice, and any of them killed.
//!
//! The other processes are this very program, called again for one test that does nothing unless it is asked to.

use std::fs;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use workflow::runner::{Goal, RunSummary};

use crate::small::{BEGUN, Project, SETTINGS, summary};

/// Names the project of a further process.
const ASKED: &str = "A_STUDY_MADE_BY_SEVERAL_PROCESSES";
/// The records that it makes one by one, in this order; without them it runs the study.
const RECORDS: &str = "RECORDS_TO_MAKE_ONE_BY_ONE";
/// How many single processes are killed.
const KILLS: usize = 30;

#[test]
fn a_further_process_makes_the_study_or_single_records() {
    let Some(root) = std::env::var_os(ASKED) else { return };
    let project = std::mem::ManuallyDrop::new(Project(PathBuf::from(root)));
    let runner = project.runner(SETTINGS);
    match std::env::var(RECORDS) {
        Err(_) => assert!(study::run(&runner, &Goal::default(), false).unwrap().is_complete()),
        Ok(records) => records.split(' ').for_each(|name| {
            // until what it reads lies in the store
            while runner.make(&[name.into()]).is_err() {
                std::thread::sleep(Duration::from_millis(1));
            }
        }),
    }
}

fn further(project: &Project, records: Option<&str>) -> Child {
    let own = std::env::current_exe().unwrap();
    let mut command = Command::new(own);
    command.args(["--exact", "side_by_side::a_further_process_makes_the_study_or_single_records"]);
    command.env(ASKED, &project.0).env(BEGUN, begun(project)).stdout(Stdio::null()).stderr(Stdio::null());
    records.map(|records| command.env(RECORDS, records));
    command.spawn().unwrap()
}

fn begun(project: &Project) -> PathBuf {
    project.0.join("begun")
}

/// How often a stage was begun by further processes.
fn times_begun(project: &Project, stage: &str) -> usize {
    fs::read_to_string(begun(project)).unwrap_or_default().lines().filter(|line| *line == stage).count()
}

fn make(project: &Project, names: &[&str]) -> diagnostics::Result<RunSummary> {
    let names: Vec<String> = names.iter().map(|name| (*name).into()).collect();
    project.runner(SETTINGS).make(&names)
}

/// What lies in the folders of the records beside them.
fn left(project: &Project) -> Vec<String> {
    let folder = |stage: &str| project.record(stage).parent().unwrap().to_path_buf();
    let names = |stage| fs::read_dir(folder(stage)).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
    let mut left: Vec<String> = ["letters", "halved", "alone"].into_iter().flat_map(names).collect();
    left.retain(|name| name != "record" && name != "record.hashes.json");
    left.extend(fs::read_dir(project.0.join("data/processed/.holders")).unwrap().map(|e| format!("{:?}", e.unwrap())));
    left
}

#[test]
fn exactly_the_named_records_are_made_and_a_second_time_kept() {
    let project = Project::new("exactly");
    assert_eq!(make(&project, &["letters/fish"]).unwrap(), summary(1, 0, 0, 0));
    assert!(project.record("letters").exists() && !project.record("alone").exists());
    assert!(!project.0.join("data/processed/metrics.json").exists());
    assert_eq!(make(&project, &["halved/fish", "letters/fish"]).unwrap(), summary(1, 1, 0, 0));
    assert_eq!(project.run(SETTINGS), summary(1, 2, 0, 0));
    assert_eq!(left(&project), [""; 0]);
}

#[test]
fn a_missing_or_stale_input_is_named_with_the_command_that_makes_it() {
    let project = Project::new("input");
    let missing = make(&project, &["halved/fish"]).unwrap_err();
    assert!(missing.what.contains("`halved/fish` cannot be made"), "{missing}");
    assert!(missing.why.contains("`letters/fish` is stale: it was never made"), "{missing}");
    assert_eq!(missing.action, "study make letters/fish");
    project.run(SETTINGS);
    fs::write(project.0.join("data/raw/fish/cad/body.stl"), "many more bytes than before").unwrap();
    let stale = make(&project, &["halved/fish"]).unwrap_err();
    assert!(stale.why.contains("recording `fish/cad/body.stl` is of other content"), "{stale}");
    assert_eq!(make(&project, &["letters/fish", "halved/fish"]).unwrap(), summary(2, 0, 0, 0));
}

#[test]
fn an_unknown_record_is_refused_with_those_of_its_stage() {
    let project = Project::new("unknown");
    let unknown = make(&project, &["letters/bird"]).unwrap_err();
    assert!(unknown.why.contains("letters/fish") && unknown.action.contains("study plan"), "{unknown}");
    assert!(make(&project, &["feathers/bird"]).unwrap_err().why.contains("`feathers`"));
}

#[test]
fn processes_side_by_side_make_each_record_once() {
    let project = Project::new("once");
    let one_by_one = Some("letters/fish halved/fish alone/fish");
    let mut children = [None, one_by_one, None, one_by_one].map(|records| further(&project, records));
    assert!(children.iter_mut().all(|child| child.wait().unwrap().success()));
    for stage in ["letters", "halved", "alone"] {
        assert_eq!(times_begun(&project, stage), 1, "{stage}");
    }
    assert_eq!(project.run(SETTINGS), summary(0, 3, 0, 0));
    assert_eq!(left(&project), [""; 0]);
}

#[test]
fn of_processes_side_by_side_any_may_be_killed_and_no_finished_record_is_made_again() {
    let mut caught = 0;
    for kill in 0..KILLS {
        let project = Project::new(&format!("killed-{kill}"));
        let mut killed = further(&project, [None, Some("letters/fish halved/fish alone/fish")][kill % 2]);
        // steps of a golden section spread the moments evenly over the life of the process
        let moment = (kill as f64 * 0.618_034).fract();
        std::thread::sleep(Duration::from_micros(2_000 + (110_000.0 * moment) as u64));
        let others = [Some("alone/fish letters/fish halved/fish"), None].map(|records| further(&project, records));
        std::thread::sleep(Duration::from_micros((10_000.0 * moment) as u64));
        killed.kill().unwrap();
        killed.wait().unwrap();
        assert!(others.into_iter().all(|mut child| child.wait().unwrap().success()));
        let begun = ["letters", "halved", "alone"].map(|stage| times_begun(&project, stage));
        // A record is begun again only where the kill met it: by a run of two workers, two at most.
        assert!(begun.iter().all(|times| (1..=2).contains(times)), "{begun:?}");
        caught += begun.iter().sum::<usize>() - 3;
        assert_eq!(project.run(SETTINGS), summary(0, 3, 0, 0));
        assert_eq!(left(&project), [""; 0]);
    }
    assert!(caught > 0, "no kill met a record that was being made");
}
