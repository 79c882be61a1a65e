//! `study make`, `study export` and `study check --junit` as programs, in a project without recordings.
#![allow(clippy::unwrap_used)]
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

struct Project(PathBuf);

impl Project {
    fn new(name: &str) -> Self {
        let root = std::env::temp_dir().join(format!("make-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&root);
        let fish = root.join("target/quick/data/raw/fish");
        fs::create_dir_all(&fish).unwrap();
        fs::create_dir_all(root.join("pipeline")).unwrap();
        let own = |file: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(file);
        fs::copy(own("study.toml"), root.join("study.toml")).unwrap();
        symlink(own("paper"), root.join("paper")).unwrap();
        fs::write(fish.join("specimen.toml"), include_str!("../../study/tests/card.toml")).unwrap();
        Self(root)
    }

    fn study(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_study"));
        command.args(arguments).args(["--profile", "quick", "--root"]).arg(&self.0).output().unwrap()
    }

    /// Fails with a message that holds these pieces.
    fn refuses(&self, arguments: &[&str], pieces: &[&str]) {
        let output = self.study(arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(pieces.iter().all(|piece| said.contains(piece)), "{pieces:?} is not in\n{said}");
    }
}

impl Drop for Project {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

#[test]
fn a_record_without_its_inputs_is_refused_with_the_command_that_makes_them() {
    let project = Project::new("inputs");
    let input = "its input `mesh/fish` cannot be made";
    project.refuses(&["make", "reduce/fish"], &["`reduce/fish` cannot be made from what lies in the store", input]);
    project.refuses(&["make", "mesh/bird"], &["there is no record `mesh/bird`", "mesh/fish"]);
    project.refuses(&["make", "mesh/fish"], &["mesh/fish: ", "why:", "do:"]);
    assert_eq!(project.study(&["make"]).status.code(), Some(2), "a record must be named");
}

#[test]
fn the_study_is_exported_with_a_rule_for_each_stage_and_with_profiles() {
    let project = Project::new("export");
    let output = project.study(&["export", "snakemake"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let folder = project.0.join("target/quick/workflow");
    let snakefile = fs::read_to_string(folder.join("Snakefile")).unwrap();
    let track = "output: touch(\"data/processed/.made/track/{subject}.done\")";
    assert!(snakefile.contains(track), "{snakefile}");
    let places = fs::read_to_string(folder.join("places.json")).unwrap();
    assert!(places.contains("\"profile\": \"quick\"") && places.contains("\"project\": \"../../..\""), "{places}");
    let mut rules: Vec<&str> = snakefile.lines().filter(|line| line.starts_with("rule ")).collect();
    let all = rules.len();
    rules.sort_unstable();
    rules.dedup();
    assert!(rules.len() == all && rules.contains(&"rule relaxation:") && rules.contains(&"rule figure_relaxation:"));
    assert!(["local", "slurm"].iter().all(|name| folder.join(format!("profiles/{name}/config.v8+.yaml")).is_file()));
}

#[test]
fn a_number_that_drifted_is_a_failed_case_of_the_report() {
    let project = Project::new("junit");
    let expected: toml::Table = fs::read_to_string(project.0.join("paper/expected.toml")).unwrap().parse().unwrap();
    let (id, _) = expected["quick"].as_table().unwrap().iter().next().unwrap();
    let metric = serde_json::json!([{ "id": id, "value": 1e9, "unit": "mm", "status": "" }]);
    let processed = project.0.join("target/quick/data/processed");
    fs::create_dir_all(&processed).unwrap();
    fs::write(processed.join("metrics.json"), metric.to_string()).unwrap();
    let report = project.0.join("report.xml");
    let output = project.study(&["check", "--junit", report.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(1), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(report.is_file(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = fs::read_to_string(report).unwrap();
    assert!(text.contains(&format!("name=\"{id}\"")) && text.contains("message=\"1000000000 mm; expected"), "{text}");
}

#[test]
fn a_tail_without_its_records_is_not_exported() {
    let project = Project::new("twin");
    project.refuses(&["export", "twin", "bird"], &["there is no specimen `bird`", "why:", "do:"]);
    project.refuses(&["export", "twin", "fish"], &["mesh/fish", "why:", "do:"]);
}
