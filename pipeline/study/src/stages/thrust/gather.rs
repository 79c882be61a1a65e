//! Preparation of runs: trials with force in water become the runs that thrust models are trained and evaluated on.
//!
//! Staircases give the static cross-talk of pressure, which is subtracted from the force; the fixture's response is deconvolved; motion
//! and pressure are sampled at the times of the force, over whole cycles.

use hydro::Tail;
use lab::card::{Experiment, Split};
use serde::Serialize;
use si::{Hertz, Newton, Pascal, Point2, Second, Series};
use signal::cell::Regularisation;
use signal::crosstalk::{self, CrossTalk, Staircase};
use signal::resample::{self, Samples};
use signal::smooth;

use super::Settings;
use ::thrust::{Run, run};
use diagnostics::{Diagnostic, Result};
use records::selections::OfTrials;
use records::subject::{Specimen, Trial};
use records::{CorrectedForce, LoadCell, Motion};
use workflow::needs::{Needs, RecordId, RecordReader};
use workflow::subject::Part;

/// Motion and force of every trial with a force log in water.
pub struct TrialsWithForce(Vec<TrialWithForce>);

/// A trial with a force log in water.
struct TrialWithForce {
    card: TrialCard,
    motion: Motion,
    force: CorrectedForce,
}

/// The part of such a trial's card entry that is read.
#[derive(Debug, Clone, Serialize)]
pub(super) struct TrialCard {
    id: String,
    experiment: Experiment,
    split: Option<Split>,
}

impl Part<Trial> for TrialCard {
    fn part_of(of: &Trial) -> Self {
        let lab::card::Trial { id, experiment, split, .. } = of.trial.as_ref().clone();
        Self { id, experiment, split }
    }
}

type Pulls = OfTrials<CorrectedForce, records::selections::Any, TrialCard>;
type Motions = OfTrials<Motion, ForceInWater, TrialCard>;

/// Trials with a force log in water.
struct ForceInWater;

impl records::selections::Selection for ForceInWater {
    fn selects(trial: &Trial) -> bool {
        trial.has_force_in_water()
    }
}

impl Needs<Specimen> for TrialsWithForce {
    fn ids(of: &Specimen) -> Vec<RecordId> {
        [<Motions as Needs<Specimen>>::ids(of), <Pulls as Needs<Specimen>>::ids(of)].concat()
    }

    fn parts(of: &Specimen) -> serde_json::Value {
        <Pulls as Needs<Specimen>>::parts(of)
    }

    fn read(of: &Specimen, reader: &dyn RecordReader) -> Result<Self> {
        let (OfTrials(motions, _), OfTrials(pulls, _)) = (Motions::read(of, reader)?, Pulls::read(of, reader)?);
        let both = pulls.into_iter().zip(motions);
        Ok(Self(both.map(|((card, force), (_, motion))| TrialWithForce { card, motion, force }).collect()))
    }
}

impl TrialsWithForce {
    /// Every flapping trial as a run, and the mean cross-talk subtracted from each, N.
    pub(super) fn flapping_runs(&self, tail: &Tail, apparatus: &Apparatus) -> Result<(Vec<Run>, Vec<Newton>)> {
        let mut runs = Vec::new();
        for trial in &self.0 {
            if let Experiment::Flapping { amplitude, frequency, .. } = trial.card.experiment {
                runs.push(apparatus.gathered_run(trial, [amplitude, frequency], tail)?);
            }
        }
        Ok(runs.into_iter().unzip())
    }
}

/// The measurement chain between tail and force log, and how its signals are processed.
pub(super) struct Apparatus<'a> {
    /// The cross-talk of pressure.
    pub(super) talk: CrossTalk,
    /// The load cell's dynamics, where they were identified.
    cell: Option<&'a LoadCell>,
    /// The markers from the clamp to the tip.
    order: Vec<usize>,
    set: &'a Settings,
}

