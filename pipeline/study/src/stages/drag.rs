//! Drag: added mass and normal drag of a tail, from a release under water. Validation in water uses them.
//!
//! A staircase in water ends each hold by opening the chamber, and the tail vibrates freely in the water. The highest release
//! within the pressures of identification, with the hold before it, is simulated in reduced coordinates with elongated-body theory's
//! added mass and a normal drag; [`thrust::release`] identifies the ratio of the one and the coefficient of the other. No flapping
//! film is read.

use fem::{DynamicSettings, Scheme};
use hydro::Coefficients;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use si::{KilogramPerCubicMetre, Metre, Pascal, Second};

use super::deviations::{PART, UncertainSilicone};
use super::simulation;
use ::thrust::outline::Outline;
use ::thrust::release::{Release, ReleaseSettings, rms};
use ::thrust::underwater::UnderwaterModel;
use diagnostics::{Diagnostic, Result};
use records::selections::{OfTrials, UnderwaterStaircases};
use records::{self, Identified, Level, Mesh, Motion, Reduced, Relaxation};
use sysid::actuated::{Actuation, MotionSimulation, dynamic_settings, frame_interval};
use sysid::relaxation::Window;
use sysid::{Body, ReducedBody, TimeSteps, Viscoelastic};
use workflow::stage::{Stage, StageContext};

/// The stage.
pub struct Drag;

/// `[drag]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Density of the water, kg/m³.
    density: KilogramPerCubicMetre,
    /// Sections of the tail.
    sections: usize,
    /// Time step of the second-order scheme after a change of the command, s.
    step: Second,
    /// How long that step is kept in the hold before the release, s.
    vibration: Second,
    /// Longest time step of the hold, s.
    longest_step: Second,
    /// Duration after the release that is compared, up to the next command, s.
    duration: Second,
    /// Least and greatest ratio of theory's added mass.
    added_mass_ratio: [f64; 2],
    /// Least and greatest coefficient of normal drag.
    normal_drag_coefficient: [f64; 2],
    /// How long the shutter is open, of the time between frames.
    exposure: f64,
    /// Standard deviation of a marker's position, m.
    sigma: Metre,
    /// Simulations at most, three an iteration.
    iterations: usize,
    /// Tolerance of a step: converged when no logarithm changes by more.
    step_tolerance: f64,
}

impl Stage for Drag {
    type Settings = Settings;
    type Card = Body;
    type Needs = ((Mesh, Identified, Reduced), Relaxation, OfTrials<Motion, UnderwaterStaircases>);
    type Makes = records::Drag;
    const DESCRIPTION: &'static str = "a release under water gives added mass and drag";
    const VERSION: u32 = 13;

    fn run(card: &Self::Card, set: &Settings, needs: Self::Needs, context: &dyn StageContext) -> Result<records::Drag> {
        let ((mesh, identified, reduced), relaxation, films) = needs;
        let (_, motion) = films.0.first().ok_or_else(no_staircase)?;
        let outline = Outline::new(card, &mesh.solid);
        let (tail, spots) = outline.whole(set.density, set.sections)?;
        let model = mesh.model(card)?.with_markers_at(&mesh.solid, card, &motion.rest).with_spots(spots);
        let silicone = relaxation.silicone(&model, &identified)?;
        let simulation = MotionSimulation { silicone, model: &model, marker: card.tip_marker() };
        let highest_identified = identified.levels.iter().map(Level::pressure).fold(0.0, f64::max);
        let hold = highest_hold(motion, highest_identified, set.duration)?;
        let (gauges, steps) = (simulation::gauge_samples(motion)?, set.time_steps(&hold));
        let actuation = Actuation { begin: hold.begin, end: hold.end, steps: Some(&steps), gauges: &gauges };
        let reduced_body = ReducedBody::of(&model, &simulation.silicone, &reduced.data)?;
        let underwater = UnderwaterModel::new(&reduced_body, &tail, &simulation, card.markers.len());
        let film = released_window(motion, simulation.marker, &hold)?;
        let settings = dynamic_settings(Scheme::Bdf2, set.step);
        let comparison = ReleaseComparison { set, film: &film, actuation, settings };
        let mut simulations = 0;
        let mut evaluated = |points: &[Coefficients]| -> Result<Vec<Vec<f64>>> {
            simulations += points.len();
            context.progress(0.2 + 0.8 * (simulations as f64 / (3 * set.iterations) as f64).min(1.0), "releasing");
            points.par_iter().map(|coefficients| comparison.residuals(&underwater, *coefficients)).collect()
        };
        let release = set.release_settings().identify(&mut evaluated)?;
        let uncertain = UncertainSilicone { model: &model, identified: &identified, relaxation: &relaxation };
        let perturbed = |silicone: &Viscoelastic| {
            comparison.extrapolated_residuals(&underwater.with(&reduced_body.with(&model, silicone)), &release)
        };
        let perturbed = uncertain.perturbed_silicones()?.par_iter().map(perturbed).collect::<Result<Vec<_>>>()?;
        Ok(records::Drag {
            by: release.by,
            sigma: release.sigma(&perturbed)?,
            released: hold.pressure,
            rmse: set.sigma * rms(release.residuals()),
            moved: rms(&film.about_mean().concat()),
            simulations: simulations + perturbed.len(),
            density: set.density,
            sections: set.sections,
        })
    }
}

