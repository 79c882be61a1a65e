//! The program `rig` writes its recordings as a workflow for Snakemake: a job for each part.
#![allow(clippy::unwrap_used)] // a panic fails the test

use std::fs;
use std::process::Command;

#[test]
fn recordings_of_a_population_are_exported_with_their_commands_and_trials() {
    let root = std::env::temp_dir().join(format!("rig-export-{}", std::process::id()));
    let export = ["export", "snakemake", "--draw", "2", "--seed", "3", "--profile", "population", "--root"];
    let done = Command::new(env!("CARGO_BIN_EXE_rig")).args(export).arg(&root).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let folder = root.join("target/population/workflow/recording");
    assert_eq!(String::from_utf8(done.stdout).unwrap().trim(), folder.display().to_string());
    let places: serde_json::Value = serde_json::from_slice(&fs::read(folder.join("recordings.json")).unwrap()).unwrap();
    assert_eq!((&places["into"], &places["project"]), (&"target/population/data/raw".into(), &"../../../..".into()));
    let recordings = &places["recordings"];
    let second = &recordings["tail_002"];
    let command = ["draw", "2", "--only", "2", "--seed", "3", "--profile", "population"];
    assert_eq!(second["command"], serde_json::json!(command));
    assert!(second["trials"].as_array().unwrap().iter().any(|trial| trial == "static_left"));
    assert!(second["stamp"] != recordings["tail_001"]["stamp"], "each is made again when its own settings change");
    let snakefile = fs::read_to_string(folder.join("Snakefile")).unwrap();
    for line in [
        "    output: touch(\".made/{specimen}/{trial}\")",
        "    shell: RIG + \" --part {wildcards.trial}\"",
        "    output: touch(\".made/{specimen}/recording\")",
    ] {
        assert!(snakefile.contains(line), "{line} is not in\n{snakefile}");
    }
    // places and names are read from JSON
    assert!(!snakefile.contains("tail_001") && !snakefile.contains(root.to_str().unwrap()), "{snakefile}");
    assert!(["local", "slurm"].iter().all(|name| folder.join(format!("profiles/{name}/config.v8+.yaml")).is_file()));
    fs::remove_dir_all(&root).unwrap();
}
