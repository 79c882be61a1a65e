//! The Snakefile: its head, and a rule for each stage, figure or table.

use super::resources::Resources;
use super::{Paths, below};
use crate::entry::{Entry, Kind};
use crate::needs::RecordId;
use crate::runner::{Job, Measured, Runner, Store};
use crate::subject::Universe;

/// The text of the Snakefile.
pub fn snakefile<U: Universe>(runner: &Runner<U>, jobs: &[Job<U>], paths: &Paths) -> String {
    let entries: Vec<&'static Entry<U>> = runner.lists.iter().flat_map(|list| list.iter()).collect();
    let of = |entry: &Entry<U>| jobs.iter().filter(|job| std::ptr::eq(job.entry, entry)).collect::<Vec<_>>();
    let made: Vec<(&Entry<U>, Vec<&Job<U>>)> =
        entries.into_iter().map(|e| (e, of(e))).filter(|(_, j)| !j.is_empty()).collect();
    let local = made.iter().filter(|(entry, _)| entry.kind != Kind::Stage);
    let local = local.map(|(entry, _)| format!(", {}", rule_name(entry)));
    let mut text = head(runner, paths, &local.collect::<String>());
    for (entry, jobs) in &made {
        text += &rule(runner, entry, jobs);
    }
    text
}

fn head<U: Universe>(runner: &Runner<U>, paths: &Paths, local: &str) -> String {
    let Paths { base, project, program } = paths;
    let metrics = below(&runner.folders, &runner.folders.metrics());
    format!(
        r#"# Written by `study export snakemake`: a rule for each stage, figure and table, whose jobs make one record each.
# Resources are those measured with a margin, and defaults where nothing was measured.
import json
from pathlib import Path

HERE = Path(workflow.basedir)
PROJECT = (HERE / "{project}").resolve()
STUDY = f"{{PROJECT / config.get('study', '{program}')}} --root {{PROJECT}} --profile {profile} --quiet"
RECORDS = json.loads((HERE / "records.json").read_text())
MANIFESTS = [record["manifest"] for record in RECORDS.values()]

workdir: str((HERE / "{base}").resolve())


def inputs(record):
    """The settings, cards and recordings that a record is made from, and the manifests of the records that it reads."""
    made_from = RECORDS[record]
    files = [str(PROJECT / "study.toml") if file == "settings" else file for file in made_from["files"]]
    return files + [RECORDS[read]["manifest"] for read in made_from["records"]]


localrules: all, publish{local}


# a record that was removed is made again whether or not the numbers are there
rule all:
    input: "{metrics}", MANIFESTS


# numbers, the archive's description and the page, of all records
rule publish:
    input: MANIFESTS
    output: update("{metrics}")
    shell: STUDY + " publish"
"#,
        profile = runner.profile.name(),
    )
}

/// A rule; its wildcards are the parts of its subjects' names.
fn rule<U: Universe>(runner: &Runner<U>, entry: &Entry<U>, jobs: &[&Job<U>]) -> String {
    let store = Store::new(&runner.folders);
    let measured: Vec<Measured> = jobs.iter().filter_map(|job| store.measured(&job.id)).collect();
    let asked = Resources::of(&measured);
    let pattern = Pattern::of::<U>(jobs);
    let id = RecordId { stage: entry.name, subject: pattern.subject };
    let output = below(&runner.folders, &runner.folders.manifest(&id));
    let measured = Resources::in_words(&measured);
    let mut text = format!("\n\n# {}\n# {measured}\nrule {}:\n", entry.description, rule_name(entry));
    let mut line = |words: String| text += &format!("    {words}\n");
    line(format!("input: lambda wildcards: inputs(\"{id}\".format(**wildcards))"));
    line(format!("output: update(\"{output}\")"));
    if !pattern.constraints.is_empty() {
        line(format!("wildcard_constraints: {}", pattern.constraints.join(", ")));
    }
    line(format!("params: record=\"{id}\", version={}", entry.version));
    line(format!("threads: {}", asked.threads));
    let twice = |value: u64| format!("lambda wildcards, attempt: {value} * attempt");
    line(format!("resources: mem_mb={}, runtime={}", twice(asked.memory), twice(asked.runtime)));
    line("shell: STUDY + \" --threads {threads} make {params.record}\"".into());
    text
}

/// A stage by its name, a figure and a table by what it is as well: a stage may share the name of the figure that shows it.
fn rule_name<U>(entry: &Entry<U>) -> String {
    match entry.kind {
        Kind::Stage => entry.name.into(),
        Kind::Figure => format!("figure_{}", entry.name),
        Kind::Table => format!("table_{}", entry.name),
    }
}

/// The subjects of a rule as a pattern with wildcards.
struct Pattern {
    subject: String,
    constraints: Vec<String>,
}

impl Pattern {
    fn of<U: Universe>(jobs: &[&Job<U>]) -> Self {
        let subjects: Vec<Vec<&str>> = jobs.iter().map(|job| job.id.subject.split('/').collect()).collect();
        let levels = subjects.iter().map(Vec::len).max().unwrap_or_default();
        let names = [U::GROUP, U::ITEM];
        let (mut parts, mut constraints) = (Vec::new(), Vec::new());
        for level in 0..levels {
            let mut values: Vec<&str> = subjects.iter().filter_map(|parts| parts.get(level).copied()).collect();
            values.sort_unstable();
            values.dedup();
            match values[..] {
                // "all", and what lies beside it: not a subject among others
                [one] if subjects[0][0] == "all" => parts.push(one.to_owned()),
                _ => {
                    parts.push(format!("{{{}}}", names[level.min(1)]));
                    constraints.push(format!("{}=r\"{}\"", names[level.min(1)], values.join("|").replace('.', r"\.")));
                }
            }
        }
        Self { subject: parts.join("/"), constraints }
    }
}
