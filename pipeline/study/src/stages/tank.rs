//! Tank: still water after a run shows the tank's standing waves. Paper: section IV, the standing wave.
//!
//! Where the size of the tank is set, the dispersion relation says where to look.
//!
//! Stands on: signal. Never knows: a tail.

use std::path::Path as FilePath;

use lab::card::FixtureOf;
use serde::{Deserialize, Serialize};
use si::{Hertz, Metre};
use signal::wave;

use crate::fault::{Fault, Outcome};
use crate::records;
use crate::stage::{Desk, RawFile, Stage};
use crate::subject::Specimen;

/// The stage.
pub struct Tank;

/// `[tank]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Of the tank, along the tail, m.
    length: Metre,
    /// Of the water, m.
    depth: Metre,
    /// How many standing waves are looked for.
    modes: u32,
}

impl Stage for Tank {
    type Settings = Settings;
    type Needs = ();
    type Makes = records::Tank;
    const STORY: &'static str = "still water shows the tank's standing waves";
    const EDITION: u32 = 2;

    fn raw(of: &Specimen) -> Vec<RawFile> {
        let still = of.card.fixture.iter().filter(|f| f.of == FixtureOf::StillWater);
        still.take(1).map(|f| RawFile::new("still water", &of.card.name, &f.force)).collect()
    }

    fn run(_: &Specimen, set: &Settings, (): (), desk: &dyn Desk) -> Outcome<records::Tank> {
        let log = read_force("still water", desk)?;
        let expected: Vec<Hertz> = (1..=set.modes).map(|n| wave::foretold(set.length, set.depth, n)).collect();
        let found = wave::still(&log.series(), &expected)
            .map_err(|e| Fault::from_tool(format!("{}: {e}", desk.place("still water"))))?;
        Ok(records::Tank {
            waves: found.waves,
            noise: found.noise,
            suppression_db: found.suppression_db,
            size_m: [set.length, set.depth],
        })
    }
}

/// A force log of the desk.
pub(super) fn read_force(word: &str, desk: &dyn Desk) -> Outcome<lab::ForceLog> {
    let place = desk.place(word);
    let text = String::from_utf8(desk.bytes(word)?)
        .map_err(|e| Fault::new(format!("{place} is not text"), e, "export the log as CSV in UTF-8"))?;
    lab::force::parse(&text, FilePath::new(&place)).map_err(Fault::from_tool)
}