impl<'a> Apparatus<'a> {
    /// The cross-talk from the staircases, beside the load cell.
    pub(super) fn from_staircases(
        trials: &TrialsWithForce,
        cell: Option<&'a LoadCell>,
        order: Vec<usize>,
        set: &'a Settings,
    ) -> Result<Self> {
        Ok(Self { talk: static_crosstalk(&trials.0, set)?, cell, order, set })
    }

    /// The force without cross-talk (`still`, N at each time of the log) and without ringing.
    fn taken_out(&self, force: &Series, crosstalk: &[Newton]) -> Result<Series> {
        let set = self.set;
        let clean = force.values().iter().zip(crosstalk).map(|(f, s)| f - s).collect();
        let clean = Series::new(force.start(), force.rate(), clean)?;
        Ok(match self.cell {
            Some(cell) if set.deconvolve => {
                let regularisation =
                    Regularisation { weight: set.deconvolution_weight, corner: set.deconvolution_cutoff };
                cell.in_time.cell().deconvolve(&clean, cell.noise, regularisation).force
            }
            _ => clean,
        })
    }

    /// A flapping trial as a run, with the mean of the subtracted cross-talk (N).
    fn gathered_run(
        &self,
        trial: &TrialWithForce,
        [amplitude, frequency]: [f64; 2],
        tail: &Tail,
    ) -> Result<(Run, Newton)> {
        let TrialWithForce { card, motion, force: pull } = trial;
        let cutoff = self.set.cutoff;
        let (gauges, force) = (pressure_samples(motion)?, pull.force());
        let crosstalk: Vec<f64> = pull.time.iter().map(|&t| self.talk.of(&gauges, t)).collect();
        let clean = self.taken_out(&force, &crosstalk)?;
        let (time, rate) = flapping_times(trial, frequency, &clean, self.set)?;
        let paths: Vec<[Series; 2]> =
            self.order.iter().map(|&m| smoothed_path(motion, m, cutoff)).collect::<Result<_>>()?;
        let rates: Vec<[Series; 2]> = paths.iter().map(|axes| axes.each_ref().map(rate_of)).collect();
        let [moved, speed] =
            [&paths, &rates].map(|paths| time.iter().map(|&t| positions_at(paths, t)).collect::<Vec<_>>());
        let pressed: Vec<Series> = gauges.iter().map(|g| smoothed_series(g, cutoff)).collect::<Result<_>>()?;
        let pressed_rate: Vec<Series> = pressed.iter().map(rate_of).collect();
        let values_at = |series: &[Series], t: Second| series.iter().map(|s| s.at(t)).collect::<Vec<f64>>();
        let taken = time.iter().map(|&t| self.talk.of(&gauges, t)).sum::<f64>() / time.len() as f64;
        let run = Run {
            id: card.id.clone(),
            amplitude,
            frequency,
            split: card.split,
            rate,
            force: time.iter().map(|&t| resample::cubic(&clean, t)).collect(),
            pressure: time.iter().map(|&t| values_at(&pressed, t)).collect(),
            pressure_rate: time.iter().map(|&t| values_at(&pressed_rate, t)).collect(),
            terms: run::theory_terms(tail, &moved, &speed, rate),
            time,
            moved,
            speed,
        };
        Ok((run, taken))
    }
}

