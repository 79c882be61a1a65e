//! Thrust: from what moved and what was weighed to models of thrust, from the mean to a network. Paper: section V, table II.
//!
//! Staircases under water give the static cross-talk of pressure, which is taken out; the fixture's ringing is undone; what is
//! left is what every rung of the ladder is fitted to and judged by, on the same runs.
//!
//! Stands on: the room `thrust`, signal. Never knows: how a rung works.

use fit::network::Training;
use hydro::Tail;
use lab::card::Experiment;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use si::{Hertz, KilogramPerCubicMetre, Pascal, Point2, Second, Series};
use signal::cell::Regularised;
use signal::crosstalk::{self, CrossTalk, Still};
use signal::resample::Samples;
use signal::smooth;

use crate::fault::{Fault, Outcome};
use crate::needs::{Maybe, OfTrials};
use crate::records::{Crosstalk, LoadCell, Means, Mesh, Motion, Pull, Scored, Thrust as Record, Trace};
use crate::stage::{Desk, Stage};
use crate::subject::{Scope, Specimen, Trial};
use crate::thrust::outline::{Outline, order};
use crate::thrust::rungs::linear::Weighted;
use crate::thrust::score::score;
use crate::thrust::{Fitted, LADDER, Lesson, Run, Rung, run, splits};

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
        let talk = talk(&weighed.0, set)?;
        let mut runs = Vec::new();
        for (trial, motion, pull) in &weighed.0 {
            runs.extend(gathered(trial, motion, pull, &tail, &talk, cell.as_ref(), set)?);
        }
        let runs: Vec<(Run, f64)> = runs;
        let (runs, taken): (Vec<Run>, Vec<f64>) = runs.into_iter().unzip();
        let (scores, models) = ladder(&runs, set, desk)?;
        let network = match models.iter().find(|(rung, _)| *rung == Rung::Network) {
            Some((_, Fitted::Network(network))) => network.to_safetensors().map_err(Fault::from_tool)?,
            _ => Vec::new(),
        };
        let coefficients = match models.iter().find(|(rung, _)| *rung == Rung::Theory) {
            Some((_, Fitted::Weighted(Weighted { weights, .. }))) => weights.clone(),
            _ => Vec::new(),
        };
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

/// Motion and force of every trial weighed in water.
pub struct Weighed(Vec<(Trial, Motion, Pull)>);

impl crate::needs::Needs<Specimen> for Weighed {
    fn wanted(of: &Specimen) -> Vec<crate::needs::Id> {
        let both = |t: &Trial| [crate::needs::id::<Motion>(t), crate::needs::id::<Pull>(t)];
        of.trials().iter().filter(|t| t.is_weighed_in_water()).flat_map(both).collect()
    }

    fn fetch(of: &Specimen, shelf: &dyn crate::needs::Shelf) -> Outcome<Self> {
        let OfTrials(pulls) = OfTrials::<Pull>::fetch(of, shelf)?;
        let one = |(trial, pull): (Trial, Pull)| {
            let motion = <Motion as crate::needs::Needs<Trial>>::fetch(&trial, shelf)?;
            Ok((trial, motion, pull))
        };
        Ok(Self(pulls.into_iter().map(one).collect::<Outcome<_>>()?))
    }
}

fn gauges(motion: &Motion) -> Outcome<Vec<Samples>> {
    let samples = motion.gauges.iter().map(|g| Samples::new(motion.log_time.clone(), g.measured.clone()));
    samples.collect::<Result<_, _>>().map_err(Fault::from_tool)
}

/// The static cross-talk from the staircases; none where there is no staircase.
fn talk(weighed: &[(Trial, Motion, Pull)], set: &Settings) -> Outcome<CrossTalk> {
    let mut knots: Vec<Pascal> = vec![0.0];
    let mut runs = Vec::new();
    for (trial, motion, pull) in weighed {
        if let Experiment::Staircase { levels, .. } = &trial.trial.experiment {
            knots.extend(levels);
            runs.push(Still { force: pull.force(), pressures: gauges(motion)? });
        }
    }
    if runs.is_empty() {
        return Ok(CrossTalk::none());
    }
    knots.sort_by(f64::total_cmp);
    knots.dedup();
    // flapping may press harder than any step was held: the last slope then runs on
    let most = weighed.iter().filter_map(|(t, ..)| match t.trial.experiment {
        Experiment::Flapping { amplitude, .. } => Some(amplitude),
        Experiment::Staircase { .. } => None,
    });
    let most = most.fold(0.0, f64::max);
    let mut found = crosstalk::fit(&runs, &knots, &set.lags).map_err(Fault::from_tool)?;
    let last = knots.len() - 1;
    if most > knots[last] {
        let slope = (found.forces[last] - found.forces[last - 1]) / (knots[last] - knots[last - 1]);
        found.pressures.push(most);
        found.forces.push(found.forces[last] + slope * (most - knots[last]));
    }
    Ok(found)
}

