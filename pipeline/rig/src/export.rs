//! The recordings as a workflow for Snakemake: a job for each part, and one that finishes a recording.
//!
//! A job is `rig record --part` or `rig draw --only NUMBER --part`, so that parts lie in the same partial folder and have the same bytes as
//! those of `rig record`, under the same locks. What Snakemake sees of a part is an empty file, since its checkpoint is gone when the
//! recording is finished. It is removed when neither the recording nor the partial folder has the stamp of what is to be recorded.
//!
//! Nothing from outside is interpolated into the Snakefile: places, commands and names are read from JSON, and quoted where a shell sees
//! them.

use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, Result};
use serde_json::{Map, json};
use workflow::export::path_as_text;
use workflow::snakemake::{Workflow, as_text, path_to, write_workflow};

use crate::record::{CALIBRATION, Request, STATICS, parts};
use crate::specimen::{Draw, Specimen};
use crate::stamp;

/// A recording that is exported.
pub(crate) struct Recording {
    name: String,
    /// The arguments of the command that makes it.
    command: Vec<String>,
    /// Changes with everything that it is made from.
    stamp: String,
    trials: Vec<String>,
}

impl Recording {
    /// Of a specimen, as it is asked for.
    pub(crate) fn of_specimen(specimen: &Specimen, request: &Request) -> Self {
        let (name, profile) = (specimen.name.to_string(), request.profile);
        let command = match specimen.draw {
            None => format!("record {name} --profile {profile}"),
            Some(Draw { seed, number }) => format!("draw {number} --only {number} --seed {seed} --profile {profile}"),
        };
        // neither a specimen of the bench nor a profile has a space in its name
        let command = command.split(' ').map(str::to_owned).collect();
        Self { name, command, stamp: stamp::stamp_text(specimen, profile), trials: parts(specimen, request).1 }
    }
}

/// Writes the workflow into `folder`, for recordings in the folder of the request.
///
/// # Errors
/// A [`Diagnostic`] when a folder or file cannot be written, or the folder holds what no export wrote.
pub(crate) fn write_snakemake(
    root: &Path,
    folder: &Path,
    request: &Request,
    recordings: &[Recording],
) -> Result<Workflow> {
    let created = |path: &Path| -> Result<PathBuf> {
        let refused = |e| Diagnostic::io(path, e, "choose another folder or correct its permissions");
        std::fs::create_dir_all(path).and_then(|()| path.canonicalize()).map_err(refused)
    };
    let (project, here, into) = (created(root)?, created(folder)?, created(request.into)?);
    let program = std::env::current_exe()?;
    let row = |Recording { name, command, stamp, trials }: &Recording| {
        (name.clone(), json!({ "command": command, "stamp": stamp, "trials": trials }))
    };
    let table = json!({
        "project": path_to(&project, &here)?,
        "program": path_as_text(program.strip_prefix(&project).unwrap_or(&program))?,
        "into": path_as_text(into.strip_prefix(&project).unwrap_or(&into))?,
        "recordings": recordings.iter().map(row).collect::<Map<_, _>>(),
    });
    write_workflow(folder, [("Snakefile", &snakefile_text()), ("recordings.json", &as_text(&table)?)])
}

/// What jobs ask for is a wide margin over what was seen in the profile `population`: 31 s for the statics, at most 28 s for a trial, and
/// 420 MB for two recordings side by side in one process. Parts of the paper's profile were not measured one by one.
fn snakefile_text() -> String {
    SNAKEFILE.replace("STATICS", STATICS).replace("CALIBRATION", CALIBRATION).replace("STAMP", stamp::FILE)
}

const SNAKEFILE: &str = r#"# Written by `rig export snakemake`: jobs that make one part of a recording each, and one that finishes it.
import json
import re
import shlex
import shutil
from pathlib import Path

HERE = Path(workflow.basedir)
PLACES = json.loads((HERE / "recordings.json").read_text(encoding="utf-8"))
PROJECT = (HERE / PLACES["project"]).resolve()
INTO = PROJECT / PLACES["into"]
RECORDINGS = PLACES["recordings"]
PROGRAM = str(PROJECT / config.get("rig", PLACES["program"]))
# braces are doubled, since Snakemake fills in names between single ones
SHELL = shlex.join([PROGRAM]).replace("{", "{{").replace("}", "}}")
PLACE = shlex.join(["--into", str(INTO), "--quiet"]).replace("{", "{{").replace("}", "}}")
RIG = "RAYON_NUM_THREADS={threads} " + SHELL + " {params.command} " + PLACE
PART = ".made/{specimen}/{part}"


workdir: str(INTO)


def is_begun(name, stamp):
    """Whether a recording, or the parts of one, are of what is to be recorded."""
    places = [INTO / name / "STAMP", INTO / f".{name}.partial" / "STAMP"]
    return any(place.is_file() and place.read_text(encoding="utf-8") == stamp for place in places)


if workflow.is_main_process:
    for name, recording in RECORDINGS.items():
        if not is_begun(name, recording["stamp"]):
            shutil.rmtree(INTO / ".made" / name, ignore_errors=True)


def command(wildcards):
    """The arguments that make a recording."""
    return shlex.join(RECORDINGS[wildcards.specimen]["command"])


def parts(wildcards):
    """The parts of a recording."""
    trials = RECORDINGS[wildcards.specimen]["trials"]
    return [PART.format(specimen=wildcards.specimen, part=part) for part in ["CALIBRATION", *trials]]


def any_of(names):
    """A pattern of names."""
    return "|".join(sorted(map(re.escape, set(names))))


localrules: all


wildcard_constraints:
    specimen=any_of(RECORDINGS),
    trial=any_of(trial for recording in RECORDINGS.values() for trial in recording["trials"]),


rule all:
    input: [PART.format(specimen=specimen, part="recording") for specimen in RECORDINGS]


# equilibria and the reduced model, which every trial needs
rule STATICS:
    output: touch(".made/{specimen}/STATICS")
    params: command=command
    threads: 2
    resources: mem_mb=lambda wildcards, attempt: 1000 * attempt, runtime=lambda wildcards, attempt: 15 * attempt
    shell: RIG + " --part STATICS"


# the film of the checkerboard
rule CALIBRATION:
    output: touch(".made/{specimen}/CALIBRATION")
    params: command=command
    resources: mem_mb=lambda wildcards, attempt: 1000 * attempt, runtime=lambda wildcards, attempt: 15 * attempt
    shell: RIG + " --part CALIBRATION"


rule trial:
    input: ".made/{specimen}/STATICS"
    output: touch(".made/{specimen}/{trial}")
    params: command=command
    resources: mem_mb=lambda wildcards, attempt: 1000 * attempt, runtime=lambda wildcards, attempt: 15 * attempt
    shell: RIG + " --part {wildcards.trial}"


# what is left: solids, card, fixture, ground truth
rule recording:
    input: parts
    output: touch(".made/{specimen}/recording")
    params: command=command
    resources: mem_mb=lambda wildcards, attempt: 1000 * attempt, runtime=lambda wildcards, attempt: 15 * attempt
    shell: RIG
"#;
