//! Gathering: trials weighed in water become the runs that thrust is learnt from and judged by.
//!
//! Staircases tell the static cross-talk of pressure, which is taken out of the force; the fixture's ringing is undone; motion and
//! pressure are read at the times of the force, over whole beats.
//!
//! Stands on: signal, the room `thrust`. Never knows: a rung.

use hydro::Tail;
use lab::card::Experiment;
use si::{Hertz, Newton, Pascal, Point2, Second, Series};
use signal::cell::Regularised;
use signal::crosstalk::{self, CrossTalk, Still};
use signal::resample::Samples;
use signal::smooth;

use super::Settings;
use crate::fault::{Fault, Outcome};
use crate::needs::{Id, Needs, OfTrials, Shelf, id};
use crate::records::{LoadCell, Motion, Pull};
use crate::subject::{Scope, Specimen, Trial};
use crate::thrust::outline::order;
use crate::thrust::{Run, run};

/// Motion and force of every trial weighed in water.
pub struct Weighed(Vec<(Trial, Motion, Pull)>);

impl Needs<Specimen> for Weighed {
    fn wanted(of: &Specimen) -> Vec<Id> {
        let both = |t: &Trial| [id::<Motion>(t), id::<Pull>(t)];
        of.trials().iter().filter(|t| t.is_weighed_in_water()).flat_map(both).collect()
    }

    fn fetch(of: &Specimen, shelf: &dyn Shelf) -> Outcome<Self> {
        let OfTrials(pulls) = OfTrials::<Pull>::fetch(of, shelf)?;
        let one = |(trial, pull): (Trial, Pull)| {
            let motion = <Motion as Needs<Trial>>::fetch(&trial, shelf)?;
            Ok((trial, motion, pull))
        };
        Ok(Self(pulls.into_iter().map(one).collect::<Outcome<_>>()?))
    }
}

impl Weighed {
    /// Every beating trial as a run, and the cross-talk taken out of each on the mean, N.
    pub(super) fn runs(&self, tail: &Tail, by: &Apparatus, set: &Settings) -> Outcome<(Vec<Run>, Vec<Newton>)> {
        let mut runs = Vec::new();
        for (trial, motion, pull) in &self.0 {
            if let Experiment::Flapping { amplitude, frequency, .. } = trial.trial.experiment {
                runs.push(gathered(trial, motion, pull, [amplitude, frequency], tail, by, set)?);
            }
        }
        Ok(runs.into_iter().unzip())
    }
}

/// What stands between the tail and the force log.
pub(super) struct Apparatus<'a> {
    /// The cross-talk of pressure.
    pub(super) talk: CrossTalk,
    /// How the load cell rings, where that was measured.
    cell: Option<&'a LoadCell>,
}

impl<'a> Apparatus<'a> {
    /// The cross-talk from the staircases, beside the load cell.
    pub(super) fn of(weighed: &Weighed, cell: Option<&'a LoadCell>, set: &Settings) -> Outcome<Self> {
        Ok(Self { talk: talk(&weighed.0, set)?, cell })
    }

    /// The force without cross-talk (N at each time of the log, given) and without ringing.
    fn taken_out(&self, force: &Series, still: &[Newton], set: &Settings) -> Outcome<Series> {
        let clean = force.values().iter().zip(still).map(|(f, s)| f - s).collect();
        let clean = Series::new(force.start(), force.rate(), clean).map_err(Fault::from_tool)?;
        Ok(match self.cell {
            Some(cell) if set.undo => {
                let held = Regularised { weight: set.undo_weight, smooth: set.undo_smooth };
                cell.in_time.cell().undo(&clean, cell.noise, held).force
            }
            _ => clean,
        })
    }
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

/// A beating trial as a run, with the cross-talk taken out of it on the mean (N).
fn gathered(
    trial: &Trial,
    motion: &Motion,
    pull: &Pull,
    [amplitude, frequency]: [f64; 2],
    tail: &Tail,
    by: &Apparatus,
    set: &Settings,
) -> Outcome<(Run, Newton)> {
    let (gauges, force) = (gauges(motion)?, pull.force());
    let still: Vec<f64> = pull.time.iter().map(|&t| by.talk.of(&gauges, t)).collect();
    let clean = by.taken_out(&force, &still, set)?;
    let samples = beating(trial, motion, pull, frequency, &clean, set)?;
    let time: Vec<Second> = samples.iter().map(|&i| clean.time(i)).collect();
    let specimen = Specimen { card: trial.card.clone() };
    let paths: Vec<[Series; 2]> =
        order(&specimen.card).iter().map(|&m| path(motion, m, set.smooth)).collect::<Outcome<_>>()?;
    let rates: Vec<[Series; 2]> = paths.iter().map(|axes| axes.each_ref().map(rate_of)).collect();
    let [moved, speed] = [&paths, &rates].map(|of| time.iter().map(|&t| places(of, t)).collect::<Vec<_>>());
    let pressed: Vec<Series> = gauges.iter().map(|g| even(g, set.smooth)).collect::<Outcome<_>>()?;
    let pressed_rate: Vec<Series> = pressed.iter().map(rate_of).collect();
    let at = |of: &[Series], t: Second| of.iter().map(|s| s.at(t)).collect::<Vec<f64>>();
    let taken = samples.iter().map(|&i| still[i]).sum::<f64>() / samples.len() as f64;
    let run = Run {
        id: trial.trial.id.clone(),
        amplitude,
        frequency,
        split: trial.trial.split,
        rate: clean.rate(),
        force: samples.iter().map(|&i| clean.values()[i]).collect(),
        pressure: time.iter().map(|&t| at(&pressed, t)).collect(),
        pressure_rate: time.iter().map(|&t| at(&pressed_rate, t)).collect(),
        terms: run::parts(tail, &moved, &speed, clean.rate()),
        time,
        moved,
        speed,
    };
    Ok((run, taken))
}

/// The samples of the force over whole beats that were filmed, once the first beats have settled.
fn beating(
    trial: &Trial,
    motion: &Motion,
    pull: &Pull,
    frequency: Hertz,
    force: &Series,
    set: &Settings,
) -> Outcome<Vec<usize>> {
    let [first, last] = pull.commanded;
    let first = (first + set.settle_beats / frequency).max(motion.time[0]);
    let last = last.min(motion.time[motion.time.len() - 1]);
    let whole = first + ((last - first) * frequency).floor() / frequency;
    let inside = |i: &usize| (first..whole).contains(&force.time(*i));
    let samples: Vec<usize> = (0..force.values().len()).filter(inside).collect();
    if samples.len() < 8 {
        let what = format!("{} has {} samples of force while it beats", trial.name(), samples.len());
        return Err(Fault::new(what, "a run needs at least 8", "record the trial for longer"));
    }
    Ok(samples)
}

/// Where all marks are at a time, m; of rates, how fast, m/s.
fn places(of: &[[Series; 2]], t: Second) -> Vec<Point2> {
    of.iter().map(|axes| [axes[0].at(t), axes[1].at(t)]).collect()
}

fn gauges(motion: &Motion) -> Outcome<Vec<Samples>> {
    let samples = motion.gauges.iter().map(|g| Samples::new(motion.log_time.clone(), g.measured.clone()));
    samples.collect::<Result<_, _>>().map_err(Fault::from_tool)
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
