//! Thrust: from what moved and what was weighed to models of thrust, from the mean to a network. Paper: section V, table II.
//!
//! Staircases under water give the static cross-talk of pressure, which is taken out; the fixture's ringing is undone; what is
//! left is what every rung of the ladder is fitted to and judged by, on the same runs.
//!
//! Stands on: the room `thrust`, `gather`. Never knows: how a rung works.

mod gather;

use fit::network::Training;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use si::{Hertz, KilogramPerCubicMetre, Second};

use crate::fault::{Fault, Outcome};
use crate::needs::Maybe;
use crate::records::{Crosstalk, LoadCell, Means, Mesh, Scored, Thrust as Record, Trace};
use crate::stage::{Desk, Stage};
use crate::subject::{Specimen, Trial};
use crate::thrust::outline::Outline;
use crate::thrust::rungs::linear::Weighted;
use crate::thrust::score::score;
use crate::thrust::{Fitted, LADDER, Lesson, Run, Rung, splits};
use gather::{Apparatus, Weighed};

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
    /// Marks and pressures are smoothed below, Hz.
    smooth: Hertz,
    /// Whether the fixture's ringing is undone before learning.
    undo: bool,
    /// Weight of the inverse: noise power over signal power.
    undo_weight: f64,
    /// Forces are expected to be slower, Hz.
    undo_smooth: Hertz,
    /// Lags tried for the cross-talk, from 0, s.
    lags: Vec<Second>,
    /// Beats left out at the start of a run.
    settle_beats: f64,
    /// Hidden units of the network.
    hidden: Vec<usize>,
    /// Step of Adam.
    step: f64,
    /// Samples in a batch.
    batch: usize,
    /// Passes through all samples, at most.
    epochs: usize,
    /// Epochs without a better error on training runs set aside.
    patience: usize,
    /// Share of the training runs set aside.
    aside: f64,
    /// Hidden units of the network that learns what theory leaves.
    rest_hidden: Vec<usize>,
    /// The networks' seeds; the first counts, the others show the spread.
    seeds: Vec<u64>,
}

impl Settings {
    /// What the network is taught by, and with which first weights.
    pub(super) fn lesson(&self, seed: u64) -> Lesson {
        let (hidden, step, batch) = (self.hidden.clone(), self.step as f32, self.batch.max(1));
        let training = Training { hidden, step, batch, epochs: self.epochs, patience: self.patience, seed };
        Lesson { training, aside: self.aside, rest_hidden: self.rest_hidden.clone() }
    }

    /// The networks' seeds, at least one.
    pub(super) fn seeds(&self) -> &[u64] {
        if self.seeds.is_empty() { &[1] } else { &self.seeds }
    }
}

impl Stage for Thrust {
    type Settings = Settings;
    type Needs = (Mesh, Maybe<LoadCell>, Weighed);
    type Makes = Record;
    const STORY: &'static str = "motion and pressure learn to tell thrust";
    const EDITION: u32 = 3;

    fn card(of: &Specimen) -> Value {
        let trial =
            |t: &Trial| json!([t.trial.id, format!("{:?}", t.trial.experiment), t.trial.split.map(|s| s.word())]);
        let trials: Vec<Value> = of.trials().iter().filter(|t| t.is_weighed_in_water()).map(trial).collect();
        let markers: Vec<_> = of.card.marker.iter().map(|m| m.at).collect();
        json!({ "clamp": of.card.clamp.below_x, "markers": markers, "trials": trials })
    }