/// A beating trial as a run, with the cross-talk taken out of it on the mean (N); nothing of a staircase.
fn gathered(
    trial: &Trial,
    motion: &Motion,
    pull: &Pull,
    tail: &Tail,
    talk: &CrossTalk,
    cell: Option<&LoadCell>,
    set: &Settings,
) -> Outcome<Option<(Run, f64)>> {
    let Experiment::Flapping { amplitude, frequency, .. } = trial.trial.experiment else { return Ok(None) };
    let gauges = gauges(motion)?;
    let force = pull.force();
    let still: Vec<f64> = pull.time.iter().map(|&t| talk.of(&gauges, t)).collect();
    let clean = force.values().iter().zip(&still).map(|(f, s)| f - s).collect();
    let clean = Series::new(force.start(), force.rate(), clean).map_err(Fault::from_tool)?;
    let clean = match cell {
        Some(cell) if set.undo => {
            let held = Regularised { weight: set.undo_weight, smooth: set.undo_smooth };
            cell.in_time.cell().undo(&clean, cell.noise, held).force
        }
        _ => clean,
    };
    let [first, last] = pull.commanded;
    let first = (first + set.settle_beats / frequency).max(motion.time[0]);
    let last = last.min(motion.time[motion.time.len() - 1]);
    let whole = first + ((last - first) * frequency).floor() / frequency;
    let inside = |i: &usize| (first..whole).contains(&clean.time(*i));
    let samples: Vec<usize> = (0..clean.values().len()).filter(inside).collect();
    if samples.len() < 8 {
        let what = format!("{} has {} samples of force while it beats", trial.name(), samples.len());
        return Err(Fault::new(what, "a run needs at least 8", "record the trial for longer"));
    }
    let time: Vec<Second> = samples.iter().map(|&i| clean.time(i)).collect();
    let specimen = Specimen { card: trial.card.clone() };
    let paths: Vec<[Series; 2]> =
        order(&specimen.card).iter().map(|&m| path(motion, m, set.smooth)).collect::<Outcome<_>>()?;
    let read =
        |of: &[[Series; 2]], t: Second| of.iter().map(|axes| [axes[0].at(t), axes[1].at(t)]).collect::<Vec<Point2>>();
    let quick: Vec<[Series; 2]> = paths.iter().map(|axes| axes.each_ref().map(rate_of)).collect();
    let moved: Vec<Vec<Point2>> = time.iter().map(|&t| read(&paths, t)).collect();
    let speed: Vec<Vec<Point2>> = time.iter().map(|&t| read(&quick, t)).collect();
    let pressed: Vec<Series> = gauges.iter().map(|g| even(g, set.smooth)).collect::<Outcome<_>>()?;
    let pressed_rate: Vec<Series> = pressed.iter().map(rate_of).collect();
    let at = |of: &[Series], t: Second| of.iter().map(|s| s.at(t)).collect::<Vec<f64>>();
    let taken = samples.iter().map(|&i| still[i]).sum::<f64>() / samples.len() as f64;
    let terms = run::parts(tail, &moved, &speed, clean.rate());
    let run = Run {
        id: trial.trial.id.clone(),
        amplitude,
        frequency,
        split: trial.trial.split,
        rate: clean.rate(),
        force: samples.iter().map(|&i| clean.values()[i]).collect(),
        pressure: time.iter().map(|&t| at(&pressed, t)).collect(),
        pressure_rate: time.iter().map(|&t| at(&pressed_rate, t)).collect(),
        time,
        moved,
        speed,
        terms,
    };
    Ok(Some((run, taken)))
}

/// x and y of a marker, smoothed.
fn path(motion: &Motion, marker: usize, cutoff: Hertz) -> Outcome<[Series; 2]> {
    let axis = |k: usize| {
        let values = motion.markers[marker].at.iter().map(|p| p[k]).collect();
        let samples = Samples::new(motion.time.clone(), values).map_err(Fault::from_tool)?;
        even(&samples, cutoff)
    };
    Ok([axis(0)?, axis(1)?])
}

fn even(samples: &Samples, cutoff: Hertz) -> Outcome<Series> {
    let times = samples.times();
    let rate = (times.len() - 1) as f64 / (times[times.len() - 1] - times[0]);
    let even = samples.even(rate).map_err(Fault::from_tool)?;
    smooth::low_pass(&even, cutoff, 2).map_err(Fault::from_tool)
}

fn rate_of(series: &Series) -> Series {
    let rates = run::rates(series.values(), series.rate());
    Series::new(series.start(), series.rate(), rates).expect("differences of finite values")
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
