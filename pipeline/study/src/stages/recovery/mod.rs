//! Recovery: errors of the pipeline's estimates against the hidden truth of the virtual bench. The one stage that may read it.

mod films;
mod forces;
mod walls;

use std::path::Path;

use lab::card::Origin;
use lab::truth::{self, TrueTrack};
use serde::{Deserialize, Serialize};
use si::Second;

use self::films::{Films, frame_at, judge_films};
use self::forces::judge_forces;
use self::walls::wall_comparison;
use diagnostics::{Diagnostic, Result};
use records::subject::{Specimen, Study, condition_of};
use records::{
    Camera, CorrectedForce, Drag, Estimate, Identified, Inflation, Interval, LoadCell, Quantity, REPORTED, Recovered,
    RecoveredSpecimen, Relaxation, Tank, Validation,
};
use sysid::relaxation::dynamic_modulus;
use workflow::needs::Every;
use workflow::stage::{RawFile, Stage, StageContext};
use workflow::subject::{Name, Part};

/// The stage.
pub struct Recovery;

/// Identified parameters of the specimens: elasticity, relaxation, water.
type Parameters = (Every<Identified>, Every<Relaxation>, Every<Drag>);

/// What the identified models predict.
type Predictions = (Every<Validation>, Every<Inflation>);

/// `[recovery]` in `study.toml`: nothing to set.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {}

/// What it reads of the cards: the specimens of the virtual bench, whose truth is known.
#[derive(Debug, Serialize)]
#[serde(transparent)]
pub struct Card(Vec<Virtual>);

/// A specimen of the virtual bench.
#[derive(Debug, Serialize)]
struct Virtual {
    name: String,
    trials: Vec<String>,
    /// The fixture's recording of water at rest.
    still_water: Option<String>,
    /// The channel in which the identified model is inflated.
    inflated: Option<String>,
}

impl Part<Study> for Card {
    fn part_of(of: &Study) -> Self {
        Self(virtual_specimens(of).map(Virtual::of_card).collect())
    }
}

impl Virtual {
    fn of_card(specimen: &Specimen) -> Self {
        let still = specimen.card.fixture.iter().find(|f| f.of == lab::card::FixtureOf::StillWater);
        Self {
            name: specimen.card.name.clone(),
            trials: specimen.card.trial.iter().map(|t| t.id.clone()).collect(),
            still_water: still.map(|f| f.id.clone()),
            inflated: specimen.highest_staircase().and_then(|t| t.trial.experiment.channels().first().cloned()),
        }
    }

    /// The subject of one of its trials.
    fn trial_subject(&self, trial: &str) -> Name {
        Name(format!("{}/{trial}", self.name))
    }
}

impl Stage for Recovery {
    type Settings = Settings;
    type Card = Card;
    type Needs =
        ((Every<Camera>, Films, (Parameters, Predictions)), (Every<LoadCell>, Every<Tank>, Every<CorrectedForce>));
    type Makes = Recovered;
    const DESCRIPTION: &'static str = "estimates are compared with the hidden truth";
    const VERSION: u32 = 11;

    fn raw(of: &Study) -> Vec<RawFile> {
        virtual_specimens(of).flat_map(truth_files).collect()
    }

    fn run(card: &Self::Card, _: &Settings, needs: Self::Needs, context: &dyn StageContext) -> Result<Recovered> {
        let ((Every(cameras), films, (parameters, (Every(predictions), Every(inflated)))), weighed) = needs;
        let mut recovered = Recovered::default();
        for specimen in &card.0 {
            let truth = read_truth(context, &specimen.name)?;
            let mut estimates = estimates_beside_truth(specimen, &truth, &parameters)?;
            for (_, camera) in cameras.iter().filter(|(s, _)| s.0 == specimen.name) {
                let focal_error = 100.0 * (camera.lens.fx / truth.lens.fx - 1.0).abs();
                recovered.focal_error_percent = recovered.focal_error_percent.max(focal_error);
            }
            judge_forces(&mut recovered, specimen, &truth, &weighed);
            for id in &specimen.trials {
                let Some(true_trial) = truth.trial.iter().find(|t| t.id == *id) else {
                    return Err(no_trial(&specimen.name, id));
                };
                let true_tracks = true_tracks(context, &specimen.name, id)?;
                judge_films(&mut recovered, &specimen.trial_subject(id), (true_trial, &true_tracks), &films);
                let predicted = predictions.iter().filter(|(trial, _)| *trial == specimen.trial_subject(id));
                estimates.extend(
                    predicted
                        .filter_map(|(_, validation)| amplitude_estimate(condition_of(id), validation, &true_tracks)),
                );
            }
            if !estimates.is_empty() {
                let (hidden, walls) = wall_comparison(specimen, &truth, (&parameters.0, &inflated))?;
                recovered.specimens.push(RecoveredSpecimen { name: specimen.name.clone(), estimates, walls, hidden });
            }
        }
        Ok(recovered)
    }
}

