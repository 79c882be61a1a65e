//! Flow: which stage reads what, as a graph that is laid out in columns, so that a figure and the page show the real one.
//!
//! Stands on: the list of stages, subject. Never knows: how a stage works, what it looks like on paper.

mod layers;

use std::collections::BTreeSet;

use serde_json::{Value, json};

use crate::entry::Entry;
use crate::fault::Outcome;
use crate::needs::{Id, Needs, Shelf};
use crate::subject::Study;

pub use layers::{Laid, Place, lay_out};

/// A room of the pipeline: a kind of recording, or a stage.
#[derive(Debug, Clone, PartialEq)]
pub struct Room {
    /// Its name.
    pub name: String,
    /// What becomes what in it; empty for recordings.
    pub story: String,
    /// The rooms that it reads, by number; all come before it.
    pub reads: Vec<usize>,
}

/// All rooms, recordings first, then stages in the order of the data.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Flow {
    /// The rooms.
    pub rooms: Vec<Room>,
    /// How many of them are recordings.
    pub recordings: usize,
}

impl Flow {
    /// The flow of a study through these stages; stages that have nothing to do in it are left out.
    pub fn of(study: &Study, stages: &[Entry]) -> Self {
        let live: Vec<&Entry> = stages.iter().filter(|entry| !(entry.subjects)(study).is_empty()).collect();
        let reads: Vec<_> = live.iter().map(|entry| (entry.reads)(study)).collect();
        let told: Vec<String> = reads.iter().map(|r| told(&r.raw)).collect();
        let mut recordings: Vec<String> = Vec::new();
        for words in told.iter().filter(|words| !words.is_empty()) {
            if !recordings.contains(words) {
                recordings.push(words.clone());
            }
        }
        let source = |words: &String| recordings.iter().position(|r| r == words);
        let stage = |name: &&str| live.iter().position(|e| e.name == *name).map(|i| recordings.len() + i);
        let rooms = live.iter().zip(&reads).zip(&told).map(|((entry, reads), words)| Room {
            name: entry.name.into(),
            story: entry.story.into(),
            reads: source(words).into_iter().chain(reads.stages.iter().filter_map(stage)).collect(),
        });
        let first = recordings.iter().map(|r| Room { name: r.clone(), story: String::new(), reads: Vec::new() });
        Self { rooms: first.chain(rooms).collect(), recordings: recordings.len() }
    }

    /// What each room reads and does not get through another room that it reads.
    pub fn direct(&self) -> Vec<Vec<usize>> {
        let behind = self.behind();
        let through = |reads: &[usize], of: usize| reads.iter().any(|&other| behind[other].contains(&of));
        let kept = |room: &Room| room.reads.iter().copied().filter(|&of| !through(&room.reads, of)).collect();
        self.rooms.iter().map(kept).collect()
    }

    /// Every room from which something comes into each room.
    fn behind(&self) -> Vec<BTreeSet<usize>> {
        let mut behind: Vec<BTreeSet<usize>> = Vec::new();
        for room in &self.rooms {
            let own: BTreeSet<usize> = room.reads.iter().copied().filter(|&i| i < behind.len()).collect();
            let far = own.iter().flat_map(|&i| behind[i].iter().copied()).collect::<BTreeSet<usize>>();
            behind.push(own.union(&far).copied().collect());
        }
        behind
    }

    /// The flow as a value, for what depends on it.
    pub fn as_json(&self) -> Value {
        json!(self.rooms.iter().map(|r| json!([r.name, r.story, r.reads])).collect::<Vec<_>>())
    }
}

/// The words of a stage's recordings, without of what each is.
fn told(raw: &BTreeSet<String>) -> String {
    let kinds: BTreeSet<&str> = raw.iter().filter_map(|word| word.split(" of ").next()).collect();
    kinds.into_iter().collect::<Vec<_>>().join(", ")
}

impl Needs<Study> for Flow {
    fn wanted(_: &Study) -> Vec<Id> {
        Vec::new()
    }

    fn fetch(of: &Study, _: &dyn Shelf) -> Outcome<Self> {
        Ok(Self::of(of, crate::stages::ALL))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn room(name: &str, reads: &[usize]) -> Room {
        Room { name: name.into(), story: String::new(), reads: reads.to_vec() }
    }

    #[test]
    fn what_comes_through_another_room_is_not_drawn_twice() {
        let rooms = vec![room("film", &[]), room("track", &[0]), room("clock", &[0, 1]), room("fit", &[1, 2])];
        let flow = Flow { rooms, recordings: 1 };
        assert_eq!(flow.direct(), [vec![], vec![0], vec![1], vec![2]]);
    }

    #[test]
    fn every_stage_of_the_pipeline_reads_only_what_comes_before_it() {
        let card = lab::card::parse(include_str!("../../tests/card.toml"), std::path::Path::new("card.toml")).unwrap();
        let study = Study { specimens: vec![crate::subject::Specimen { card: card.into() }] };
        let flow = Flow::of(&study, crate::stages::ALL);
        assert!(flow.rooms.iter().enumerate().all(|(i, room)| room.reads.iter().all(|&r| r < i)), "{flow:?}");
        let stage = |name: &str| flow.rooms.iter().position(|r| r.name == name);
        let fit = stage("identify").unwrap();
        assert!(flow.rooms[fit].reads.contains(&stage("mesh").unwrap()));
    }
}
