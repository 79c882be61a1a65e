//! Identify: the Young's moduli with which the simulation follows the quasi-static films best. Paper: section V.
//!
//! Each method of `fit` searches the plane of both moduli, in logarithms over the card's nominal values. The answer is the
//! Gauss-Newton method's; the others are run to be compared with it.
//!
//! Stands on: the model, fit. Never knows: a validation trial; its needs hand it none.

use fem::StaticSettings;
use fit::optimisers::{self, adam, gauss_newton, grid};
use fit::{Bounds, Evaluation, FitError, History, Needs, Residuals, Search};
use lab::card::Card;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use si::{Metre, Pascal, Point2, Second};

use super::landscape;
use super::plateaus::rungs;
use crate::fault::{Fault, Outcome};
use crate::model::{Ladder, Model, Rung, Simulated, Want, by_node};
use crate::needs::Learning;
use crate::records::{self, Identified, Level, Mesh, Motion, Point, Tried};
use crate::stage::{Desk, Stage};
use crate::subject::Specimen;

/// The stage.
pub struct Identify;

/// `[identify]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// The part at the end of each hold that counts as settled, 0 to 1.
    settled: f64,
    /// The shortest hold that counts, s.
    shortest_hold: Second,
    /// Standard deviation of a measured displacement beside its covariance: what the model leaves out, m.
    discrepancy: Metre,
    /// Points an axis of the exhaustive search.
    grid_points: usize,
    /// Length of Adam's step, in logarithms of moduli.
    adam_step: f64,
    /// How fast it shrinks, 1/iterations.
    adam_step_decay: f64,
    /// β₁ of Adam.
    adam_mean_memory: f64,
    /// β₂ of Adam.
    adam_square_memory: f64,
    /// Adam's simulations at most.
    adam_iterations: usize,
    /// Gauss-Newton's simulations at most.
    gauss_newton_iterations: usize,
    /// A search has converged when no logarithm of a modulus moves by more.
    step_tolerance: f64,
    /// Newton has converged when no node moves by more than this part of the specimen's size.
    static_tolerance: f64,
    /// Equilibria solved side by side.
    side_by_side: usize,
    /// Points an axis of the drawn landscape.
    landscape_points: usize,
}

impl Stage for Identify {
    type Settings = Settings;
    type Needs = (Mesh, Learning<Motion>);
    type Makes = Identified;
    const STORY: &'static str = "quasi-static motion becomes Young's moduli";
    const EDITION: u32 = 1;

    fn card(of: &Specimen) -> Value {
        let (solid, card) = (&of.card.solid, &of.card);
        let region = |s: &lab::card::Solid| {
            json!([s.material, s.youngs_modulus, s.poissons_ratio, s.density, s.plausible])
        };
        json!({ "body": region(&solid.body), "spine": region(&solid.spine), "clamp": card.clamp.below_x, "length": card.length })
    }

    fn run(of: &Specimen, set: &Settings, (mesh, films): Self::Needs, desk: &dyn Desk) -> Outcome<Identified> {
        let table = Table::new(of, set, &mesh, &films)?;
        let gradient_difference = table.gradient_difference()?;
        let mut searches = Vec::new();
        let mut last = None;
        for (i, member) in optimisers::ALL.iter().enumerate() {
            desk.progress((i + 1) as f64 / (optimisers::ALL.len() + 1) as f64, member.name);
            let began = desk.seconds();
            let (history, told) = table.search(member)?;
            searches.push(table.record(member.name, &history, desk.seconds() - began));
            if member.name == grid::NAME {
                last = Some((None, Some(told)));
            } else if member.name == gauss_newton::NAME {
                last = Some((Some(history), last.and_then(|(_, told)| told)));
            }
        }
        match last {
            Some((Some(best), Some(told))) => table.conclude(&best, &told, searches, gradient_difference, desk),
            _ => Err(Fault::new("identification needs grid and gauss_newton", "`fit` lists neither", "restore them")),
        }
    }
}

