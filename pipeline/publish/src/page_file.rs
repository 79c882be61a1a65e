//! `figures/index.html`: the results of the last run, collected from the existing records and written atomically.
//!
//! A missing record is marked as missing on the page.

use std::io;
use std::path::PathBuf;

use crate::claims::Claim;
use crate::expected::MetricEntry;
use crate::metrics_file;
use crate::page::{Body, Cost, LiveTail, Page, Shown, Verdict};
use crate::stage_diagram::stage_diagram;
use crate::stand_in;
use diagnostics::{Diagnostic, Result, input};
use workflow::entry::Kind;
use workflow::needs::RecordReader;
use workflow::runner::Runner;
use workflow::runner::{Found, Store, write_atomically};
use workflow::runner::{Goal, Job};
use workflow::stage_graph::StageGraph;
use workflow::subject::Universe;

/// The project's own parts of the page.
#[derive(Debug, Clone, Default)]
pub struct Contents {
    /// Under the title: the origin of the data.
    pub note: String,
    /// Bodies to be shown in space.
    pub bodies: Vec<Body>,
    /// Tails that move on the page.
    pub tails: Vec<LiveTail>,
}

/// Writes the page unless it is unchanged; returns its path.
///
/// # Errors
/// A [`Diagnostic`] when the folder cannot be written or a record is damaged.
pub fn write<U: Universe>(runner: &Runner<U>, contents: Contents) -> Result<PathBuf> {
    let jobs = runner.jobs_of(&Goal::default())?;
    let text = collected_page(runner, &jobs, contents)?.html();
    let path = runner.folders.page();
    if !input::read(&path, input::MESH).is_ok_and(|former| former == text.as_bytes()) {
        write_atomically(&path, text.as_bytes()).map_err(|e: io::Error| {
            let defect = format!("{} cannot be written", runner.folders.display(&path));
            Diagnostic::new(defect, e, "free some disk space or correct the folder's permissions")
        })?;
    }
    Ok(path)
}

fn collected_page<U: Universe>(runner: &Runner<U>, jobs: &[Job<U>], contents: Contents) -> Result<Page> {
    let store = Store::new(&runner.folders);
    let costs = stage_costs(runner, jobs, &store);
    let metrics = metrics_file::read(runner).unwrap_or_default();
    let claims = stand_in::read(&runner.folders.claims(), runner.profile).unwrap_or_default();
    Ok(Page {
        note: contents.note,
        bodies: contents.bodies,
        tails: contents.tails,
        figures: shown_entries(jobs, &store, Kind::Figure, "svg"),
        tables: shown_entries(jobs, &store, Kind::Table, "csv"),
        claims: claims.iter().map(|claim| claim_verdict(claim, &metrics)).collect(),
        graph: Some(graph_svg(runner, &costs)?),
        costs,
    })
}

/// Figures or tables, each as its file of one kind.
fn shown_entries<U: Universe>(jobs: &[Job<U>], store: &Store, kind: Kind, ending: &str) -> Vec<Shown> {
    let file_text = |job: &Job<U>| {
        let files = store.files(&job.id).ok()?;
        let bytes = files.bytes(&format!("{}.{ending}", job.entry.name)).ok()?.to_vec();
        String::from_utf8(bytes).ok()
    };
    let selected = jobs.iter().filter(|job| job.entry.kind == kind);
    selected
        .map(|job| Shown {
            name: job.entry.name.into(),
            description: job.entry.description.into(),
            text: file_text(job),
        })
        .collect()
}

fn claim_verdict(claim: &Claim, metrics: &[MetricEntry]) -> Verdict {
    Verdict {
        says: claim.says.clone(),
        verdict: claim.verdict(metrics),
        rule: claim.rules_in_words(),
        ours: claim.ours(metrics).join(", "),
        published: claim.published.clone(),
    }
}

fn stage_costs<U: Universe>(runner: &Runner<U>, jobs: &[Job<U>], store: &Store) -> Vec<Cost> {
    let entries = runner.lists.iter().flat_map(|list| list.iter()).filter(|entry| entry.kind == Kind::Stage);
    let cost = |entry: &workflow::entry::Entry<U>| {
        let stage_jobs: Vec<&Job<U>> =
            jobs.iter().filter(|job| job.entry.kind == Kind::Stage && job.entry.name == entry.name).collect();
        let measured_seconds = stage_jobs
            .iter()
            .filter_map(|job| if let Found::Whole(m) = store.find(&job.id) { Some(m.seconds) } else { None });
        let seconds: Vec<f64> = measured_seconds.collect();
        let records = [seconds.len(), stage_jobs.len()];
        Cost {
            name: entry.name.into(),
            description: entry.description.into(),
            records,
            seconds: seconds.iter().fold(0.0, |sum, s| sum + s),
        }
    };
    entries.map(cost).filter(|cost| cost.records[1] > 0).collect()
}

/// The graph of the stages, with the computing time of each instead of its description.
fn graph_svg<U: Universe>(runner: &Runner<U>, costs: &[Cost]) -> Result<String> {
    let graph = runner.stage_graph();
    let cost_text = |name: &str| {
        let cost = costs.iter().find(|c| c.name == name)?;
        Some(format!("{} of {} records, {:.1}\u{a0}s", cost.records[0], cost.records[1], cost.seconds))
    };
    drawn(&graph, &cost_text)
}

/// A graph of stages, each with the text `text`, as SVG.
pub fn drawn(flow: &StageGraph, text: &dyn Fn(&str) -> Option<String>) -> Result<String> {
    let diagram = stage_diagram(flow, text);
    let height = plot::DOUBLE_COLUMN_MM * diagram.size[1] / diagram.size[0];
    let figure = plot::Figure::new(plot::DOUBLE_COLUMN_MM).row(height, [plot::Panel::Diagram(diagram)]);
    figure.svg().map_err(Diagnostic::from)
}
