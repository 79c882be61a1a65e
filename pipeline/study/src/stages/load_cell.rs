//! Load cell: hammer taps give the transfer function of its fixture; its inverse is applied to an example. Paper: appendix, load cell dynamics.
//!
//! The example is a non-negative thrust whose measurement goes below zero through the fixture's ringing, as in the paper.

use std::path::Path;

use lab::Logged;
use lab::card::{Fixture, FixtureOf, LogKind};
use serde::{Deserialize, Serialize};
use si::{Hertz, Newton};
use signal::cell::{ExampleThrust, Regularisation, identify_from_taps};

use super::tank::{TAPS, read_force};
use diagnostics::{Diagnostic, Result};
use records::subject::Specimen;
use workflow::stage::{RawFile, Stage, StageContext};
use workflow::subject::Part;

/// The stage.
pub struct LoadCell;

/// `[load_cell]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Lowest and highest frequency of the fitted response, Hz.
    band: [Hertz; 2],
    /// Regularisation weight of the inverse: noise power over signal power, no unit.
    weight: f64,
    /// Cut-off frequency: forces are assumed to be slower, Hz.
    cutoff: Hertz,
    /// Flapping frequency of the example thrust, Hz.
    example_frequency: Hertz,
    /// Its peak, N.
    example_peak: Newton,
}

/// What it reads of the card.
#[derive(Debug, Serialize)]
pub struct Card {
    /// Number of taps, where the card has it.
    count: Option<usize>,
    /// How the logs are written.
    log: lab::card::Log,
}

impl Part<Specimen> for Card {
    fn part_of(of: &Specimen) -> Self {
        let count = |fixture: &Fixture| match fixture.of {
            FixtureOf::Taps { count, .. } => Some(count),
            FixtureOf::StillWater => None,
        };
        Self { count: of.card.fixture.iter().find_map(count).flatten(), log: of.card.log.clone() }
    }
}

impl Stage for LoadCell {
    type Settings = Settings;
    type Card = Card;
    type Needs = ();
    type Makes = records::LoadCell;
    const DESCRIPTION: &'static str = "hammer taps give the transfer function of the load cell's fixture";
    const VERSION: u32 = 7;

    fn raw(of: &Specimen) -> Vec<RawFile> {
        let name = &of.card.name;
        let taps = of.card.fixture.iter().filter_map(|f| match &f.of {
            FixtureOf::Taps { hammer, .. } => {
                Some([RawFile::new(TAPS, name, &f.force), RawFile::new("hammer", name, hammer)])
            }
            FixtureOf::StillWater => None,
        });
        taps.take(1).flatten().collect()
    }

    fn run(card: &Card, set: &Settings, (): (), context: &dyn StageContext) -> Result<records::LoadCell> {
        let Logged { log: measured, sampling } = read_force(TAPS, (LogKind::Force, &card.log), context)?;
        let hammer = read_force("hammer", (LogKind::Hammer, &card.log), context)?.log;
        let taps_path = context.display_path("taps");
        let identified = identify_from_taps(&hammer.series(), &measured.series(), set.band)
            .map_err(|e| Diagnostic::from(e).in_file(Path::new(&taps_path)))?;
        if let Some(count) = card.count.filter(|count| *count != identified.taps) {
            let counted = format!("{} taps are found in the hammer's log", identified.taps);
            let expected = format!("the card has count = {count}; a log that was cut has fewer");
            return Err(Diagnostic::file(
                Path::new(&taps_path),
                counted,
                expected,
                "copy the logs again, or correct the card",
            ));
        }
        let pushes = ExampleThrust { frequency: set.example_frequency, peak: set.example_peak };
        let regularisation = Regularisation { weight: set.weight, corner: set.cutoff };
        let example = pushes.deconvolved(&identified.in_time.cell, (measured.rate(), identified.noise), regularisation);
        Ok(records::LoadCell {
            in_time: identified.in_time.into(),
            in_frequency: identified.in_frequency.into(),
            taps: identified.taps,
            noise: identified.noise,
            response: identified.response,
            sampling,
            example,
        })
    }
}