/// Estimates of a specimen beside the truth; none where its moduli were not identified.
fn estimates_beside_truth(
    specimen: &Virtual,
    truth: &truth::Truth,
    (Every(identified), Every(relaxed), Every(dragged)): &Parameters,
) -> Result<Vec<Estimate>> {
    let this = |s: &Name| s.0 == specimen.name;
    let Some((_, found)) = identified.iter().find(|(s, _)| this(s)) else { return Ok(Vec::new()) };
    let estimate = |quantity, found, hidden, sigma| Estimate { quantity, found, hidden, sigma };
    let real = true_relaxation(&truth.body)?;
    let relaxed_modulus = truth.body.youngs_modulus * real.modulus(found.modulus_time);
    let relative = |k: usize| found.sigma[k] / found.best[k];
    let modulus = |k: usize| found.uncertainty.mesh_correction(k) * found.best[k];
    let mut estimates = vec![
        estimate(Quantity::BodyModulus, modulus(0), relaxed_modulus, relative(0)),
        estimate(Quantity::SpineModulus, modulus(1), truth.spine.youngs_modulus, relative(1)),
    ];
    for (_, relaxation) in relaxed.iter().filter(|(s, _)| this(s)) {
        for frequency in REPORTED {
            let (found, sigma) = (relaxation.spectrum.at(frequency)?, relaxation.spectrum.sigma_at(frequency)?);
            let real = dynamic_modulus(&real, frequency, relaxation.spectrum.modulus_time_s);
            let quantities = [Quantity::StorageRatio(frequency), Quantity::LossFactor(frequency)];
            estimates.extend(
                quantities.into_iter().enumerate().map(|(k, q)| estimate(q, found[k], real[k], sigma[k] / found[k])),
            );
        }
    }
    for ((_, Drag { by, sigma, .. }), hidden) in dragged.iter().filter(|(s, _)| this(s)).zip(&truth.fluid) {
        estimates.push(estimate(Quantity::AddedMass, by.added, hidden.added, sigma.added / by.added));
        estimates.push(estimate(Quantity::NormalDrag, by.drag, hidden.drag, sigma.drag / by.drag));
    }
    Ok(estimates)
}

/// The predicted amplitude of the tip in a validation trial beside the true one, whose tracks are given.
fn amplitude_estimate(condition: String, validation: &Validation, tracks: &[TrueTrack]) -> Option<Estimate> {
    let track = tracks.iter().find(|track| track.marker == validation.marker)?;
    let lateral = |t: &Second| track.at[frame_at(&track.time, *t)][1] - track.at[0][1];
    let squares: f64 = validation.time.iter().map(|t| lateral(t).powi(2)).sum();
    let hidden = (squares / validation.time.len().max(1) as f64).sqrt();
    let Interval { value, sigma } = validation.amplitude;
    Some(Estimate { quantity: Quantity::TipAmplitude(condition), found: value, hidden, sigma })
}

/// The true relaxation.
fn true_relaxation(properties: &truth::Properties) -> Result<fem::Relaxation> {
    let branches: Vec<fem::Branch> =
        properties.branch.iter().map(|b| fem::Branch { strength: b.strength, time: b.time }).collect();
    fem::Relaxation::maxwell(&branches).map_err(Diagnostic::from)
}

fn virtual_specimens(study: &Study) -> impl Iterator<Item = &Specimen> {
    study.specimens.iter().filter(|s| s.card.origin == Origin::VirtualBench)
}

/// The truth's file, and one file of true tracks a trial.
fn truth_files(specimen: &Specimen) -> Vec<RawFile> {
    let name = &specimen.card.name;
    let tracks =
        specimen.card.trial.iter().map(|t| RawFile::new(&tracks_word(name, &t.id), name, &tracks_place(&t.id)));
    std::iter::once(RawFile::new(&truth_word(name), name, lab::folder::TRUTH)).chain(tracks).collect()
}

fn truth_word(specimen: &str) -> String {
    format!("truth of {specimen}")
}

fn tracks_word(specimen: &str, trial: &str) -> String {
    format!("true tracks of {specimen}/{trial}")
}

fn tracks_place(trial: &str) -> String {
    format!("truth/{trial}.csv")
}

fn read_truth(context: &dyn StageContext, specimen: &str) -> Result<truth::Truth> {
    let (text, path) = read_text(context, &truth_word(specimen))?;
    truth::parse(&text, Path::new(&path))
}

fn read_text(context: &dyn StageContext, word: &str) -> Result<(String, String)> {
    let path = context.display_path(word);
    let text = String::from_utf8(context.bytes(word)?);
    let text = text.map_err(|e| Diagnostic::new(format!("{path} is not text"), e, "record the specimen again"))?;
    Ok((text, path))
}

fn true_tracks(context: &dyn StageContext, specimen: &str, trial: &str) -> Result<Vec<TrueTrack>> {
    let (text, path) = read_text(context, &tracks_word(specimen, trial))?;
    truth::parse_tracks(&text, Path::new(&path))
}

fn no_trial(specimen: &str, trial: &str) -> Diagnostic {
    Diagnostic::new(
        format!("the truth has no trial `{trial}`"),
        "card and truth of a virtual specimen are written together",
        format!("rig record {specimen}"),
    )
}
