//! The Snakefile: its head, and a rule for each stage, figure or table.

use super::marks::{PUBLICATION, TABLE, mark_path, rule_name};
use super::resources::Resources;
use crate::entry::{Entry, Kind};
use crate::runner::{Job, Measured, Runner, Store};
use crate::subject::Universe;

/// The text of the Snakefile: a rule for every entry where all is exported, since a later card may have records of any, and otherwise for
/// those that have records.
pub fn snakefile<U: Universe>(runner: &Runner<U>, jobs: &[Job<U>], is_whole: bool) -> String {
    let records = |entry: &Entry<U>| jobs.iter().filter(|job| std::ptr::eq(job.entry, entry)).collect::<Vec<_>>();
    let entries = runner.lists.iter().flat_map(|list| list.iter()).map(|entry| (entry, records(entry)));
    let entries: Vec<(&Entry<U>, Vec<&Job<U>>)> =
        entries.filter(|(_, entry_jobs)| is_whole || !entry_jobs.is_empty()).collect();
    let local = entries.iter().filter(|(entry, _)| entry.kind != Kind::Stage);
    let local = local.map(|(entry, _)| format!(", {}", rule_name(entry)));
    let mut text = HEAD
        .replace("LOCAL", &local.collect::<String>())
        .replace("TABLE", TABLE)
        .replace("MARK", &mark_path(&runner.folders, "{record}"))
        .replace("PUBLICATION", PUBLICATION);
    for (entry, entry_jobs) in &entries {
        text += &rule_text(runner, entry, entry_jobs);
    }
    text
}

/// Braces are doubled in what becomes a part of a rule's `shell`, where Snakemake fills in names between single ones.
const HEAD: &str = r#"# Written by `study export snakemake`: a rule for each stage, figure and table, whose jobs make one record each.
# Resources are those measured with a margin, and defaults where nothing was measured.
import json
import re
import shlex
import subprocess
from pathlib import Path

HERE = Path(workflow.basedir)
PLACES = json.loads((HERE / "places.json").read_text(encoding="utf-8"))
PROJECT = (HERE / PLACES["project"]).resolve()
PROGRAM = str(PROJECT / config.get("study", PLACES["program"]))
STUDY = [PROGRAM, "--root", str(PROJECT), "--profile", PLACES["profile"], "--quiet"]
SHELL = shlex.join(STUDY).replace("{", "{{").replace("}", "}}")

# marks are set for the records that `study plan` calls kept, of the cards, settings and recordings as they are now
if workflow.is_main_process:
    only = [f"--only={name}" for name in PLACES["only"]]
    if subprocess.run([*STUDY, "export", "snakemake", "--marks", *only, str(HERE)]).returncode != 0:
        raise WorkflowError("the study cannot be planned: its message stands above")
RECORDS = json.loads((HERE / "TABLE").read_text(encoding="utf-8"))

workdir: str((HERE / PLACES["base"]).resolve())


def mark(record):
    """What shows that a record is up to date."""
    return f"MARK"


def reads(stage):
    """The marks of the records that a record of a stage, figure or table reads."""
    return lambda wildcards: [mark(record) for record in RECORDS[f"{stage}/{wildcards.subject}"]["reads"]]


def subjects(rule):
    """The subjects of a rule's records, as a pattern; nothing matches that of none."""
    names = [record.partition("/")[2] for record, made in RECORDS.items() if made["rule"] == rule]
    return "|".join(map(re.escape, names)) or "(?!)"


localrules: all, publishLOCAL


rule all:
    input: mark("PUBLICATION")


# numbers, the archive's description and the page, of all records
rule publish:
    input: [mark(record) for record in RECORDS]
    output: touch(mark("PUBLICATION"))
    params: only=PLACES["only"]
    shell: SHELL + " publish {params.only}"
"#;

/// A rule; its wildcard is the subject of a record.
fn rule_text<U: Universe>(runner: &Runner<U>, entry: &Entry<U>, jobs: &[&Job<U>]) -> String {
    let store = Store::new(&runner.folders);
    let measured: Vec<Measured> = jobs.iter().filter_map(|job| store.measured(&job.id)).collect();
    let asked = Resources::of(&measured);
    let measured = Resources::in_words(&measured);
    let name = entry.name;
    let mut text = format!("\n\n# {}\n# {measured}\nrule {}:\n", entry.description, rule_name(entry));
    let mut line = |words: String| text += &format!("    {words}\n");
    line(format!("input: reads(\"{name}\")"));
    line(format!("output: touch(\"{}\")", mark_path(&runner.folders, &format!("{name}/{{subject}}"))));
    line(format!("wildcard_constraints: subject=subjects(\"{}\")", rule_name(entry)));
    line(format!("params: record=\"{name}/{{subject}}\""));
    line(format!("threads: {}", asked.threads));
    let twice = |value: u64| format!("lambda wildcards, attempt: {value} * attempt");
    line(format!("resources: mem_mb={}, runtime={}", twice(asked.memory), twice(asked.runtime)));
    line("shell: SHELL + \" --threads {threads} make {params.record}\"".into());
    text
}
