//! The runner, held to its word with a study of three small stages: what is fresh is kept, what is stale is made and said why,
//! what is damaged is made again, and a kill loses nothing.

#![allow(clippy::unwrap_used)]

mod exported;
mod faults;
mod shown;
mod side_by_side;
mod small;

use std::fs;

use small::{Project, SETTINGS, summary};
use workflow::runner::Goal;

#[test]
fn a_second_run_makes_nothing_again() {
    let project = Project::new("second");
    assert_eq!(project.run(SETTINGS), summary(3, 0, 0, 0));
    assert_eq!(project.run(SETTINGS), summary(0, 3, 0, 0));
}

#[test]
fn a_touched_file_makes_nothing_stale() {
    let project = Project::new("touched");
    project.run(SETTINGS);
    let body = project.0.join("data/raw/fish/cad/body.stl");
    let later = std::time::SystemTime::now() + std::time::Duration::from_secs(3600);
    fs::File::options().append(true).open(&body).unwrap().set_modified(later).unwrap();
    assert_eq!(project.run(SETTINGS), summary(0, 3, 0, 0));
}

#[test]
fn a_changed_setting_makes_just_what_depends_on_it_stale_and_the_plan_says_why() {
    let project = Project::new("setting");
    project.run(SETTINGS);
    let changed = SETTINGS.replace("[halved]\nstep = 1", "[halved]\nstep = 2");
    let plan = project.plan(&changed);
    assert!(plan.contains("setting `step` was 1 and is 2"), "{plan}");
    assert!(plan.contains("1 of 3 records would be made"), "{plan}");
    assert_eq!(project.run(&changed), summary(1, 2, 0, 0));
}

#[test]
fn a_changed_recording_makes_what_reads_it_stale_and_its_readers_wait() {
    let project = Project::new("recording");
    project.run(SETTINGS);
    fs::write(project.0.join("data/raw/fish/cad/body.stl"), "many more bytes than before").unwrap();
    let plan = project.plan(SETTINGS);
    assert!(plan.contains("recording `fish/cad/body.stl` is of other content"), "{plan}");
    assert!(plan.contains("it reads letters/fish, which will be made"), "{plan}");
    assert_eq!(project.run(SETTINGS), summary(2, 1, 0, 0));
}

#[test]
fn a_stage_made_again_to_the_same_content_leaves_its_readers_fresh() {
    let project = Project::new("cutoff");
    project.run(SETTINGS);
    fs::write(project.0.join("data/raw/fish/cad/body.stl"), "12 other byt").unwrap();
    assert_eq!(project.run(SETTINGS), summary(1, 2, 0, 0));
}

#[test]
fn a_changed_card_entry_is_named_and_another_one_changes_nothing() {
    let project = Project::new("card");
    project.run(SETTINGS);
    let card = project.0.join("data/raw/fish/specimen.toml");
    fs::write(&card, tests::CARD.replace("density = 1070.0", "density = 1080.0")).unwrap();
    assert!(project.plan(SETTINGS).contains("0 of 3 records"));
    fs::write(&card, tests::CARD.replace("length = 0.1", "length = 0.2")).unwrap();
    let plan = project.plan(SETTINGS);
    assert!(plan.contains("card entry `length` was 0.1 and is 0.2"), "{plan}");
}

#[test]
fn a_plan_writes_nothing() {
    let project = Project::new("plan");
    project.plan(SETTINGS);
    assert!(!project.0.join("data/processed").exists());
}

#[test]
fn a_damaged_record_is_made_again_and_never_read() {
    let project = Project::new("damaged");
    project.run(SETTINGS);
    fs::write(project.record("letters").join("count.json"), "99\n").unwrap();
    assert!(project.plan(SETTINGS).contains("the bytes of its count.json are not those that were written"));
    assert_eq!(project.run(SETTINGS), summary(1, 2, 0, 0));
    assert_eq!(fs::read_to_string(project.record("letters").join("count.json")).unwrap(), "12\n");
}

#[test]
fn what_a_killed_run_left_half_written_is_ignored() {
    let project = Project::new("killed");
    project.run(SETTINGS);
    fs::remove_dir_all(project.record("halved")).unwrap();
    let unfinished = project.record("halved").with_file_name("record.unfinished");
    fs::create_dir_all(&unfinished).unwrap();
    fs::write(unfinished.join("count.json"), "4").unwrap();
    assert_eq!(project.run(SETTINGS), summary(1, 2, 0, 0));
    assert!(!unfinished.exists());
}

