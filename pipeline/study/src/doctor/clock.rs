//! Clocks: the lamp's edges in film and log are the same, and the film shows rest before the first command.
//!
//! Stands on: the stage clock. Never knows: a pixel.

use super::Look;
use super::film::Seen;
use super::finding::Finding;
use crate::runner;
use crate::stage::Stage;
use crate::stages::clock::{Clock, Settings, meet};
use crate::subject::Trial;

/// Whether film and log of a trial meet.
pub fn look(look: &Look, of: &Trial, seen: &Seen, set: &Settings) -> Vec<Finding> {
    let raw = Clock::raw(of);
    let desk = runner::desk(look.folders, &raw);
    meet(of, set, &seen.tracks, seen.height, &desk).err().map(Finding::from).into_iter().collect()
}