/// A simulated release against the filmed one.
struct ReleaseComparison<'a> {
    set: &'a Settings,
    film: &'a Window,
    actuation: Actuation<'a>,
    settings: DynamicSettings,
}

impl ReleaseComparison<'_> {
    /// Simulated less filmed positions over their standard deviation, no unit.
    fn residuals(&self, model: &UnderwaterModel, coefficients: Coefficients) -> Result<Vec<f64>> {
        let path = model.path(&self.settings, coefficients, &self.actuation)?;
        let exposure = self.set.exposure * frame_interval(&self.film.times);
        let (simulated, filmed) = self.film.compared(&path, exposure);
        Ok(simulated.iter().zip(filmed).map(|(s, m)| (s - m) / self.set.sigma).collect())
    }

    /// The residuals of a silicone one standard deviation off, by those of a model a [`PART`] of one off, at the identified
    /// coefficients.
    fn extrapolated_residuals(&self, model: &UnderwaterModel, release: &Release) -> Result<Vec<f64>> {
        let perturbed = self.residuals(model, release.by)?;
        Ok(perturbed.iter().zip(release.residuals()).map(|(other, best)| best + (other - best) / PART).collect())
    }
}

/// A hold of a staircase and its release; times are those of the film's clock, s.
struct Hold {
    begin: Second,
    released: Second,
    /// Of the time that is compared: the next command at the latest.
    end: Second,
    /// Its command, Pa.
    pressure: Pascal,
}

impl Settings {
    /// Ends of the time steps of a hold and its release, s after its begin. The silicone creeps during the hold and recovers after it: a
    /// tail that is released as if it had just been filled returns too far, and the drag would have to make up for that.
    fn time_steps(&self, hold: &Hold) -> Vec<Second> {
        let Self { step, vibration, longest_step: longest, duration, .. } = *self;
        let [release, end] = [hold.released, hold.end].map(|t| t - hold.begin);
        TimeSteps { step, vibration: vibration.max(duration), longest }.ends(&[0.0, release], end)
    }

    fn release_settings(&self) -> ReleaseSettings {
        let Self { added_mass_ratio, normal_drag_coefficient, iterations, step_tolerance, .. } = *self;
        ReleaseSettings { added_mass_ratio, normal_drag_coefficient, iterations, step_tolerance }
    }
}

/// The frames of a marker after the release.
///
/// # Errors
/// A [`Diagnostic`] when the marker does not move in them.
fn released_window(motion: &Motion, marker: usize, hold: &Hold) -> Result<Window> {
    let frames = motion.time.iter().zip(&motion.markers[marker].at);
    let inside = frames.filter(|(t, _)| (hold.released..hold.end).contains(*t));
    let (times, seen) = inside.map(|(t, at)| (*t, *at)).unzip();
    let window = Window { begin: hold.released, times, seen, command: 0.0 };
    if window.is_still() { Err(no_motion(hold.released)) } else { Ok(window) }
}

fn no_staircase() -> Diagnostic {
    Diagnostic::new("there is no staircase in water", "no trial of the card is one", "film one")
}

fn no_motion(released: Second) -> Diagnostic {
    Diagnostic::new(
        format!("the marker does not move after the release at {released:.3} s of the film"),
        "fewer than three frames show it, or it stays exactly where it is",
        "film the staircase in water until the tail has come to rest",
    )
}

/// The highest hold that is not above `known` (Pa), compared for `duration` after its release.
fn highest_hold(motion: &Motion, highest_identified: Pascal, duration: Second) -> Result<Hold> {
    let command = |i: usize| motion.gauges.iter().map(|g| g.command[i]).fold(0.0, f64::max);
    let changes: Vec<usize> = (1..motion.log_time.len()).filter(|&i| command(i) != command(i - 1)).collect();
    let time = |change: &usize| motion.log_time[*change];
    let hold = |k: usize| {
        let (begin, released) = (time(&changes[k - 1]), time(&changes[k]));
        let end = changes.get(k + 1).map_or(f64::INFINITY, time).min(released + duration);
        Hold { begin, released, end, pressure: command(changes[k - 1]) }
    };
    let released = (1..changes.len()).filter(|&k| command(changes[k]) == 0.0).map(hold);
    let below_limit = released.filter(|hold| hold.pressure <= NEAR * highest_identified);
    below_limit.max_by(|a, b| a.pressure.total_cmp(&b.pressure)).ok_or_else(|| {
        let limit =
            format!("moduli were identified up to {:.0} Pa, and no hold within is released", highest_identified);
        Diagnostic::new("drag cannot be identified from the staircase in water", limit, "film a lower level in water")
    })
}

/// A hold settles slightly below its command.
const NEAR: f64 = 1.1;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_highest_hold_within_the_known_pressures_is_released() {
        let time: Vec<f64> = (0..700).map(|i| 0.01 * f64::from(i)).collect();
        let command = time.iter().map(|&t| [0.0, 1e4, 0.0, 2e4, 0.0, 3e4, 0.0][(t + 1e-9) as usize]).collect();
        let motion = Motion::of_one_marker(time, command, vec![[0.0, 0.0]; 700]);
        let found = highest_hold(&motion, 1.9e4, 0.6).unwrap();
        assert_eq!((found.begin, found.released, found.end, found.pressure), (3.0, 4.0, 4.6, 2e4));
        assert_eq!(highest_hold(&motion, 1.9e4, 1.5).unwrap().end, 5.0, "the next level is filled");
        assert!(highest_hold(&motion, 5e3, 0.6).is_err());
    }
}
