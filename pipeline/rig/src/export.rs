//! The recordings as a workflow for Snakemake: a job for each part, and one that finishes a recording.
//!
//! A job is `rig record --part` or `rig draw --only NUMBER --part`, so that parts lie in the same partial folder and have the same bytes as
//! those of `rig record`, under the same locks. What Snakemake sees of a part is an empty file, since its checkpoint is gone when the
//! recording is finished.

use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, Result};
use serde_json::{Map, Value, json};
use workflow::snakemake::{path_to, write_workflow};

use crate::record::{CALIBRATION, Request, STATICS, parts};
use crate::specimen::{Draw, Specimen};
use crate::stamp;

/// A recording that is exported.
pub(crate) struct Recording {
    name: String,
    /// The arguments of the command that makes it.
    command: String,
    /// Changes with everything that it is made from.
    stamp: String,
    trials: Vec<String>,
}

impl Recording {
    /// Of a specimen, as it is asked for.
    pub(crate) fn of(specimen: &Specimen, request: &Request) -> Self {
        let (name, profile) = (specimen.name.to_string(), request.profile);
        let command = match specimen.draw {
            None => format!("record {name} --profile {profile}"),
            Some(Draw { seed, number }) => format!("draw {number} --only {number} --seed {seed} --profile {profile}"),
        };
        let stamp = blake3::hash(stamp::text(specimen, profile).as_bytes()).to_hex()[..16].to_owned();
        Self { name, command, stamp, trials: parts(specimen, request).1 }
    }
}

/// Writes the workflow beside the folder of the recordings, in `workflow/recording`, and returns its folder.
///
/// # Errors
/// A [`Diagnostic`] when a folder or file cannot be written.
pub(crate) fn snakemake(root: &Path, request: &Request, recordings: &[Recording]) -> Result<PathBuf> {
    let base = request.into.ancestors().nth(2).unwrap_or(request.into);
    let folder = base.join("workflow").join("recording");
    let whole = |path: &Path| -> Result<PathBuf> {
        let refused = |e| Diagnostic::io(path, e, "choose another folder or correct its permissions");
        std::fs::create_dir_all(path).and_then(|()| path.canonicalize()).map_err(refused)
    };
    let (project, here, into) = (whole(root)?, whole(&folder)?, whole(request.into)?);
    let program = std::env::current_exe()?;
    let places = [
        path_to(&project, &here),
        program.strip_prefix(&project).unwrap_or(&program).display().to_string(),
        into.strip_prefix(&project).unwrap_or(&into).display().to_string(),
    ];
    write_workflow(&folder, [("Snakefile", &snakefile(&places, recordings)), ("recordings.json", &list(recordings)?)])?;
    Ok(folder)
}

/// Each recording with its command, its stamp and its trials.
fn list(recordings: &[Recording]) -> Result<String> {
    let one = |recording: &Recording| {
        let Recording { name, command, stamp, trials } = recording;
        (name.clone(), json!({ "command": command, "stamp": stamp, "trials": trials }))
    };
    Ok(serde_json::to_string_pretty(&Value::from(recordings.iter().map(one).collect::<Map<_, _>>()))? + "\n")
}

/// What jobs ask for is a wide margin over what was seen in the profile `population`: 31 s for the statics, at most 28 s for a trial, and
/// 420 MB for two recordings side by side in one process. Parts of the paper's profile were not measured one by one.
fn snakefile([project, program, into]: &[String; 3], recordings: &[Recording]) -> String {
    let any = |names: &mut dyn Iterator<Item = &String>| {
        let mut names: Vec<&str> = names.map(String::as_str).collect();
        names.sort_unstable();
        names.dedup();
        names.join("|").replace('.', r"\.")
    };
    format!(
        r#"# Written by `rig export snakemake`: jobs that make one part of a recording each, and one that finishes it.
import json
from pathlib import Path

HERE = Path(workflow.basedir)
PROJECT = (HERE / "{project}").resolve()
INTO = PROJECT / "{into}"
RECORDINGS = json.loads((HERE / "recordings.json").read_text())
RIG = f"RAYON_NUM_THREADS={{{{threads}}}} {{PROJECT / config.get('rig', '{program}')}} {{{{params.command}}}} --into {{INTO}} --quiet"
PART = ".made/{{specimen}}/{{part}}"


workdir: str(INTO)


def of(key):
    """What a job's recording has under a key: the command that makes it, or the stamp of what it is made from."""
    return lambda wildcards: RECORDINGS[wildcards.specimen][key]


def parts(wildcards):
    """The parts of a recording."""
    trials = RECORDINGS[wildcards.specimen]["trials"]
    return [PART.format(specimen=wildcards.specimen, part=part) for part in ["{CALIBRATION}", *trials]]


localrules: all


wildcard_constraints: specimen=r"{specimens}", trial=r"{trials}"


rule all:
    input: [f"{{specimen}}/{stamp}" for specimen in RECORDINGS]


# equilibria and the reduced model, which every trial needs
rule {STATICS}:
    output: touch(".made/{{specimen}}/{STATICS}")
    params: command=of("command"), stamp=of("stamp")
    threads: 2
    resources: mem_mb=lambda wildcards, attempt: 1000 * attempt, runtime=lambda wildcards, attempt: 15 * attempt
    shell: RIG + " --part {STATICS}"


# the film of the checkerboard
rule {CALIBRATION}:
    output: touch(".made/{{specimen}}/{CALIBRATION}")
    params: command=of("command"), stamp=of("stamp")
    resources: mem_mb=lambda wildcards, attempt: 1000 * attempt, runtime=lambda wildcards, attempt: 15 * attempt
    shell: RIG + " --part {CALIBRATION}"


rule trial:
    input: ".made/{{specimen}}/{STATICS}"
    output: touch(".made/{{specimen}}/{{trial}}")
    params: command=of("command"), stamp=of("stamp")
    resources: mem_mb=lambda wildcards, attempt: 1000 * attempt, runtime=lambda wildcards, attempt: 15 * attempt
    shell: RIG + " --part {{wildcards.trial}}"


# what is left: solids, card, fixture, ground truth
rule recording:
    input: parts
    output: update("{{specimen}}/{stamp}")
    params: command=of("command"), stamp=of("stamp")
    resources: mem_mb=lambda wildcards, attempt: 1000 * attempt, runtime=lambda wildcards, attempt: 15 * attempt
    # the date is that of the last part, also where the recording was up to date
    shell: RIG + " && touch {{output}}"
"#,
        specimens = any(&mut recordings.iter().map(|recording| &recording.name)),
        trials = any(&mut recordings.iter().flat_map(|recording| &recording.trials)),
        stamp = stamp::FILE,
    )
}
