//! The plan as a tree: each stage under the last one that it reads, with how many of its records would be kept or made.
//!
//! Stands on: flow, plan. Never knows: a disk.

use std::collections::BTreeMap;

use super::Runner;
use super::graph::Job;
use super::plan::{Share, shares};
use crate::entry::Kind;
use crate::flow::Flow;

/// One line a recording or stage; branches as on a page.
pub fn text(runner: &Runner, jobs: &[Job]) -> String {
    let flow = flow(runner);
    let direct = flow.direct();
    let shares = shares(runner, jobs);
    let said = |room: usize| said(&flow, &direct, &shares, room);
    let mut children: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (room, reads) in direct.iter().enumerate() {
        if let Some(parent) = reads.iter().max() {
            children.entry(*parent).or_default().push(room);
        }
    }
    let mut lines = Vec::new();
    for root in (0..flow.rooms.len()).filter(|room| direct[*room].is_empty()) {
        lines.push(said(root));
        branch(&children, &said, root, "", &mut lines);
    }
    lines.join("\n")
}

/// The same graph as a drawing, SVG.
///
/// # Errors
/// A [`crate::fault::Fault`] when it cannot be drawn.
pub fn svg(runner: &Runner, jobs: &[Job]) -> crate::fault::Outcome<String> {
    let shares = shares(runner, jobs);
    super::page_file::drawn(&flow(runner), &|name: &str| Some(shares.get(name)?.in_words()))
}

fn flow(runner: &Runner) -> Flow {
    Flow::of(&runner.study, runner.lists.first().copied().unwrap_or_default())
}

fn branch(
    children: &BTreeMap<usize, Vec<usize>>,
    said: &dyn Fn(usize) -> String,
    of: usize,
    before: &str,
    lines: &mut Vec<String>,
) {
    let own = children.get(&of).map_or(&[][..], Vec::as_slice);
    for (i, child) in own.iter().enumerate() {
        let last = i + 1 == own.len();
        lines.push(format!("{before}{} {}", if last { "└─" } else { "├─" }, said(*child)));
        branch(children, said, *child, &format!("{before}{} ", if last { "  " } else { "│ " }), lines);
    }
}

/// Its name, its share of records, and what it reads beside the room that it hangs under.
fn said(flow: &Flow, direct: &[Vec<usize>], shares: &BTreeMap<&str, Share>, room: usize) -> String {
    let name = &flow.rooms[room].name;
    let share = shares.get(name.as_str()).map_or_else(String::new, |share| format!("  {}", share.in_words()));
    let parent = direct[room].iter().max();
    let also: Vec<&str> =
        direct[room].iter().filter(|r| Some(*r) != parent).map(|r| flow.rooms[*r].name.as_str()).collect();
    let also = if also.is_empty() { String::new() } else { format!("  (reads {} as well)", also.join(", ")) };
    format!("{name}{share}{also}")
}

/// Whether a job is a stage's.
pub(super) fn is_stage(job: &Job) -> bool {
    job.entry.kind == Kind::Stage
}