#[test]
fn a_failing_stage_stops_only_those_that_need_it_and_keeps_what_was_made() {
    let project = Project::new("failing");
    let bad = SETTINGS.replace("[halved]\nstep = 1", "[halved]\nstep = 13");
    assert_eq!(project.run(&bad), summary(2, 0, 1, 0));
    assert_eq!(project.run(SETTINGS), summary(1, 2, 0, 0));
}

#[test]
fn a_stage_that_breaks_down_is_a_fault_and_not_the_end() {
    let project = Project::new("panic");
    let bad = SETTINGS.replace("[halved]\nstep = 1", "[halved]\nstep = 14");
    assert_eq!(project.run(&bad), summary(2, 0, 1, 0));
}

#[test]
fn a_missing_recording_fails_its_stage_and_skips_its_readers() {
    let project = Project::new("missing");
    fs::remove_file(project.0.join("data/raw/fish/cad/body.stl")).unwrap();
    assert_eq!(project.run(SETTINGS), summary(1, 0, 1, 1));
}

#[test]
fn fresh_makes_the_named_stage_again_and_only_that() {
    let project = Project::new("fresh");
    project.run(SETTINGS);
    let goal = Goal { entries: vec!["halved".into()], group: None };
    let made = |stage| fs::metadata(project.record(stage).join("record.json")).unwrap().modified().unwrap();
    let before = ["letters", "halved", "alone"].map(made);
    assert_eq!(study::run(&project.runner(SETTINGS), &goal, true).unwrap(), summary(1, 1, 0, 0));
    let after = ["letters", "halved", "alone"].map(made);
    assert!(after[0] == before[0] && after[1] > before[1] && after[2] == before[2], "{before:?} {after:?}");
}

#[test]
fn an_unknown_goal_is_refused_with_what_there_is() {
    let project = Project::new("goal");
    let goal = Goal { entries: vec!["halfed".into()], group: None };
    let diagnostic = project.runner(SETTINGS).plan(&goal).unwrap_err();
    assert!(diagnostic.action.contains("letters, halved, alone"), "{diagnostic}");
}

#[test]
fn without_leave_to_keep_going_a_fault_ends_the_run_and_what_was_made_is_kept() {
    let project = Project::new("stopping");
    let mut runner = project.runner(&SETTINGS.replace("[letters]\nstep = 1", "[letters]\nstep = 0"));
    (runner.options.keep_going, runner.options.jobs) = (false, Some(1));
    assert_eq!(study::run(&runner, &Goal::default(), false).unwrap(), summary(0, 0, 1, 2));
    assert_eq!(project.run(SETTINGS), summary(3, 0, 0, 0));
}

#[test]
fn a_machine_without_room_makes_one_record_after_the_other() {
    let project = Project::new("room");
    let mut runner = project.runner(SETTINGS);
    runner.options.min_free_memory = f64::INFINITY;
    assert_eq!(study::run(&runner, &Goal::default(), false).unwrap(), summary(3, 0, 0, 0));
}

#[test]
fn a_changed_comment_makes_nothing_stale() {
    let project = Project::new("comment");
    project.run(SETTINGS);
    let card = project.0.join("data/raw/fish/specimen.toml");
    fs::write(&card, format!("# said otherwise\n{}", tests::CARD)).unwrap();
    assert_eq!(project.run(&format!("# said otherwise\n{SETTINGS}")), summary(0, 3, 0, 0));
}

#[test]
fn a_file_of_the_same_length_with_other_bytes_is_seen_even_when_its_date_is_set_back() {
    let project = Project::new("included");
    project.run(SETTINGS);
    let body = project.0.join("data/raw/fish/cad/body.stl");
    let date = fs::metadata(&body).unwrap().modified().unwrap();
    fs::write(&body, "12 other byt").unwrap();
    fs::File::options().append(true).open(&body).unwrap().set_modified(date).unwrap();
    assert_eq!(project.run(SETTINGS), summary(1, 2, 0, 0));
}

#[test]
fn a_renamed_product_is_made_again_under_its_name() {
    let project = Project::new("renamed");
    project.run(SETTINGS);
    let record = project.record("halved");
    fs::rename(&record, record.with_file_name("elsewhere")).unwrap();
    assert_eq!(project.run(SETTINGS), summary(1, 2, 0, 0));
    assert!(record.join("count.json").exists());
}

#[test]
fn looking_at_a_study_changes_nothing_in_it() {
    let project = Project::new("looking");
    project.run(SETTINGS);
    let before = shown::bytes(&project.0);
    project.plan(SETTINGS);
    project.runner(SETTINGS).tree(&Goal::default()).unwrap();
    project.runner(SETTINGS).why("halved").unwrap();
    assert!(before == shown::bytes(&project.0));
}
