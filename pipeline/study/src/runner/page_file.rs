//! `figures/index.html`: what the last run has to show, gathered from the records at hand and written in one step.
//!
//! A record that is not there is said to be missing on the page; the rest is shown.
//!
//! Stands on: store, the page, claims. Never knows: HTML.

use std::path::PathBuf;
use std::{fs, io};

use super::graph::{Goal, Job};
use super::store::{Found, Store, write_at_once};
use super::{MetricEntry, Runner, metrics_file};
use crate::claims::{self, Claim};
use crate::entry::Kind;
use crate::fault::{Fault, Outcome};
use crate::figures::overview;
use crate::flow::Flow;
use crate::needs::{Id, Shelf};
use crate::page::{Body, Cost, Page, Shown, Verdict};
use crate::record::Record;
use crate::records::{Inflation, Mesh};
use crate::subject::Scope;

/// Writes the page unless it lies there already; says where it is.
///
/// # Errors
/// A [`Fault`] when the folder cannot be written or a record's bytes are not what they were.
pub fn write(runner: &Runner) -> Outcome<PathBuf> {
    let jobs = runner.jobs_of(&Goal::default())?;
    let text = gather(runner, &jobs)?.html();
    let place = runner.folders.page();
    if !fs::read(&place).is_ok_and(|old| old == text.as_bytes()) {
        write_at_once(&place, text.as_bytes()).map_err(|e: io::Error| {
            let what = format!("{} cannot be written", runner.folders.tell(&place));
            Fault::new(what, e, "free some disk space or mend the folder's permissions")
        })?;
    }
    Ok(place)
}

fn gather(runner: &Runner, jobs: &[Job]) -> Outcome<Page> {
    let store = Store::new(&runner.folders);
    let costs = costs(runner, jobs, &store);
    let metrics = metrics_file::read(runner).unwrap_or_default();
    let claims = claims::read(&runner.folders.claims()).unwrap_or_default();
    Ok(Page {
        note: note(runner),
        bodies: bodies(runner, &store)?,
        figures: shown(jobs, &store, Kind::Figure, "svg"),
        tables: shown(jobs, &store, Kind::Table, "csv"),
        claims: claims.iter().map(|claim| verdict(claim, &metrics)).collect(),
        graph: Some(graph(runner, &costs)?),
        costs,
    })
}

fn note(runner: &Runner) -> String {
    let names: Vec<&str> = runner.study.specimens.iter().map(|s| s.card.name.as_str()).collect();
    let of_bench = |s: &crate::subject::Specimen| s.card.origin == lab::card::Origin::VirtualBench;
    let from = match runner.study.specimens.iter().filter(|s| of_bench(s)).count() {
        0 => "",
        n if n == names.len() => " All data come from the virtual bench: nothing here was measured.",
        _ => " Some of the data come from the virtual bench.",
    };
    format!("Specimens: {}; profile: {}.{from}", names.join(", "), runner.profile.name())
}

/// Figures or tables, each as its file of one kind.
fn shown(jobs: &[Job], store: &Store, kind: Kind, ending: &str) -> Vec<Shown> {
    let text = |job: &Job| {
        let parcel = store.parcel(&job.id).ok()?;
        let bytes = parcel.bytes(&format!("{}.{ending}", job.entry.name)).ok()?.to_vec();
        String::from_utf8(bytes).ok()
    };
    let of_kind = jobs.iter().filter(|job| job.entry.kind == kind);
    of_kind.map(|job| Shown { name: job.entry.name.into(), story: job.entry.story.into(), text: text(job) }).collect()
}

fn verdict(claim: &Claim, metrics: &[MetricEntry]) -> Verdict {
    let by: Vec<&str> = claim.metrics().map(String::as_str).collect();
    Verdict {
        says: claim.says.clone(),
        reproduces: match claim.verdict(metrics) {
            claims::Verdict::Reproduces => Some(true),
            claims::Verdict::Fails => Some(false),
            claims::Verdict::NotMeasured => None,
        },
        rule: format!("{} {}", by.join(" and "), claim.rule.in_words()),
        ours: claim.ours(metrics).join(", "),
        published: claim.published.clone(),
    }
}

fn costs(runner: &Runner, jobs: &[Job], store: &Store) -> Vec<Cost> {
    let entries = runner.lists.iter().flat_map(|list| list.iter()).filter(|entry| entry.kind == Kind::Stage);
    let cost = |entry: &crate::entry::Entry| {
        let own: Vec<&Job> =
            jobs.iter().filter(|job| job.entry.kind == Kind::Stage && job.entry.name == entry.name).collect();
        let found =
            own.iter().filter_map(|job| if let Found::Whole(m) = store.look(&job.id) { Some(m.seconds) } else { None });
        let seconds: Vec<f64> = found.collect();
        let records = [seconds.len(), own.len()];
        Cost {
            name: entry.name.into(),
            story: entry.story.into(),
            records,
            seconds: seconds.iter().fold(0.0, |sum, s| sum + s),
        }
    };
    entries.map(cost).filter(|cost| cost.records[1] > 0).collect()
}

/// The graph of the stages, with what each cost instead of its story.
fn graph(runner: &Runner, costs: &[Cost]) -> Outcome<String> {
    let flow = Flow::of(&runner.study, runner.lists.first().copied().unwrap_or_default());
    let said = |name: &str| {
        let cost = costs.iter().find(|c| c.name == name)?;
        Some(format!("{} of {} records, {:.1}\u{a0}s", cost.records[0], cost.records[1], cost.seconds))
    };
    drawn(&flow, &said)
}

/// A graph of stages with what is `said` of each, as SVG.
pub(super) fn drawn(flow: &Flow, said: &dyn Fn(&str) -> Option<String>) -> Outcome<String> {
    let diagram = overview::graph(flow, said);
    let tall = plot::DOUBLE_COLUMN_MM * diagram.size[1] / diagram.size[0];
    let figure = plot::Figure::new(plot::DOUBLE_COLUMN_MM).row(tall, [plot::Panel::Diagram(diagram)]);
    figure.svg().map_err(Fault::from_tool)
}

/// The tails that have been inflated.
fn bodies(runner: &Runner, store: &Store) -> Outcome<Vec<Body>> {
    let mut bodies = Vec::new();
    for specimen in &runner.study.specimens {
        let id = |stage: &'static str| Id { stage, subject: specimen.name() };
        let (Ok(mesh), Ok(inflation)) = (store.parcel(&id(Mesh::STAGE)), store.parcel(&id(Inflation::STAGE))) else {
            continue;
        };
        let mesh = Mesh::unpack(&mesh).map_err(Fault::from_tool)?;
        let inflation = Inflation::unpack(&inflation).map_err(Fault::from_tool)?;
        bodies.push(Body::new(&specimen.card.name, &mesh, &inflation));
    }
    Ok(bodies)
}
