//! Reduce: hyper-reduction of the identified model (POD of shapes under pressure and lateral loads, with empirical cubature).
//!
//! Every predicted motion (a release, flapping in air and in water, optimal actuation) is integrated in these coordinates. The
//! snapshots extend to the highest pressure of identification and of the predicted motions, in the chambers that a trial fills.

use lab::card::Experiment;
use serde::{Deserialize, Serialize};
use si::{Hertz, Pascal};

use diagnostics::Result;
use records::subject::{Specimen, Trial};
use records::{Identified, Level, Mesh, Reduced};
use sysid::{Body, Reduction, Snapshots, Stroke};
use workflow::stage::{Stage, StageContext};
use workflow::subject::Part;

/// The stage.
pub struct Reduce;

/// `[reduce]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Tolerance of the empirical cubature: relative error of the displacements over all snapshots, no unit.
    tolerance: f64,
}

/// What it reads of the card.
#[derive(Debug, Serialize)]
pub struct Card {
    body: Body,
    chambers: usize,
    /// The chambers that no trial fills.
    idle: Vec<usize>,
    /// The highest commanded pressure of the predicted motions, Pa; 0 where none is.
    commanded: Pascal,
    /// The slowest of them, Hz; none where there are none.
    frequency: Option<Hertz>,
}

impl Part<Specimen> for Card {
    fn part_of(of: &Specimen) -> Self {
        Self {
            body: Body::of(&of.card),
            chambers: of.card.chamber.len(),
            idle: idle_chambers(of),
            commanded: highest_command(of),
            frequency: slowest_flap(of),
        }
    }
}

impl Stage for Reduce {
    type Settings = Settings;
    type Card = Card;
    type Needs = (Mesh, Identified);
    type Makes = Reduced;
    const DESCRIPTION: &'static str = "the identified model is reduced to a few dozen coordinates";
    const VERSION: u32 = 13;

    fn run(
        card: &Self::Card,
        set: &Settings,
        (mesh, identified): Self::Needs,
        context: &dyn StageContext,
    ) -> Result<Reduced> {
        let model = mesh.model(&card.body)?;
        let highest_identified = identified.levels.iter().map(Level::pressure).fold(0.0, f64::max);
        let top = highest_identified.max(card.commanded);
        context.progress(0.1, "snapshots under pressures and loads, and of a stroke");
        let tops: Vec<Pascal> = (0..card.chambers).map(|k| if card.idle.contains(&k) { 0.0 } else { top }).collect();
        let elastic = identified.elastic(&model);
        let stroke = card.frequency.map(|frequency| Stroke { amplitude: card.commanded, frequency });
        let snapshots = Snapshots { model: &model, elastic: &elastic, top: &tops, length: card.body.length, stroke };
        let Reduction { data, contact } = snapshots.reduce(set.tolerance)?;
        Ok(Reduced { data, highest: top, contact })
    }
}

/// The chambers that no trial fills: no motion of theirs is predicted, and each would take as many equilibria as one that is filled.
pub(crate) fn idle_chambers(specimen: &Specimen) -> Vec<usize> {
    let fills = |channel: &String| specimen.trials().iter().any(|t| t.trial.experiment.channels().contains(channel));
    let chambers = specimen.card.chamber.iter().enumerate();
    chambers.filter(|(_, chamber)| !fills(&chamber.channel)).map(|(k, _)| k).collect()
}

/// The lowest commanded frequency of the predicted motions, Hz; none where there are none.
fn slowest_flap(specimen: &Specimen) -> Option<Hertz> {
    let frequency = |trial: &Trial| match trial.trial.experiment {
        Experiment::Flapping { frequency, .. } => Some(frequency),
        Experiment::Staircase { .. } => None,
    };
    specimen.trials().iter().filter(|t| t.is_for_validation()).filter_map(frequency).min_by(f64::total_cmp)
}

/// The highest commanded pressure of the predicted motions, Pa; 0 where none is.
fn highest_command(specimen: &Specimen) -> Pascal {
    let highest_of_trial = |trial: &Trial| match trial.trial.experiment {
        Experiment::Flapping { amplitude, .. } => amplitude,
        Experiment::Staircase { .. } => trial.trial.experiment.highest_level().unwrap_or(0.0),
    };
    specimen.trials().iter().filter(|t| t.is_for_validation()).map(highest_of_trial).fold(0.0, f64::max)
}
