//! Thrust: thrust models, from the mean to a network, are trained on motion, pressure and force. Paper: section V, table II.
//!
//! Staircases under water give the static cross-talk of pressure, which is subtracted; the fixture's response is deconvolved; every
//! model is fitted to and evaluated on the resulting force of the same runs.

mod gather;

use optimize::network::Training;
use serde::{Deserialize, Serialize};
use si::{Hertz, KilogramPerCubicMetre, Second};

use ::thrust::models::linear::Weighted;
use ::thrust::outline::Outline;
use ::thrust::score::score;
use ::thrust::{Fitted, MODELS, Run, ThrustModel, TrainingSettings, splits};
use diagnostics::{Diagnostic, Result};
use gather::{Apparatus, TrialsWithForce};
use records::{Crosstalk, LoadCell, Means, Mesh, Scored, Thrust as Record, Trace};
use sysid::Body;
use workflow::needs::Maybe;
use workflow::stage::{Stage, StageContext};

/// The stage.
pub struct Thrust;

/// `[thrust]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Density of the water, kg/m³.
    density: KilogramPerCubicMetre,
    /// Sections of the tail in theory.
    sections: usize,
    /// Cut-off frequency of the smoothing of markers and pressures, Hz.
    cutoff: Hertz,
    /// Whether the fixture's response is deconvolved before training.
    deconvolve: bool,
    /// Regularisation weight of the inverse: noise power over signal power.
    deconvolution_weight: f64,
    /// Cut-off frequency: forces are assumed to be slower, Hz.
    deconvolution_cutoff: Hertz,
    /// Candidate lags of the cross-talk, from 0, s.
    lags: Vec<Second>,
    /// Settling cycles left out at the start of a run.
    settling_cycles: f64,
    /// Hidden units of the network.
    hidden_layers: Vec<usize>,
    /// Step of Adam.
    step: f64,
    /// Samples in a batch.
    batch: usize,
    /// Passes through all samples, at most.
    epochs: usize,
    /// Patience of early stopping: epochs without a better error on the validation part.
    patience: usize,
    /// Fraction of the training runs used for early stopping.
    validation_fraction: f64,
    /// Hidden units of the network that is trained on theory's residual.
    residual_hidden_layers: Vec<usize>,
    /// Seeds of the networks; the first is reported, the others give the spread.
    seeds: Vec<u64>,
}

impl Settings {
    /// Training settings of a network, with the seed of its initial weights.
    pub(super) fn training_settings(&self, seed: u64) -> TrainingSettings {
        let (hidden, step, batch) = (self.hidden_layers.clone(), self.step as f32, self.batch.max(1));
        let training = Training { hidden, step, batch, epochs: self.epochs, patience: self.patience, seed };
        TrainingSettings {
            training,
            validation_fraction: self.validation_fraction,
            residual_hidden_layers: self.residual_hidden_layers.clone(),
        }
    }

    /// The networks' seeds, at least one.
    pub(super) fn network_seeds(&self) -> &[u64] {
        if self.seeds.is_empty() { &[1] } else { &self.seeds }
    }
}

impl Stage for Thrust {
    type Settings = Settings;
    type Card = Body;
    type Needs = (Mesh, Maybe<LoadCell>, TrialsWithForce);
    type Makes = Record;
    const DESCRIPTION: &'static str = "thrust models are trained on motion and pressure";
    const VERSION: u32 = 7;

    fn run(card: &Self::Card, set: &Settings, needs: Self::Needs, context: &dyn StageContext) -> Result<Record> {
        let (mesh, Maybe(cell), trials) = needs;
        let tail = Outline::new(card, &mesh.solid).marker_tail(set.density, set.sections)?;
        let apparatus = Apparatus::from_staircases(&trials, cell.as_ref(), card.markers_by_x(), set)?;
        let (runs, taken) = trials.flapping_runs(&tail, &apparatus)?;
        let (scores, models) = fit_models(&runs, set, context)?;
        let network = match models.iter().find(|(model, _)| *model == ThrustModel::Network) {
            Some((_, Fitted::Network(network))) => network.to_safetensors()?,
            _ => Vec::new(),
        };
        let coefficients = match models.iter().find(|(model, _)| *model == ThrustModel::Theory) {
            Some((_, Fitted::Weighted(Weighted { weights, .. }))) => weights.clone(),
            _ => Vec::new(),
        };
        let talk = apparatus.talk;
        let crosstalk = Crosstalk {
            pressures_pa: talk.pressures,
            forces_n: talk.forces,
            lag_s: talk.lag,
            lag_interval_s: talk.lag_interval,
            left_n: talk.residual,
        };
        let (means, traces) = (means_of_runs(&runs, &taken, &models), example_traces(&runs, &models));
        Ok(Record {
            scores,
            means,
            traces,
            crosstalk,
            coefficients,
            network,
            runs,
            density: set.density,
            sections: set.sections,
        })
    }
}

