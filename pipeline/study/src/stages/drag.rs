//! Drag: what the water around a tail weighs and how it resists, from a release under water. Validation in water stands on it.
//!
//! A staircase in water ends each hold by opening the chamber, and the tail swings back through the water. The highest release that
//! moduli were identified up to is simulated in reduced coordinates with elongated-body theory's added mass and a drag across the
//! flow; Gauss-Newton finds the share of the one and the coefficient of the other. No flapping film is touched.
//!
//! Stands on: the swing, the room `thrust`, fit. Never knows: a validation trial; its needs hand it none.

use fem::{March, Scheme};
use fit::optimisers::gauss_newton::{GaussNewton, Settings as Newton};
use fit::{Bounds, Evaluation, Needs, Optimiser, Residuals, Search};
use hydro::{Coefficients, Tail};
use nalgebra::DMatrix;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use si::{KilogramPerCubicMetre, Metre, Pascal, Point2, Second};

use super::damping::swing_marker;
use super::stop::Stop;
use super::swing::{self, Drive, Swing};
use crate::fault::{Fault, Outcome};
use crate::model::{Model, Small};
use crate::needs::Waded;
use crate::records::{self, Damping, Identified, Level, Mesh, Motion, Reduced};
use crate::stage::{Desk, Stage};
use crate::subject::Specimen;
use crate::thrust::outline::Outline;

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
    /// How long before the release the simulated tail is bent, s.
    ease: Second,
    /// How long after the release the film is followed, s.
    follow: Second,
    /// Least and greatest share of theory's added mass.
    added: [f64; 2],
    /// Least and greatest coefficient of drag.
    drag: [f64; 2],
    /// Deviation of a marker's place, m.
    sigma: Metre,
    /// Simulations at most, three an iteration.
    iterations: usize,
    /// It has converged when no logarithm moves by more.
    step_tolerance: f64,
}

/// The parameters, as messages name them.
const NAMES: [&str; 2] = ["added mass", "drag"];
/// Width of a difference, of a logarithm.
const NUDGE: f64 = 0.02;

impl Stage for Drag {
    type Settings = Settings;
    type Needs = ((Mesh, Identified, Reduced), Damping, Waded<Motion>);
    type Makes = records::Drag;
    const STORY: &'static str = "a release under water becomes added mass and drag";
    const EDITION: u32 = 4;

    fn card(of: &Specimen) -> Value {
        let (solid, card) = (&of.card.solid, &of.card);
        let region = |s: &lab::card::Solid| json!([s.material, s.poissons_ratio, s.density]);
        let markers = card.marker.iter().map(|m| m.at).collect::<Vec<_>>();
        json!({ "body": region(&solid.body), "spine": region(&solid.spine), "clamp": card.clamp.below_x, "markers": markers })
    }

    fn run(of: &Specimen, set: &Settings, needs: Self::Needs, desk: &dyn Desk) -> Outcome<records::Drag> {
        let ((mesh, identified, reduced), damping, films) = needs;
        let (_, motion) = films.0.first().ok_or_else(no_staircase)?;
        let outline = Outline::new(&of.card, &mesh.solid);
        let (tail, spots) = outline.whole(set.density, set.sections).map_err(Fault::from_tool)?;
        let model = Model::new(&mesh, &of.card)?.seen_at(&mesh, &of.card, &motion.rest).and(spots);
        let swing = Swing { elastic: swing::identified(&model, &identified), model: &model, marker: swing_marker(of) };
        let known = identified.levels.iter().map(Level::pressure).fold(0.0, f64::max);
        let (begin, released) = release(motion, known)?;
        let gauges = swing::gauges(motion)?;
        let drive = Drive { begin: begin - set.ease, end: begin + set.follow, eased: set.ease, gauges: &gauges };
        let small = Small::of(&model, &swing.elastic, &reduced.kept)?;
        let march = swing::march(Scheme::Bdf2, set.step, damping.stiffness_damping);
        let bath = Bath::new(&small, &tail, swing.marker, of.card.marker.len(), march, mesh.solid.half);
        let film = Film::of(motion, swing.marker, [begin, drive.end]);
        let mut marches = 0;
        let mut told = |at: &[Vec<f64>]| -> Outcome<Vec<Vec<f64>>> {
            marches += at.len();
            desk.progress(0.2 + 0.8 * (marches as f64 / (3 * set.iterations) as f64).min(1.0), "releasing");
            let off = |at: &Vec<f64>| Ok(film.off(&bath.path(coefficients(at), &drive)?, set.sigma));
            at.par_iter().map(off).collect()
        };
        let best = sought(set, &mut told)?;
        concluded(set, &best, film.moved(), released, marches)
    }
}

