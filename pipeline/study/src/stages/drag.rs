//! Drag: added mass and normal drag of a tail, from a release under water. Validation in water uses them.
//!
//! A staircase in water ends each hold by opening the chamber, and the tail vibrates freely in the water. The highest release
//! within the pressures of identification is simulated in reduced coordinates with elongated-body theory's added mass and a normal
//! drag; Gauss-Newton identifies the ratio of the one and the coefficient of the other. No flapping film is read.

use fem::{DynamicSettings, Scheme};
use hydro::{Coefficients, Tail};
use nalgebra::DMatrix;
use optimize::optimisers::gauss_newton::{GaussNewton, Settings as Newton};
use optimize::posterior::integrated_correlation;
use optimize::{Bounds, Evaluation, Needs, Optimiser, Problem, Residuals};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use si::{KilogramPerCubicMetre, Metre, Pascal, Point2, Second};

use super::simulation::{self, Actuation, MotionSimulation};
use crate::records::{self, Identified, Level, Mesh, Motion, Reduced, Relaxation};
use crate::selections::{OfTrials, UnderwaterStaircases};
use ::thrust::outline::Outline;
use diagnostics::{Diagnostic, Result};
use sysid::Interrupted;
use sysid::{Body, ForcedMotion, ReducedBody};
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
    /// Time step of the second-order scheme, s.
    step: Second,
    /// Duration of the pressure ramp before the release, s.
    ramp: Second,
    /// Duration after the release that is compared, s.
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

/// Names of the parameters in messages.
const NAMES: [&str; 2] = ["added mass", "drag"];
/// Step of the finite difference, in the logarithm.
const NUDGE: f64 = 0.02;

impl Stage for Drag {
    type Settings = Settings;
    type Card = Body;
    type Needs = ((Mesh, Identified, Reduced), Relaxation, OfTrials<Motion, UnderwaterStaircases>);
    type Makes = records::Drag;
    const DESCRIPTION: &'static str = "a release under water gives added mass and drag";
    const VERSION: u32 = 7;

    fn run(card: &Self::Card, set: &Settings, needs: Self::Needs, context: &dyn StageContext) -> Result<records::Drag> {
        let ((mesh, identified, reduced), relaxation, films) = needs;
        let (_, motion) = films.0.first().ok_or_else(no_staircase)?;
        let outline = Outline::new(card, &mesh.solid);
        let (tail, spots) = outline.whole(set.density, set.sections)?;
        let model = mesh.model(card)?.with_markers_at(&mesh.solid, card, &motion.rest).with_spots(spots);
        let simulation = MotionSimulation {
            silicone: relaxation.silicone(&model, &identified)?,
            model: &model,
            marker: card.tip_marker(),
        };
        let known = identified.levels.iter().map(Level::pressure).fold(0.0, f64::max);
        let (begin, released) = release(motion, known)?;
        let gauges = simulation::gauges(motion)?;
        let actuation =
            Actuation { begin: begin - set.ramp, end: begin + set.duration, ramp: set.ramp, gauges: &gauges };
        let reduced_body = ReducedBody::of(&model, &simulation.silicone, &reduced.data)?;
        let settings = simulation::dynamic_settings(Scheme::Bdf2, set.step);
        let underwater = UnderwaterModel::new(&reduced_body, &tail, &simulation, card.markers.len());
        let film = Film::of(motion, simulation.marker, [begin, actuation.end], released);
        let mut simulations = 0;
        let mut evaluated = |at: &[Vec<f64>]| -> Result<Vec<Vec<f64>>> {
            simulations += at.len();
            context.progress(0.2 + 0.8 * (simulations as f64 / (3 * set.iterations) as f64).min(1.0), "releasing");
            let off = |at: &Vec<f64>| Ok(film.off(&underwater.path(&settings, coefficients(at), &actuation)?, set));
            at.par_iter().map(off).collect()
        };
        let best = sought(set, &mut evaluated)?;
        concluded(set, &best, &film, simulations)
    }
}

/// The observed marker of the film after its release.
struct Film {
    times: Vec<Second>,
    /// See [`about_mean`].
    seen: Vec<Metre>,
    /// The commanded pressure before the release, Pa.
    released: Pascal,
}

impl Film {
    /// Between two times, s on the film's clock.
    fn of(motion: &Motion, marker: usize, [begin, end]: [Second; 2], released: Pascal) -> Self {
        let inside = motion.time.iter().zip(&motion.markers[marker].at).filter(|(t, _)| **t > begin && **t < end);
        let (times, places): (Vec<Second>, Vec<Point2>) = inside.map(|(t, at)| (*t, *at)).unzip();
        Self { times, seen: about_mean(&places), released }
    }

