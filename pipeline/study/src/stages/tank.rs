//! Tank: the standing waves of the tank, identified in water at rest after a run. Paper: section IV, the standing wave.
//!
//! Where the size of the tank is set, the dispersion relation gives the initial frequencies.

use std::path::Path as FilePath;

use lab::card::FixtureOf;
use serde::{Deserialize, Serialize};
use si::{Hertz, Metre};
use signal::wave;

use crate::records;
use crate::subject::Specimen;
use diagnostics::{Diagnostic, Result};
use workflow::stage::{RawFile, Stage, StageContext};

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
    /// Number of standing waves.
    modes: u32,
}

impl Stage for Tank {
    type Settings = Settings;
    type Card = ();
    type Needs = ();
    type Makes = records::Tank;
    const DESCRIPTION: &'static str = "the tank's standing waves are identified in water at rest";
    const VERSION: u32 = 2;

    fn raw(of: &Specimen) -> Vec<RawFile> {
        let still = of.card.fixture.iter().filter(|f| f.of == FixtureOf::StillWater);
        still.take(1).map(|f| RawFile::new("still water", &of.card.name, &f.force)).collect()
    }

    fn run((): &(), set: &Settings, (): (), context: &dyn StageContext) -> Result<records::Tank> {
        let log = read_force("still water", context)?;
        let expected: Vec<Hertz> = (1..=set.modes).map(|n| wave::natural_frequency(set.length, set.depth, n)).collect();
        let found = wave::identify(&log.series(), &expected)
            .map_err(|e| Diagnostic::from(e).in_file(FilePath::new(&context.display_path("still water"))))?;
        Ok(records::Tank {
            waves: found.waves,
            noise: found.noise,
            suppression_db: found.suppression_db,
            size_m: [set.length, set.depth],
        })
    }
}

/// A force log of the context.
pub(super) fn read_force(word: &str, context: &dyn StageContext) -> Result<lab::ForceLog> {
    let place = context.display_path(word);
    let text = String::from_utf8(context.bytes(word)?)
        .map_err(|e| Diagnostic::new(format!("{place} is not text"), e, "export the log as CSV in UTF-8"))?;
    lab::force::parse(&text, FilePath::new(&place))
}
