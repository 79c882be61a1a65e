//! Tank: the standing waves of the tank, identified in water at rest after a run. Paper: section IV, the standing wave.
//!
//! The size of the tank on the card gives the expected frequencies by the dispersion relation. A wave is reported where it rises over the
//! noise at the level of the settings; the record has the p-value of each. A log in which something moves is refused.

use std::path::Path as FilePath;

use lab::Logged;
use lab::card::{self, LogKind};
use serde::{Deserialize, Serialize};
use si::{Hertz, Newton};
use signal::wave::{self, StillWater};

use diagnostics::{Diagnostic, Result};
use records::subject::Specimen;
use workflow::stage::{RawFile, Stage, StageContext};
use workflow::subject::Part;

/// The stage.
pub struct Tank;

/// `[tank]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Number of standing waves that are looked for.
    modes: u32,
    /// Level of significance at which any wave is reported.
    level: f64,
    /// Largest amplitude of a line in water that is still, N.
    still_limit: Newton,
}

/// What it reads of the card.
#[derive(Debug, Serialize)]
pub struct Card {
    tank: Option<card::Tank>,
    log: card::Log,
}

impl Part<Specimen> for Card {
    fn part_of(of: &Specimen) -> Self {
        Self { tank: of.card.tank, log: of.card.log.clone() }
    }
}

impl Stage for Tank {
    type Settings = Settings;
    type Card = Card;
    type Needs = ();
    type Makes = records::Tank;
    const DESCRIPTION: &'static str = "the tank's standing waves are identified in water at rest";
    const VERSION: u32 = 5;

    fn raw(of: &Specimen) -> Vec<RawFile> {
        let still = of.card.fixture.iter().filter(|f| records::is_still_water(f));
        still.take(1).map(|f| RawFile::new("still water", &of.card.name, &f.force)).collect()
    }

    fn run(card: &Card, set: &Settings, (): (), context: &dyn StageContext) -> Result<records::Tank> {
        let Logged { log, sampling } = read_force("still water", (LogKind::Force, &card.log), context)?;
        let size = card.tank.ok_or_else(no_tank)?;
        let expected: Vec<Hertz> =
            (1..=set.modes).map(|n| wave::natural_frequency(size.length, size.depth, n)).collect();
        let still = StillWater { expected: &expected, level: set.level, limit: set.still_limit };
        let identified = wave::identify(&log.series(), &still)
            .map_err(|e| Diagnostic::from(e).in_file(FilePath::new(&context.display_path("still water"))))?;
        Ok(records::Tank {
            waves: identified.waves,
            evidence: identified.evidence,
            level: set.level,
            noise: identified.noise,
            suppression_db: identified.suppression_db,
            size_m: [size.length, size.depth],
            sampling,
        })
    }
}

fn no_tank() -> Diagnostic {
    let purpose = "its size gives the frequencies of its standing waves";
    Diagnostic::new("the card has no [tank]", purpose, "add [tank] with length and depth (m) to specimen.toml")
}

/// The file of the load cell's log of taps.
pub(super) const TAPS: &str = "taps";

/// A force log of the context.
pub(super) fn read_force(
    word: &str,
    layout: (LogKind, &card::Log),
    context: &dyn StageContext,
) -> Result<Logged<lab::ForceLog>> {
    let log_path = context.display_path(word);
    let text = lab::log::decoded(context.bytes(word)?, FilePath::new(&log_path))?;
    match word {
        TAPS => lab::force::parse_taps(&text, FilePath::new(&log_path), layout.1),
        _ => lab::force::parse_as(&text, FilePath::new(&log_path), layout),
    }
}