    fn run(of: &Specimen, set: &Settings, needs: Self::Needs, desk: &dyn Desk) -> Outcome<Record> {
        let (mesh, Maybe(cell), weighed) = needs;
        let tail = Outline::new(&of.card, &mesh.solid).marked(set.density, set.sections).map_err(Fault::from_tool)?;
        let apparatus = Apparatus::of(&weighed, cell.as_ref(), set)?;
        let (runs, taken) = weighed.runs(&tail, &apparatus, set)?;
        let (scores, models) = ladder(&runs, set, desk)?;
        let network = match models.iter().find(|(rung, _)| *rung == Rung::Network) {
            Some((_, Fitted::Network(network))) => network.to_safetensors().map_err(Fault::from_tool)?,
            _ => Vec::new(),
        };
        let coefficients = match models.iter().find(|(rung, _)| *rung == Rung::Theory) {
            Some((_, Fitted::Weighted(Weighted { weights, .. }))) => weights.clone(),
            _ => Vec::new(),
        };
        let talk = apparatus.talk;
        let crosstalk =
            Crosstalk { pressures_pa: talk.pressures, forces_n: talk.forces, lag_s: talk.lag, left_n: talk.left };
        let (means, traces) = (means(&runs, &taken, &models), traces(&runs, &models));
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

type Models = Vec<(Rung, Fitted)>;

/// Every rung on every parting; the models of the card's parting and first seed are kept.
fn ladder(runs: &[Run], set: &Settings, desk: &dyn Desk) -> Outcome<(Vec<Scored>, Models)> {
    let (mut scores, mut models) = (Vec::new(), Vec::new());
    let seeds = set.seeds();
    for (number, parting) in splits::ALL.into_iter().enumerate() {
        let Some((train, test)) = parting.part(runs) else { continue };
        for rung in LADDER {
            let learns = matches!(rung, Rung::Network | Rung::Hybrid);
            let tried = if learns && number == 0 { seeds.len() } else { 1 };
            for (place, seed) in seeds.iter().take(tried).enumerate() {
                let said = format!("{} on {}", rung.name(), parting.name());
                let progress = |part: f64| desk.progress((number as f64 + part) / splits::ALL.len() as f64, &said);
                let model = rung.fit(&train, &set.lesson(*seed), &progress);
                let told: Vec<Vec<f64>> = test.iter().map(|r| model.tell(r)).collect();
                scores.push(Scored {
                    parting: parting.name().into(),
                    rung: rung.name().into(),
                    seed: place as u64,
                    score: score(&test, &told),
                    runs: [train.len(), test.len()],
                });
                if number == 0 && place == 0 {
                    models.push((rung, model));
                }
            }
        }
    }
    match models.is_empty() {
        false => Ok((scores, models)),
        true => {
            Err(Fault::new("no run is left to judge thrust by", "the card's splits hold no beating trial", "add one"))
        }
    }
}

fn told(models: &Models, rung: Rung, run: &Run) -> Vec<f64> {
    models.iter().find(|(of, _)| *of == rung).map_or_else(Vec::new, |(_, model)| model.tell(run))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn means(runs: &[Run], taken: &[f64], models: &Models) -> Vec<Means> {
    let held = runs.iter().zip(taken).filter(|(r, _)| r.split == Some(lab::card::Split::Test));
    let one = |(run, taken): (&Run, &f64)| Means {
        run: run.id.clone(),
        amplitude_pa: run.amplitude,
        frequency_hz: run.frequency,
        measured_n: mean(&run.force),
        theory_n: mean(&told(models, Rung::Ebt, run)),
        network_n: mean(&told(models, Rung::Network, run)),
        crosstalk_n: *taken,
    };
    held.map(one).collect()
}

/// The longest that a trace shows, in beats.
const SHOWN: f64 = 4.0;

/// Of the runs learnt from and of those held out, the one with the most thrust.
fn traces(runs: &[Run], models: &Models) -> Vec<Trace> {
    use lab::card::Split;
    let most = |split: Split| {
        let of = runs.iter().filter(|r| r.split == Some(split));
        of.max_by(|a, b| mean(&a.force).total_cmp(&mean(&b.force)))
    };
    let one = |run: &Run| {
        let shown = ((SHOWN * run.beat() as f64) as usize).min(run.len());
        let cut = |mut values: Vec<f64>| {
            values.truncate(shown);
            values
        };
        Trace {
            run: run.id.clone(),
            learnt: run.split == Some(Split::Train),
            time: cut(run.time.clone()),
            moved: cut(run.moved.iter().filter_map(|m| m.last()).map(|p| p[1]).collect()),
            measured: cut(run.force.clone()),
            theory: cut(told(models, Rung::Ebt, run)),
            network: cut(told(models, Rung::Network, run)),
        }
    };
    [Split::Train, Split::Test].into_iter().filter_map(most).map(one).collect()
}