    /// Residuals of a simulated path in units of their standard deviation.
    fn off(&self, path: &[signal::resample::Samples; 2], set: &Settings) -> Vec<f64> {
        let path = about_mean(&simulation::filmed(path, &self.times, set.exposure));
        path.iter().zip(&self.seen).map(|(a, b)| (a - b) / set.sigma).collect()
    }

    /// Amplitude of the marker, m.
    fn moved(&self) -> Metre {
        rms(&self.seen)
    }
}

/// Root of the mean square of a path's distances, x and y one after the other.
fn rms(of: &[f64]) -> f64 {
    (of.iter().map(|v| v * v).sum::<f64>() / (of.len() / 2).max(1) as f64).sqrt()
}

fn concluded(set: &Settings, best: &Evaluation, film: &Film, simulations: usize) -> Result<records::Drag> {
    let residuals = best.residuals.as_ref().ok_or_else(|| {
        Diagnostic::new(
            "the best simulation left no residuals",
            "it was evaluated without them",
            "report it with the recordings",
        )
    })?;
    let posterior = residuals.posterior(NAMES.len())?;
    let by = coefficients(&best.at);
    let scale = discrepancy(residuals);
    let sigma =
        Coefficients { added: scale * by.added * posterior.sigma(0), drag: scale * by.drag * posterior.sigma(1) };
    let rmse = set.sigma * rms(&residuals.values);
    let (moved, released) = (film.moved(), film.released);
    Ok(records::Drag { by, sigma, released, rmse, moved, simulations, density: set.density, sections: set.sections })
}

/// By how much the deviations of the parameters exceed those of independent residuals of the set deviation: a model that is not the tail
/// leaves a smooth discrepancy, whose size and correlation length are those of the residuals.
fn discrepancy(residuals: &Residuals) -> f64 {
    let count = residuals.values.len();
    let size = (2.0 * residuals.half_sum_of_squares() / (count.max(3) - 2) as f64).sqrt();
    let axes = residuals.values.chunks_exact((count / 2).max(1));
    let length = axes.map(integrated_correlation).sum::<f64>() / 2.0;
    size * length.sqrt()
}

fn no_staircase() -> Diagnostic {
    Diagnostic::new("there is no staircase in water", "no trial of the card is one", "film one")
}

/// A reduced model in water.
pub(super) struct UnderwaterModel<'a> {
    reduced_body: &'a ReducedBody,
    tail: &'a Tail,
    /// Rows of the tail's stations and of the observed marker, m.
    stations: DMatrix<f64>,
    watched: DMatrix<f64>,
    half: bool,
}

impl<'a> UnderwaterModel<'a> {
    /// The tail's stations follow the card's `marker_count` markers in the model of `simulation`.
    pub fn new(
        reduced_body: &'a ReducedBody,
        tail: &'a Tail,
        simulation: &MotionSimulation,
        marker_count: usize,
    ) -> Self {
        let stations = reduced_body.rows(&(marker_count..reduced_body.markers()).collect::<Vec<_>>());
        let half = simulation.model.system.mesh().symmetry_plane_z;
        Self { reduced_body, tail, stations, watched: reduced_body.rows(&[simulation.marker]), half }
    }

    /// Displacement of the observed marker along x and y, m, as functions of the film's time.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a step finds no motion.
    pub fn path(
        &self,
        settings: &DynamicSettings,
        by: Coefficients,
        actuation: &Actuation,
    ) -> Result<[signal::resample::Samples; 2]> {
        let mut water = ::thrust::water::Water::around(self.tail, &self.stations, by, self.half);
        let mut path: Vec<Point2> = Vec::new();
        let times = actuation.times(settings.step);
        let motion = ForcedMotion { settings, pressures: &|t| actuation.pressures(t), times: &times };
        self.reduced_body.integrate_in_fluid(&motion, &mut water, &mut |q, _| {
            path.push([0, 1].map(|k| (self.watched.row(k) * q)[0]));
        })?;
        actuation.sampled(&times, &path)
    }
}

fn coefficients(at: &[f64]) -> Coefficients {
    Coefficients { added: at[0].exp(), drag: at[1].exp() }
}

/// The residuals at each of several points.
type Evaluated<'a> = dyn FnMut(&[Vec<f64>]) -> Result<Vec<Vec<f64>>> + 'a;