/// Everything that a search needs to simulate.
struct Table<'a> {
    card: &'a Card,
    set: &'a Settings,
    model: Model,
    rungs: Vec<Rung>,
    /// Trial and rest places of each rung.
    origins: Vec<(String, Vec<Point2>)>,
    search: Search,
    nominal: [Pascal; 2],
}

/// What one point of a search showed, kept for the landscape.
struct Told {
    at: Vec<f64>,
    markers: Vec<Vec<Point2>>,
}

impl<'a> Table<'a> {
    fn new(of: &'a Specimen, set: &'a Settings, mesh: &Mesh, films: &Learning<Motion>) -> Outcome<Self> {
        let (mut all, mut origins) = (Vec::new(), Vec::new());
        for (trial, motion) in &films.0 {
            let rungs = rungs(motion, set.settled, set.shortest_hold).map_err(|f| f.of(&trial.trial.id))?;
            origins.extend(rungs.iter().map(|_| (trial.trial.id.clone(), motion.rest.clone())));
            all.extend(rungs);
        }
        if all.is_empty() {
            return Err(no_film(of));
        }
        let solid = &of.card.solid;
        let nominal = [solid.body.youngs_modulus, solid.spine.youngs_modulus];
        let bound = |k: usize| [&solid.body, &solid.spine].map(|s| (s.plausible[k] / s.youngs_modulus).ln()).to_vec();
        let bounds = Bounds { low: bound(0), high: bound(1) };
        let search = Search::new(&["body", "spine"], vec![0.0; 2], bounds).map_err(Fault::from_tool)?;
        let model = Model::new(mesh, &of.card)?;
        Ok(Self { card: &of.card, set, model, rungs: all, origins, search, nominal })
    }

    fn moduli(&self, at: &[f64]) -> [Pascal; 2] {
        [self.nominal[0] * at[0].exp(), self.nominal[1] * at[1].exp()]
    }

    fn point(&self, at: &[f64]) -> Point {
        let [body_e_pa, spine_e_pa] = self.moduli(at);
        Point { body_e_pa, spine_e_pa }
    }

    fn ladder(&self) -> Ladder {
        let settings = StaticSettings { tolerance: self.set.static_tolerance, ..StaticSettings::default() };
        Ladder::new(self.model.clone(), self.rungs.clone(), settings, self.set.side_by_side)
    }

    /// Runs one method over the plane; a batch is walked from near point to near point.
    fn search(&self, member: &optimisers::Member) -> Outcome<(History, Vec<Told>)> {
        let mut optimiser = (member.build)(&self.search, &self.methods()).map_err(Fault::from_tool)?;
        let mut ladder = self.ladder();
        let mut told = Vec::new();
        let mut problem = |batch: &[Vec<f64>], needs: Needs| -> Result<Vec<Evaluation>, Stop> {
            let mut answers: Vec<Option<Evaluation>> = vec![None; batch.len()];
            for i in near_to_near(batch) {
                let evaluation = self.evaluate(&mut ladder, &batch[i], needs, &mut told).map_err(Stop)?;
                answers[i] = Some(evaluation);
            }
            Ok(answers.into_iter().flatten().collect())
        };
        let history = fit::minimise(optimiser.as_mut(), &mut problem).map_err(|stop| stop.0)?;
        Ok((history, told))
    }

    fn methods(&self) -> optimisers::Settings {
        let set = self.set;
        optimisers::Settings {
            grid: grid::Settings { points_per_axis: set.grid_points },
            adam: adam::Settings {
                step: set.adam_step,
                step_decay: set.adam_step_decay,
                mean_memory: set.adam_mean_memory,
                square_memory: set.adam_square_memory,
                step_tolerance: set.step_tolerance,
                iterations: set.adam_iterations,
            },
            gauss_newton: gauss_newton::Settings {
                step_tolerance: set.step_tolerance,
                iterations: set.gauss_newton_iterations,
                ..gauss_newton::Settings::default()
            },
        }
    }