type Models = Vec<(ThrustModel, Fitted)>;

/// Every model on every split; models of the card's split and the first seed are kept.
fn fit_models(runs: &[Run], set: &Settings, context: &dyn StageContext) -> Result<(Vec<Scored>, Models)> {
    let (mut scores, mut models) = (Vec::new(), Vec::new());
    let seeds = set.network_seeds();
    for (number, split_rule) in splits::ALL.into_iter().enumerate() {
        let Some((train, test)) = split_rule.part(runs) else { continue };
        for kind in MODELS {
            let learns = matches!(kind, ThrustModel::Network | ThrustModel::Hybrid);
            let tried = if learns && number == 0 { seeds.len() } else { 1 };
            for (seed_number, seed) in seeds.iter().take(tried).enumerate() {
                let text = format!("{} on {}", kind.name(), split_rule.name());
                let progress = |part: f64| context.progress((number as f64 + part) / splits::ALL.len() as f64, &text);
                let model = kind.fit(&train, &set.training_settings(*seed), &progress);
                let predicted: Vec<Vec<f64>> = test.iter().map(|r| model.predict(r)).collect();
                scores.push(Scored {
                    split_rule: split_rule.name().into(),
                    model: kind.name().into(),
                    seed: seed_number as u64,
                    score: score(&test, &predicted),
                    runs: [train.len(), test.len()],
                });
                if number == 0 && seed_number == 0 {
                    models.push((kind, model));
                }
            }
        }
    }
    match models.is_empty() {
        false => Ok((scores, models)),
        true => Err(Diagnostic::new(
            "no held-out run is left to evaluate thrust models",
            "the card's splits hold no flapping trial",
            "add one",
        )),
    }
}

fn model_force(models: &Models, model: ThrustModel, run: &Run) -> Vec<f64> {
    models.iter().find(|(kind, _)| *kind == model).map_or_else(Vec::new, |(_, model)| model.predict(run))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn means_of_runs(runs: &[Run], taken: &[f64], models: &Models) -> Vec<Means> {
    let test_runs = runs.iter().zip(taken).filter(|(r, _)| r.split == Some(lab::card::Split::Test));
    let means_of_run = |(run, taken): (&Run, &f64)| Means {
        run: run.id.clone(),
        amplitude_pa: run.amplitude,
        frequency_hz: run.frequency,
        measured_n: mean(&run.force),
        theory_n: mean(&model_force(models, ThrustModel::Ebt, run)),
        tuned_n: mean(&model_force(models, ThrustModel::Theory, run)),
        network_n: mean(&model_force(models, ThrustModel::Network, run)),
        crosstalk_n: *taken,
    };
    test_runs.map(means_of_run).collect()
}

/// Length of a trace, in cycles.
const TRACE_CYCLES: f64 = 4.0;

/// Of the training runs and of the held-out runs, the one with the greatest mean thrust.
fn example_traces(runs: &[Run], models: &Models) -> Vec<Trace> {
    use lab::card::Split;
    let run_of_most_thrust = |split: Split| {
        let runs_of_split = runs.iter().filter(|r| r.split == Some(split));
        runs_of_split.max_by(|a, b| mean(&a.force).total_cmp(&mean(&b.force)))
    };
    let trace_of_run = |run: &Run| {
        let samples = ((TRACE_CYCLES * run.samples_per_cycle() as f64) as usize).min(run.len());
        let cut = |mut values: Vec<f64>| {
            values.truncate(samples);
            values
        };
        Trace {
            run: run.id.clone(),
            training: run.split == Some(Split::Train),
            time: cut(run.time.clone()),
            moved: cut(run.moved.iter().filter_map(|m| m.last()).map(|p| p[1]).collect()),
            measured: cut(run.force.clone()),
            theory: cut(model_force(models, ThrustModel::Ebt, run)),
            tuned: cut(model_force(models, ThrustModel::Theory, run)),
            network: cut(model_force(models, ThrustModel::Network, run)),
        }
    };
    [Split::Train, Split::Test].into_iter().filter_map(run_of_most_thrust).map(trace_of_run).collect()
}
