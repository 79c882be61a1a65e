//! The study as a workflow for Snakemake, and what records of it cost. `just snakemake` runs such a workflow.

use std::fs;

use workflow::runner::Goal;
use workflow::snakemake::{Export, Workflow, export, update};

use crate::shown::bytes;
use crate::small::{Project, SETTINGS, summary};

/// The Snakefile and the table of records of a project's export.
fn exported(project: &Project, goal: &[&str]) -> (String, serde_json::Value) {
    let goal = Goal { entries: goal.iter().map(|name| (*name).into()).collect(), group: None };
    let program = project.0.join("target/release/study");
    let Workflow { folder, .. } = export(&project.runner(SETTINGS), &Export { folder: None, program, goal }).unwrap();
    assert_eq!(folder, project.0.join("workflow"));
    let text = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    assert!(text("profiles/slurm/config.v8+.yaml").contains("\nexecutor: slurm\n"));
    assert!(text("profiles/local/config.v8+.yaml").contains("\ncores: all\n"));
    (text("Snakefile"), serde_json::from_str(&text("records.json")).unwrap())
}

#[test]
fn each_stage_is_a_rule_that_makes_one_record_of_a_specimen() {
    let project = Project::new("rules");
    let (snakefile, records) = exported(&project, &[]);
    for stage in ["letters", "halved", "alone"] {
        let output = format!("output: touch(\"data/processed/.made/{stage}/{{subject}}.done\")");
        assert!(snakefile.contains(&format!("\nrule {stage}:\n")) && snakefile.contains(&output), "{snakefile}");
    }
    assert!(snakefile.contains("\nrule all:\n    input: mark(\"published\")\n"), "{snakefile}");
    let root = project.0.to_str().unwrap();
    assert!(!snakefile.contains(root) && !snakefile.contains("fish"), "names and places are in JSON: {snakefile}");
    assert_eq!(records["letters/fish"], serde_json::json!({ "rule": "letters", "reads": [] }));
    assert_eq!(records["halved/fish"]["reads"], serde_json::json!(["letters/fish"]));
}

#[test]
fn a_part_is_exported_with_what_it_reads_and_nothing_else() {
    let project = Project::new("part");
    let (snakefile, records) = exported(&project, &["halved"]);
    assert!(snakefile.contains("rule letters:") && !snakefile.contains("rule alone:"), "{snakefile}");
    assert_eq!(records.as_object().unwrap().len(), 2);
}

#[test]
fn marks_are_those_of_the_records_that_the_plan_keeps() {
    let project = Project::new("marks");
    exported(&project, &[]);
    let mark = |name: &str| project.0.join("data/processed/.made").join(name);
    let marked = |settings: &str| {
        update(&project.runner(settings), &project.0.join("workflow"), &Goal::default()).unwrap();
        ["letters/fish.done", "halved/fish.done", "alone/fish.done", "published.done"].map(|name| mark(name).exists())
    };
    assert_eq!(marked(SETTINGS), [false; 4]);
    project.run(SETTINGS);
    assert_eq!(marked(SETTINGS), [true, true, true, false]);
    fs::write(mark("published.done"), "").unwrap();
    assert_eq!(marked(&format!("# a comment\n{SETTINGS}")), [true; 4]);
    let changed = SETTINGS.replace("[halved]\nstep = 1", "[halved]\nstep = 2");
    assert_eq!(marked(&changed), [true, false, true, false], "one setting");
    fs::write(project.0.join("data/raw/fish/cad/body.stl"), "other bytes than before").unwrap();
    assert_eq!(marked(SETTINGS), [false, false, true, false], "a recording, and what is made from it");
    fs::remove_file(project.0.join("data/raw/fish/cad/body.stl")).unwrap();
    assert_eq!(marked(SETTINGS), [false, false, true, false], "a recording that is missing");
}

#[test]
fn an_edited_profile_is_kept_and_an_edited_workflow_is_not_overwritten() {
    let project = Project::new("edited");
    exported(&project, &[]);
    let edit = |name: &str| fs::write(project.0.join("workflow").join(name), "mine").unwrap();
    let again = || {
        let (program, goal) = (project.0.join("study"), Goal::default());
        export(&project.runner(SETTINGS), &Export { folder: None, program, goal })
    };
    edit("profiles/slurm/config.v8+.yaml");
    assert_eq!(again().unwrap().kept, [project.0.join("workflow/profiles/slurm/config.v8+.yaml")]);
    edit("Snakefile");
    assert!(again().unwrap_err().to_string().contains("it was edited"));
    assert_eq!(fs::read_to_string(project.0.join("workflow/Snakefile")).unwrap(), "mine");
}

#[test]
fn resources_are_defaults_until_a_record_was_measured() {
    let project = Project::new("resources");
    let lines = |text: &str| text.lines().filter(|line| line.contains("mem_mb")).map(str::to_owned).collect::<Vec<_>>();
    let before = exported(&project, &[]).0;
    assert!(lines(&before).iter().all(|line| line.contains(": 2048 * attempt") && line.contains(": 60 * attempt")));
    project.runner(SETTINGS).make(&["letters/fish".into()]).unwrap();
    let after = lines(&exported(&project, &[]).0);
    assert!(after[0].contains("runtime=lambda wildcards, attempt: 1 * attempt"), "{after:?}");
    assert!(cfg!(not(target_os = "linux")) || !after[0].contains("2048"), "{after:?}");
    assert!(after[1].contains("2048"), "{after:?}");
}

#[test]
fn one_two_and_four_workers_make_the_same_bytes() {
    let made = [1, 2, 4].map(|jobs| {
        let project = Project::new(&format!("workers-{jobs}"));
        let mut runner = project.runner(SETTINGS);
        runner.options.jobs = Some(jobs);
        assert_eq!(study::run(&runner, &Goal::default(), false).unwrap(), summary(3, 0, 0, 0));
        let record = |stage| bytes(&project.record(stage)).into_iter();
        // the manifest holds durations beside the content
        let own = ["letters", "halved", "alone"]
            .into_iter()
            .flat_map(record)
            .filter(|(path, _)| !path.ends_with("record.json"));
        own.map(|(path, bytes)| (path.strip_prefix(&project.0).unwrap().to_owned(), bytes)).collect::<Vec<_>>()
    });
    assert_eq!(made[0].len(), 3);
    assert!(made[0] == made[1] && made[1] == made[2]);
}

#[test]
fn a_run_that_may_use_no_memory_makes_one_record_after_the_other() {
    let project = Project::new("memory");
    let mut runner = project.runner(SETTINGS);
    (runner.options.memory, runner.options.jobs) = (Some(0.0), None);
    assert_eq!(study::run(&runner, &Goal::default(), false).unwrap(), summary(3, 0, 0, 0));
}

#[test]
fn a_plan_for_a_program_has_each_record_with_what_it_reads() {
    let project = Project::new("plan_json");
    project.run(SETTINGS);
    let changed = SETTINGS.replace("[halved]\nstep = 1", "[halved]\nstep = 2");
    let plan = project.runner(&changed).plan_json(&Goal::default()).unwrap();
    let plan: Vec<serde_json::Value> = serde_json::from_str(&plan).unwrap();
    let of = |record: &str| plan.iter().find(|planned| planned["record"] == record).unwrap();
    assert_eq!((plan.len(), &of("letters/fish")["kept"]), (3, &serde_json::json!(true)));
    let halved = of("halved/fish");
    assert_eq!(halved["reads"], serde_json::json!(["letters/fish"]));
    assert!(halved["kept"] == false && halved["why"].as_str().unwrap().contains("was 1 and is 2"), "{halved}");
}