    fn evaluate(&self, ladder: &mut Ladder, at: &[f64], needs: Needs, told: &mut Vec<Told>) -> Outcome<Evaluation> {
        let want = match needs {
            Needs::Loss => Want::Nothing,
            Needs::Gradient => Want::Gradient,
            Needs::Residuals => Want::Slopes,
        };
        let [body, spine] = self.moduli(at);
        let levels = ladder.climb(body, spine, want)?;
        let markers: Vec<Vec<Point2>> = levels.iter().map(|l| l.markers.clone()).collect();
        let loss = landscape::loss(&self.rungs, &markers, self.card.length);
        told.push(Told { at: at.to_vec(), markers });
        Ok(Evaluation {
            at: at.to_vec(),
            loss,
            gradient: (want == Want::Gradient).then(|| self.gradient(&levels, [body, spine])),
            residuals: (want == Want::Slopes).then(|| self.residuals(&levels, [body, spine])),
        })
    }

    /// ∂loss/∂ln E.
    fn gradient(&self, levels: &[Simulated], moduli: [Pascal; 2]) -> Vec<f64> {
        let sum = |k: usize| levels.iter().map(|l| l.gradient[k]).sum::<f64>();
        (0..2).map(|k| sum(k) * moduli[k] / self.card.length).collect()
    }

    /// Simulated less measured, over the standard deviation, and its slope by ln E.
    fn residuals(&self, levels: &[Simulated], moduli: [Pascal; 2]) -> Residuals {
        let (mut values, mut jacobian) = (Vec::new(), Vec::new());
        for (level, rung) in levels.iter().zip(&self.rungs) {
            for (m, (simulated, measured)) in level.markers.iter().zip(&rung.measured).enumerate() {
                for k in 0..2 {
                    values.push((simulated[k] - measured[k]) / self.set.discrepancy);
                    jacobian.extend((0..2).map(|e| level.slopes[e][m][k] * moduli[e] / self.set.discrepancy));
                }
            }
        }
        Residuals { values, jacobian }
    }

    fn record(&self, method: &str, history: &History, seconds: Second) -> records::Search {
        let tried = history.tried.iter().map(|t| Tried { at: self.point(&t.evaluation.at), loss: t.evaluation.loss });
        records::Search { method: method.into(), tried: tried.collect(), seconds }
    }

    /// Adjoint gradient against central differences at the nominal moduli, over the size of the gradient.
    fn gradient_difference(&self) -> Outcome<f64> {
        let mut ladder = self.ladder();
        let mut loss = |at: [f64; 2], needs: Needs| self.evaluate(&mut ladder, &at, needs, &mut Vec::new());
        let adjoint = loss([0.0; 2], Needs::Gradient)?.gradient.unwrap_or_default();
        let size = adjoint.iter().fold(0.0_f64, |s, g| s.max(g.abs()));
        let mut worst = 0.0_f64;
        for k in 0..2 {
            let mut at = |sign: f64| {
                let mut at = [0.0; 2];
                at[k] = sign * DIFFERENCE;
                loss(at, Needs::Loss).map(|e| e.loss)
            };
            let difference = (at(1.0)? - at(-1.0)?) / (2.0 * DIFFERENCE);
            worst = worst.max((difference - adjoint[k]).abs() / size);
        }
        Ok(worst)
    }

