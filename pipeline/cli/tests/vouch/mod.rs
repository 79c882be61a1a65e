//! Inputs that doctor and run must judge alike.
#![allow(clippy::unwrap_used)]

use std::process::{Command, Output};

use super::specimen::Project;

/// What becomes of an input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    Read,
    Refused,
}

/// A file of the specimen in another form.
pub struct Input {
    pub name: &'static str,
    pub file: &'static str,
    pub bytes: Vec<u8>,
    pub card: String,
    pub verdict: Verdict,
}

/// A command in the project, and all that it prints.
pub fn study(project: &Project, words: &[&str]) -> (Output, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_study")).args(words).arg("--root").arg(&project.0).output().unwrap();
    let text = format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    (output, text)
}

/// Puts each input into the specimen and asks for it the doctor and the stage that reads it.
pub fn check(project_name: &str, stage: &str, inputs: Vec<Input>) {
    let project = Project::new(project_name);
    for Input { name, file, bytes, card, verdict } in inputs {
        project.write("specimen.toml", &card);
        std::fs::write(project.path(file), bytes).unwrap();
        let (doctor, said) = study(&project, &["doctor", "fish"]);
        let is_well = doctor.status.code() == Some(0) && said.contains(" 0 to fix");
        let (run, told) = study(&project, &["run", stage, "--specimen", "fish"]);
        assert_eq!(is_well, verdict == Verdict::Read, "{name}: {said}");
        assert_eq!(run.status.code() == Some(0), is_well, "{name}: doctor {said}\nrun {told}");
        if verdict == Verdict::Refused {
            assert!(told.contains("why:") && told.contains("do:"), "{name}: {told}");
        }
    }
}