/// The watched marker of the film after its release.
struct Film {
    times: Vec<Second>,
    /// See [`about_mean`].
    seen: Vec<Metre>,
}

impl Film {
    /// Between two times, s on the film's clock.
    fn of(motion: &Motion, marker: usize, [begin, end]: [Second; 2]) -> Self {
        let inside = motion.time.iter().zip(&motion.markers[marker].at).filter(|(t, _)| **t > begin && **t < end);
        let (times, places): (Vec<Second>, Vec<Point2>) = inside.map(|(t, at)| (*t, *at)).unzip();
        Self { times, seen: about_mean(&places) }
    }

    /// How far a simulated path is off, in deviations `sigma` (m).
    fn off(&self, path: &[signal::resample::Samples; 2], sigma: Metre) -> Vec<f64> {
        let path = about_mean(&swing::onto(path, &self.times));
        path.iter().zip(&self.seen).map(|(a, b)| (a - b) / sigma).collect()
    }

    /// How far the marker moved, m.
    fn moved(&self) -> Metre {
        rms(&self.seen)
    }
}

/// Root of the mean square of a path's distances, x and y one after the other.
fn rms(of: &[f64]) -> f64 {
    (of.iter().map(|v| v * v).sum::<f64>() / (of.len() / 2).max(1) as f64).sqrt()
}

fn concluded(
    set: &Settings,
    best: &Evaluation,
    moved: Metre,
    released: Pascal,
    marches: usize,
) -> Outcome<records::Drag> {
    let residuals = best.residuals.as_ref().ok_or_else(|| Fault::from_tool("the best march left no residuals"))?;
    let posterior = residuals.posterior(NAMES.len()).map_err(Fault::from_tool)?;
    let by = coefficients(&best.at);
    let sigma = Coefficients { added: by.added * posterior.sigma(0), drag: by.drag * posterior.sigma(1) };
    let rmse = set.sigma * rms(&residuals.values);
    Ok(records::Drag { by, sigma, released, rmse, moved, marches, density: set.density, sections: set.sections })
}

fn no_staircase() -> Fault {
    Fault::new("there is no staircase in water", "no trial of the card is one", "film one")
}

/// A reduced tail in water.
pub(super) struct Bath<'a> {
    small: &'a Small,
    tail: &'a Tail,
    /// Rows of the tail's stations, and of the marker that is watched, m.
    stations: DMatrix<f64>,
    watched: DMatrix<f64>,
    march: March,
    half: bool,
}

impl<'a> Bath<'a> {
    /// The tail's stations stand behind the card's `marks` in the model; one marker is watched, half of the body may be modelled.
    pub fn new(small: &'a Small, tail: &'a Tail, marker: usize, marks: usize, march: March, half: bool) -> Self {
        let stations = small.rows(&(marks..small.markers()).collect::<Vec<_>>());
        Self { small, tail, stations, watched: small.rows(&[marker]), march, half }
    }

    /// The watched marker's displacement, m along x and y, as functions of the film's time.
    ///
    /// # Errors
    /// A [`Fault`] when a step finds no motion.
    pub fn path(&self, by: Coefficients, drive: &Drive) -> Outcome<[signal::resample::Samples; 2]> {
        let mut water = crate::thrust::water::Water::around(self.tail, &self.stations, by, self.half);
        let mut path: Vec<Point2> = Vec::new();
        self.small.swim(
            &self.march,
            &mut water,
            &|t| drive.pressures(t),
            drive.steps(self.march.step),
            &mut |q, _| {
                path.push([0, 1].map(|k| (self.watched.row(k) * q)[0]));
            },
        )?;
        drive.told(self.march.step, &path)
    }
}

fn coefficients(at: &[f64]) -> Coefficients {
    Coefficients { added: at[0].exp(), drag: at[1].exp() }
}

/// The residuals at each of some places.
type Told<'a> = dyn FnMut(&[Vec<f64>]) -> Outcome<Vec<Vec<f64>>> + 'a;