    fn conclude(
        &self,
        history: &History,
        told: &[Told],
        searches: Vec<records::Search>,
        gradient_difference: f64,
        desk: &dyn Desk,
    ) -> Outcome<Identified> {
        desk.progress(0.95, "at the identified moduli");
        let best = &history.best;
        let [body, spine] = self.moduli(&best.at);
        let levels = self.ladder().climb(body, spine, Want::Gradient)?;
        let covariance = best.residuals.as_ref().map(|r| r.covariance(2)).transpose().map_err(Fault::from_tool)?;
        let sigma = |k: usize| covariance.as_ref().map_or(f64::NAN, |c| c.sigma(k));
        let seconds = |part: fn(&Simulated) -> f64| levels.iter().map(part).sum::<f64>();
        let (forward, derivative) = (seconds(|l| l.forward_seconds), seconds(|l| l.derivative_seconds));
        let markers: Vec<Vec<Point2>> = levels.iter().map(|l| l.markers.clone()).collect();
        let highest = levels.iter().zip(&self.rungs).max_by(|a, b| top(a.1).total_cmp(&top(b.1)));
        Ok(Identified {
            best: self.point(&best.at),
            sigma: Point { body_e_pa: body * sigma(0), spine_e_pa: spine * sigma(1) },
            loss: landscape::loss(&self.rungs, &markers, self.card.length),
            gradient_difference,
            gradient_over_forward: (forward + derivative) / forward,
            searches,
            surface: self.surface(told),
            levels: self.levels(&markers),
            inflated: highest.map(|(level, _)| by_node(&level.displacement)).unwrap_or_default(),
            length: self.card.length,
        })
    }

    fn surface(&self, told: &[Told]) -> records::Surface {
        let points: Vec<(&[f64], &[Vec<Point2>])> = told.iter().map(|t| (t.at.as_slice(), t.markers.as_slice())).collect();
        let fine = landscape::between(&points, self.set.landscape_points, &self.rungs, self.card.length);
        records::Surface {
            body_e_pa: fine.across.iter().map(|x| self.nominal[0] * x.exp()).collect(),
            spine_e_pa: fine.up.iter().map(|y| self.nominal[1] * y.exp()).collect(),
            loss: fine.loss,
        }
    }

    fn levels(&self, markers: &[Vec<Point2>]) -> Vec<Level> {
        let all = self.rungs.iter().zip(markers).zip(&self.origins);
        all.map(|((rung, simulated), (trial, rest))| Level {
            trial: trial.clone(),
            pressures_pa: rung.pressures.clone(),
            rest_m: rest.clone(),
            measured_m: rung.measured.clone(),
            simulated_m: simulated.clone(),
        })
        .collect()
    }
}

/// Step of the central differences, in logarithms of moduli: its truncation error is far below the solver's tolerance.
const DIFFERENCE: f64 = 1e-3;

/// A fault on its way through an optimiser.
struct Stop(Fault);

impl From<FitError> for Stop {
    fn from(error: FitError) -> Self {
        Self(Fault::from_tool(error))
    }
}

fn top(rung: &Rung) -> Pascal {
    rung.pressures.iter().copied().fold(f64::MIN, f64::max)
}

/// An order of points in which each is the nearest of those left to the one before.
fn near_to_near(points: &[Vec<f64>]) -> Vec<usize> {
    let distance = |a: usize, b: usize| -> f64 { points[a].iter().zip(&points[b]).map(|(x, y)| (x - y).powi(2)).sum() };
    let mut left: Vec<usize> = (0..points.len()).rev().collect();
    let mut order: Vec<usize> = left.pop().into_iter().collect();
    while let Some(&here) = order.last() {
        let Some(next) = (0..left.len()).min_by(|&a, &b| distance(here, left[a]).total_cmp(&distance(here, left[b])))
        else {
            break;
        };
        order.push(left.remove(next));
    }
    order
}

fn no_film(of: &Specimen) -> Fault {
    Fault::new(
        format!("`{}` has no trial to identify from", of.card.name),
        "no [[trial]] on its card has role = \"identify\"",
        "give a staircase that role",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_batch_is_walked_without_leaps() {
        let grid: Vec<Vec<f64>> =
            (0..5).flat_map(|i| (0..5).map(move |j| vec![f64::from(i), f64::from(j)])).collect();
        let order = near_to_near(&grid);
        let leap = |w: &[usize]| (0..2).map(|k| (grid[w[0]][k] - grid[w[1]][k]).powi(2)).sum::<f64>();
        assert!(order.windows(2).all(|w| leap(w) <= 1.0), "{order:?}");
    }
}