/// The static cross-talk from the staircases; none where there is no staircase.
fn static_crosstalk(trials: &[TrialWithForce], set: &Settings) -> Result<CrossTalk> {
    let mut knots: Vec<Pascal> = vec![0.0];
    let mut runs = Vec::new();
    for trial in trials {
        if let Experiment::Staircase { levels, .. } = &trial.card.experiment {
            knots.extend(levels);
            runs.push(Staircase { force: trial.force.force(), pressures: pressure_samples(&trial.motion)? });
        }
    }
    if runs.is_empty() {
        return Ok(CrossTalk::none());
    }
    knots.sort_by(f64::total_cmp);
    knots.dedup();
    // flapping may exceed the highest held pressure: the last slope is then extrapolated
    let amplitudes = trials.iter().filter_map(|trial| match trial.card.experiment {
        Experiment::Flapping { amplitude, .. } => Some(amplitude),
        Experiment::Staircase { .. } => None,
    });
    let highest = amplitudes.fold(0.0, f64::max);
    let mut fitted = crosstalk::fit(&runs, &knots, &set.lags)?;
    let last = knots.len() - 1;
    if highest > knots[last] {
        let slope = (fitted.forces[last] - fitted.forces[last - 1]) / (knots[last] - knots[last - 1]);
        fitted.pressures.push(highest);
        fitted.forces.push(fitted.forces[last] + slope * (highest - knots[last]));
    }
    Ok(fitted)
}

/// The fewest times in a cycle, where the log has fewer samples.
const FEWEST_IN_CYCLE: f64 = 8.0;

/// The times of a run over whole filmed cycles after the settling cycles, as many in each cycle, and their rate, near that of the force.
// The samples of the log are not taken: in a fraction of a sample more or less than whole cycles lies that part of the amplitude, which is
// many times the mean, and the edge falls on either side of a sample with an error of the clock.
fn flapping_times(
    TrialWithForce { card, motion, force: pull }: &TrialWithForce,
    frequency: Hertz,
    force: &Series,
    set: &Settings,
) -> Result<(Vec<Second>, Hertz)> {
    let [first, last] = pull.commanded;
    let first = (first + set.settling_cycles / frequency).max(motion.time[0]);
    let last = last.min(motion.time[motion.time.len() - 1]);
    // the last command ends a cycle; both are known to a part of a sample
    let cycles = ((last - first) * frequency + 0.5 * frequency / force.rate()).floor().max(0.0);
    let samples = (cycles * force.rate() / frequency).floor();
    if samples < 8.0 {
        let too_short = format!("{} has {samples} samples of force in {cycles} whole cycles while flapping", card.id);
        return Err(Diagnostic::new(too_short, "a run needs at least 8", "record the trial for longer"));
    }
    let per_cycle = (force.rate() / frequency).round().max(FEWEST_IN_CYCLE);
    let rate = per_cycle * frequency;
    Ok(((0..(cycles * per_cycle) as usize).map(|i| first + (i as f64 + 0.5) / rate).collect(), rate))
}

/// Positions of all markers at a time, m; of rates, their velocities, m/s.
fn positions_at(paths: &[[Series; 2]], t: Second) -> Vec<Point2> {
    paths.iter().map(|axes| [axes[0].at(t), axes[1].at(t)]).collect()
}

fn pressure_samples(motion: &Motion) -> Result<Vec<Samples>> {
    let samples = motion.gauges.iter().map(|g| Samples::new(motion.log_time.clone(), g.measured.clone()));
    samples.collect::<Result<_, _>>().map_err(Diagnostic::from)
}

/// x and y of a marker, smoothed.
fn smoothed_path(motion: &Motion, marker: usize, cutoff: Hertz) -> Result<[Series; 2]> {
    let axis = |k: usize| {
        let values = motion.markers[marker].at.iter().map(|p| p[k]).collect();
        let samples = Samples::new(motion.time.clone(), values)?;
        smoothed_series(&samples, cutoff)
    };
    Ok([axis(0)?, axis(1)?])
}

fn smoothed_series(samples: &Samples, cutoff: Hertz) -> Result<Series> {
    let times = samples.times();
    let rate = (times.len() - 1) as f64 / (times[times.len() - 1] - times[0]);
    let even = samples.even(rate)?;
    smooth::low_pass(&even, cutoff, 2).map_err(Diagnostic::from)
}

fn rate_of(series: &Series) -> Series {
    let rates = run::central_rates(series.values(), series.rate());
    Series::new(series.start(), series.rate(), rates).expect("differences of finite values")
}
