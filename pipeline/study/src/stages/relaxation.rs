//! Relaxation: the spectrum of the silicone, from the transients of the films that identification may use.
//!
//! The tip marker's vibration after each change of the command of a staircase, its creep in each hold and its recovery after it are fitted
//! by [`sysid::relaxation`]. No validation film is read.

use serde::{Deserialize, Serialize};
use si::{Metre, Pascal, Second};

use super::fitting::mean_rest;
use super::simulation;
use diagnostics::Result;
use records::selections::IdentificationTrials;
use records::subject::TrialId;
use records::{self, Identified, Mesh, Motion, Reduced};
use sysid::actuated::frame_interval;
use sysid::relaxation::{Film, Footage, SpectrumProblem, SpectrumSettings, Window};
use sysid::{Body, ReducedBody, TimeSteps};
use workflow::stage::{Stage, StageContext};

/// The stage.
pub struct Relaxation;

/// `[relaxation]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Relaxation times at which a strength is identified, rising, s.
    times: Vec<Second>,
    /// Branches from one of these times to the next. Their strengths are interpolated at first, then all are free.
    branches_per_interval: usize,
    /// Median of the prior of each strength, no unit.
    prior_strength: f64,
    /// Standard deviation of its logarithm.
    prior_sigma: f64,
    /// How long the shutter is open, of the time between frames.
    exposure: f64,
    /// Time step after each change of the command, s.
    step: Second,
    /// How long that step is kept, s.
    vibration: Second,
    /// Longest time step of a hold, s.
    longest_step: Second,
    /// The highest level that counts, over the highest of a film.
    highest_level: f64,
    /// The same, over the pressure from which walls touch.
    below_contact: f64,
    /// Standard deviation of a marker's position before that of the discrepancy is estimated, m.
    sigma: Metre,
    /// Iterations of Gauss-Newton at most.
    iterations: usize,
    /// Tolerance of a step: converged when no logarithm changes by more.
    step_tolerance: f64,
}

impl Stage for Relaxation {
    type Settings = Settings;
    type Card = Body;
    type Needs = (Mesh, Identified, Reduced, IdentificationTrials<Motion>);
    type Makes = records::Relaxation;
    const DESCRIPTION: &'static str = "transients of the staircases give the silicone's relaxation";
    const VERSION: u32 = 10;

    fn run(
        card: &Self::Card,
        set: &Settings,
        (mesh, identified, reduced, films): Self::Needs,
        context: &dyn StageContext,
    ) -> Result<records::Relaxation> {
        let model = mesh.model(card)?.with_markers_at(&mesh.solid, card, &mean_rest(&films));
        let elastic = identified.elastic(&model);
        let body = ReducedBody::of(&model, &elastic.clone().into(), &reduced.data)?;
        let observed = |(trial, motion): &(TrialId, Motion)| {
            set.transient_film(motion, card.tip_marker(), reduced.contact).map_err(|d| d.while_doing(&trial.0))
        };
        let films = films.0.iter().map(observed).collect::<Result<Vec<_>>>()?;
        let (settings, modulus_time) = (set.spectrum_settings(), identified.modulus_time);
        let problem = SpectrumProblem {
            settings: &settings,
            model: &model,
            reduced: &body,
            held: elastic,
            modulus_time,
            films: &films,
        };
        let identified_spectrum = problem.identify(&|part| context.progress(part, "creeping"))?;
        Ok(records::Relaxation {
            spectrum: identified_spectrum.spectrum,
            rmse_m: identified_spectrum.rmse,
            elastic_rmse_m: identified_spectrum.elastic_rmse,
            correlation_time_s: identified_spectrum.correlation_time,
            transients: identified_spectrum.transients,
        })
    }
}

impl Settings {
    fn spectrum_settings(&self) -> SpectrumSettings {
        SpectrumSettings {
            times: self.times.clone(),
            branches_per_interval: self.branches_per_interval,
            prior_strength: self.prior_strength,
            prior_sigma: self.prior_sigma,
            sigma: self.sigma,
            iterations: self.iterations,
            step_tolerance: self.step_tolerance,
        }
    }

    fn transient_film(&self, motion: &Motion, marker: usize, contact: Option<Pascal>) -> Result<Film> {
        let steps = TimeSteps { step: self.step, vibration: self.vibration, longest: self.longest_step };
        let exposure = self.exposure * frame_interval(&motion.time);
        let footage =
            Footage { windows: self.counted_windows(contact, command_windows(motion, marker)), marker, exposure };
        Film::new(footage, simulation::gauge_samples(motion)?, steps)
    }

    /// The windows before the first level that does not count.
    // Walls that touch pass through each other in reduced coordinates, and a buckle lengthens the creep before it by a factor that depends on how
    // far its pressure is. The levels below show the same silicone.
    fn counted_windows(&self, contact: Option<Pascal>, windows: Vec<Window>) -> Vec<Window> {
        let top = windows.iter().map(|window| window.command).fold(0.0, f64::max);
        let touching = contact.map_or(f64::INFINITY, |pressure| self.below_contact * pressure);
        windows_below(touching.min(self.highest_level * top), windows)
    }
}

/// The windows before the first whose command is above the `highest` one and above the lowest of all.
fn windows_below(highest: Pascal, mut windows: Vec<Window>) -> Vec<Window> {
    let commands = windows.iter().map(|window| window.command).filter(|command| *command > 0.0);
    let lowest = commands.fold(f64::INFINITY, f64::min);
    let end = windows.iter().position(|window| window.command > highest.max(lowest));
    windows.truncate(end.unwrap_or(windows.len()));
    windows
}

/// The frames from each change of the command to the next, of one marker.
fn command_windows(motion: &Motion, marker: usize) -> Vec<Window> {
    let differs = |i: usize| motion.gauges.iter().any(|g| g.command[i] != g.command[i - 1]);
    let changes: Vec<usize> = (1..motion.log_time.len()).filter(|&i| differs(i)).collect();
    let end = motion.time.last().copied().unwrap_or_default();
    let ends = changes.iter().skip(1).map(|&i| motion.log_time[i]).chain([end]);
    let window = |(&change, end): (&usize, Second)| {
        let begin = motion.log_time[change];
        let inside = motion.time.iter().zip(&motion.markers[marker].at).filter(|(t, _)| **t >= begin && **t < end);
        let (times, seen) = inside.map(|(t, at)| (*t, *at)).unzip();
        let command = motion.gauges.iter().map(|g| g.command[change]).fold(0.0, f64::max);
        Window { begin, times, seen, command }
    };
    changes.iter().zip(ends).map(window).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_ends_with_the_highest_level_that_counts_but_not_before_its_first() {
        let window = |command: Pascal| Window { begin: 0.0, times: Vec::new(), seen: Vec::new(), command };
        let kept = |highest: Pascal| {
            let all = [1e4, 0.0, 1.5e4, 0.0, 2e4, 0.0, 1e4].map(window).to_vec();
            windows_below(highest, all).iter().map(|window| window.command).collect::<Vec<_>>()
        };
        assert_eq!(kept(f64::INFINITY).len(), 7);
        assert_eq!(kept(1.7e4), [1e4, 0.0, 1.5e4, 0.0]);
        assert_eq!(kept(5e3), [1e4, 0.0]);
    }
}