/// Gauss-Newton over both logarithms; `told` gives the residuals at some places.
fn sought(set: &Settings, told: &mut Told) -> Outcome<Evaluation> {
    let edge = |k: usize| [set.added[k].ln(), set.drag[k].ln()].to_vec();
    let start = bounds_middle(set);
    let search = Search::new(&NAMES, start, Bounds { low: edge(0), high: edge(1) }).map_err(Fault::from_tool)?;
    let newton = Newton { step_tolerance: set.step_tolerance, iterations: set.iterations, ..Newton::default() };
    let mut walk = GaussNewton::new(&search, &newton).map_err(Fault::from_tool)?;
    let mut evaluate = |at: &Vec<f64>| -> Outcome<Evaluation> {
        let nudged = |k: usize| at.iter().enumerate().map(|(i, x)| x + if i == k { NUDGE } else { 0.0 }).collect();
        let mut found = told(&[at.clone(), nudged(0), nudged(1)])?.into_iter();
        let values = found.next().unwrap_or_default();
        let columns: Vec<Vec<f64>> = found.collect();
        let slope = |i: usize| columns.iter().map(|c| (c[i] - values[i]) / NUDGE).collect::<Vec<f64>>();
        let jacobian = (0..values.len()).flat_map(slope).collect();
        let residuals = Residuals { values, jacobian };
        Ok(Evaluation { loss: residuals.half_square(), at: at.clone(), gradient: None, residuals: Some(residuals) })
    };
    let mut problem = |batch: &[Vec<f64>], _: Needs| -> Result<Vec<Evaluation>, Stop> {
        batch.iter().map(|at| evaluate(at).map_err(Stop)).collect()
    };
    Ok(fit::minimise(&mut walk as &mut dyn Optimiser, &mut problem).map_err(|stop| stop.0)?.best)
}

/// The middle of both ranges, in logarithms.
fn bounds_middle(set: &Settings) -> Vec<f64> {
    [set.added, set.drag].map(|[low, high]| 0.5 * (low * high).ln()).to_vec()
}

/// x and y of a path one after the other, each about its mean: where it comes to rest is not the water's.
fn about_mean(path: &[Point2]) -> Vec<f64> {
    let count = path.len().max(1) as f64;
    let mean = [0, 1].map(|k| path.iter().map(|p| p[k]).sum::<f64>() / count);
    path.iter().flat_map(|p| [p[0] - mean[0], p[1] - mean[1]]).collect()
}

/// When the highest hold that is not above `known` (Pa) was released, s on the film's clock, and from which command, Pa.
fn release(motion: &Motion, known: Pascal) -> Outcome<(Second, Pascal)> {
    let asked = |i: usize| motion.gauges.iter().map(|g| g.command[i]).fold(0.0, f64::max);
    let falls = (1..motion.log_time.len()).filter(|&i| asked(i) == 0.0 && asked(i - 1) > 0.0);
    let within = falls.map(|i| (motion.log_time[i], asked(i - 1))).filter(|(_, p)| *p <= NEAR * known);
    within.max_by(|a, b| a.1.total_cmp(&b.1)).ok_or_else(|| {
        let why = format!("moduli were identified up to {:.0} Pa, and no hold within is released", known);
        Fault::new("the staircase in water cannot tell drag", why, "film a lower level in water")
    })
}

/// A hold settles a little under its command.
const NEAR: f64 = 1.1;

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> Settings {
        Settings {
            density: 998.0,
            sections: 10,
            step: 0.01,
            ease: 0.1,
            follow: 0.5,
            added: [0.3, 2.0],
            drag: [0.5, 50.0],
            sigma: 1e-4,
            iterations: 12,
            step_tolerance: 1e-4,
        }
    }

    #[test]
    fn a_path_s_own_coefficients_are_found_again() {
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
        let mut told = |at: &[Vec<f64>]| {
            Ok(at.iter().map(|a| path(a).iter().zip(&hidden).map(|(x, y)| x - y).collect()).collect())
        };
        let found = coefficients(&sought(&settings(), &mut told).unwrap().at);
        assert!((found.added - 0.7).abs() < 1e-3 && (found.drag - 12.0).abs() < 2e-2, "{found:?}");
    }

    #[test]
    fn where_a_path_lies_is_left_out() {
        let path = [[1.0, 5.0], [3.0, 9.0]];
        assert_eq!(about_mean(&path), [-1.0, -2.0, 1.0, 2.0]);
    }
}