/// Gauss-Newton over both logarithms; `evaluated` gives the residuals at several points.
fn sought(set: &Settings, evaluated: &mut Evaluated) -> Result<Evaluation> {
    let edge = |k: usize| [set.added_mass_ratio[k].ln(), set.normal_drag_coefficient[k].ln()].to_vec();
    let start = bounds_middle(set);
    let search = Problem::new(&NAMES, start, Bounds { low: edge(0), high: edge(1) })?;
    let newton = Newton { step_tolerance: set.step_tolerance, iterations: set.iterations, ..Newton::default() };
    let mut optimiser = GaussNewton::new(&search, &newton)?;
    let mut evaluate = |at: &Vec<f64>| -> Result<Evaluation> {
        let nudged = |k: usize| at.iter().enumerate().map(|(i, x)| x + if i == k { NUDGE } else { 0.0 }).collect();
        let mut found = evaluated(&[at.clone(), nudged(0), nudged(1)])?.into_iter();
        let values = found.next().unwrap_or_default();
        let columns: Vec<Vec<f64>> = found.collect();
        let slope = |i: usize| columns.iter().map(|c| (c[i] - values[i]) / NUDGE).collect::<Vec<f64>>();
        let jacobian = (0..values.len()).flat_map(slope).collect();
        let residuals = Residuals { values, jacobian };
        Ok(Evaluation {
            loss: residuals.half_sum_of_squares(),
            at: at.clone(),
            gradient: None,
            residuals: Some(residuals),
        })
    };
    let mut problem = |batch: &[Vec<f64>], _: Needs| -> Result<Vec<Evaluation>, Interrupted> {
        batch.iter().map(|at| evaluate(at).map_err(Interrupted)).collect()
    };
    Ok(optimize::minimise(&mut optimiser as &mut dyn Optimiser, &mut problem).map_err(|stop| stop.0)?.best)
}

/// The middle of both ranges, in logarithms.
fn bounds_middle(set: &Settings) -> Vec<f64> {
    [set.added_mass_ratio, set.normal_drag_coefficient].map(|[low, high]| 0.5 * (low * high).ln()).to_vec()
}

/// x and y of a path one after the other, each about its mean: the equilibrium does not depend on the water.
fn about_mean(path: &[Point2]) -> Vec<f64> {
    let count = path.len().max(1) as f64;
    let mean = [0, 1].map(|k| path.iter().map(|p| p[k]).sum::<f64>() / count);
    path.iter().flat_map(|p| [p[0] - mean[0], p[1] - mean[1]]).collect()
}

/// Time of the release of the highest hold that is not above `known` (Pa), s on the film's clock, and its command, Pa.
fn release(motion: &Motion, known: Pascal) -> Result<(Second, Pascal)> {
    let asked = |i: usize| motion.gauges.iter().map(|g| g.command[i]).fold(0.0, f64::max);
    let falls = (1..motion.log_time.len()).filter(|&i| asked(i) == 0.0 && asked(i - 1) > 0.0);
    let within = falls.map(|i| (motion.log_time[i], asked(i - 1))).filter(|(_, p)| *p <= NEAR * known);
    within.max_by(|a, b| a.1.total_cmp(&b.1)).ok_or_else(|| {
        let why = format!("moduli were identified up to {:.0} Pa, and no hold within is released", known);
        Diagnostic::new("drag cannot be identified from the staircase in water", why, "film a lower level in water")
    })
}

/// A hold settles slightly below its command.
const NEAR: f64 = 1.1;

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> Settings {
        Settings {
            density: 998.0,
            sections: 10,
            step: 0.01,
            ramp: 0.1,
            duration: 0.5,
            added_mass_ratio: [0.3, 2.0],
            normal_drag_coefficient: [0.5, 50.0],
            exposure: 0.96,
            sigma: 1e-4,
            iterations: 12,
            step_tolerance: 1e-4,
        }
    }

    #[test]
    fn the_coefficients_of_a_simulated_path_are_identified() {
        let path = |at: &[f64]| -> Vec<f64> {
            let by = coefficients(at);
            (0..60)
                .map(|i| {
                    (-f64::from(i) / (8.0 * by.drag.sqrt())).exp() * (f64::from(i) / (5.0 + 4.0 * by.added)).cos()
                        / 1e-2
                })
                .collect()
        };
        let hidden = path(&[0.7_f64.ln(), 12.0_f64.ln()]);
        let mut evaluated = |at: &[Vec<f64>]| {
            Ok(at.iter().map(|a| path(a).iter().zip(&hidden).map(|(x, y)| x - y).collect()).collect())
        };
        let found = coefficients(&sought(&settings(), &mut evaluated).unwrap().at);
        assert!((found.added - 0.7).abs() < 1e-3 && (found.drag - 12.0).abs() < 2e-2, "{found:?}");
    }

    #[test]
    fn where_a_path_lies_is_left_out() {
        let path = [[1.0, 5.0], [3.0, 9.0]];
        assert_eq!(about_mean(&path), [-1.0, -2.0, 1.0, 2.0]);
    }
}
