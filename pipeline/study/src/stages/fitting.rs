//! Fitting: the levels of all films of a specimen, the model that simulates them, and the plane of moduli to be searched.
//!
//! Stands on: the ladder, the landscape, fit. Never knows: which methods there are.

use fem::StaticSettings;
use fit::optimisers::{self, adam, gauss_newton, grid};
use fit::{Bounds, Evaluation, FitError, History, Needs, Residuals, Search};
use lab::card::Card;
use si::{Pascal, Point2, Second};

use super::identify::Settings;
use super::landscape;
use super::plateaus::rungs;
use crate::fault::{Fault, Outcome};
use crate::model::{Ladder, Model, Rung, Simulated, Want, by_node};
use crate::needs::Learning;
use crate::records::{self, Identified, Level, Mesh, Motion, Point, Tried};
use crate::stage::Desk;
use crate::subject::Specimen;

/// Everything that a search needs to simulate.
pub struct Fitting<'a> {
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
pub struct Told {
    at: Vec<f64>,
    markers: Vec<Vec<Point2>>,
}

impl<'a> Fitting<'a> {
    /// The levels of all films, the model, and the plane to be searched.
    ///
    /// # Errors
    /// A [`Fault`] when there is no film, a film holds no pressure, or the simulator refuses the mesh.
    pub fn new(of: &'a Specimen, set: &'a Settings, mesh: &Mesh, films: &Learning<Motion>) -> Outcome<Self> {
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

    fn ladder(&self, tolerance: f64) -> Ladder {
        let settings = StaticSettings { tolerance, halvings: HALVINGS, ..StaticSettings::default() };
        Ladder::new(self.model.clone(), self.rungs.clone(), settings, self.set.side_by_side)
    }

    /// Runs one method over the plane; a batch is walked from near point to near point.
    ///
    /// # Errors
    /// A [`Fault`] when the method cannot go on, or Adam meets a point without equilibrium.
    pub fn search(&self, member: &optimisers::Member) -> Outcome<(History, Vec<Told>)> {
        let mut optimiser = (member.build)(&self.search, &self.methods()).map_err(Fault::from_tool)?;
        let mut ladder = self.ladder(self.set.static_tolerance);
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
        let levels = match ladder.climb(body, spine, want) {
            Err(_) if want != Want::Gradient => return Ok(Evaluation::of_loss(at.to_vec(), f64::INFINITY)),
            levels => levels?,
        };
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

    /// How the method went, as it is kept.
    pub fn record(&self, method: &str, history: &History, seconds: Second) -> records::Search {
        let tried = history.tried.iter().map(|t| Tried { at: self.point(&t.evaluation.at), loss: t.evaluation.loss });
        records::Search { method: method.into(), tried: tried.collect(), seconds }
    }

    /// Adjoint gradient against central differences at the nominal moduli, over the size of the gradient.
    ///
    /// # Errors
    /// A [`Fault`] when there is no equilibrium at the nominal moduli.
    pub fn gradient_difference(&self) -> Outcome<f64> {
        let mut ladder = self.ladder(EXACT);
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

    /// The record, from the best of the last search and what the grid showed.
    ///
    /// # Errors
    /// A [`Fault`] when there is no equilibrium at the best moduli, or the data do not fix them.
    pub fn conclude(
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
        let levels = self.ladder(self.set.static_tolerance).climb(body, spine, Want::Gradient)?;
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

    /// The landscape between the grid's points; the grid's own losses where some point has no equilibrium.
    fn surface(&self, told: &[Told]) -> records::Surface {
        let Bounds { low, high } = self.search.bounds();
        let axis = |k: usize| grid::axis(low[k], high[k], self.set.grid_points);
        if told.len() < self.set.grid_points * self.set.grid_points {
            return self.coarse(told, &axis(0), &axis(1));
        }
        let points: Vec<(&[f64], &[Vec<Point2>])> =
            told.iter().map(|t| (t.at.as_slice(), t.markers.as_slice())).collect();
        let fine = landscape::between(&points, self.set.landscape_points, &self.rungs, self.card.length);
        records::Surface {
            body_e_pa: fine.across.iter().map(|x| self.nominal[0] * x.exp()).collect(),
            spine_e_pa: fine.up.iter().map(|y| self.nominal[1] * y.exp()).collect(),
            loss: fine.loss,
        }
    }

    fn coarse(&self, told: &[Told], across: &[f64], up: &[f64]) -> records::Surface {
        let loss = |x: f64, y: f64| {
            let here = told.iter().find(|t| t.at == [x, y]);
            here.map_or(f64::NAN, |t| landscape::loss(&self.rungs, &t.markers, self.card.length))
        };
        records::Surface {
            body_e_pa: across.iter().map(|x| self.nominal[0] * x.exp()).collect(),
            spine_e_pa: up.iter().map(|y| self.nominal[1] * y.exp()).collect(),
            loss: up.iter().flat_map(|&y| across.iter().map(move |&x| (x, y))).map(|(x, y)| loss(x, y)).collect(),
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

/// A level whose load steps must be halved more often than this has given way: a search has better points to try.
const HALVINGS: usize = 2;

/// Tolerance of the equilibria between which differences are taken, as a part of the specimen's size.
const EXACT: f64 = 1e-9;

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
        let grid: Vec<Vec<f64>> = (0..5).flat_map(|i| (0..5).map(move |j| vec![f64::from(i), f64::from(j)])).collect();
        let order = near_to_near(&grid);
        let leap = |w: &[usize]| (0..2).map(|k| (grid[w[0]][k] - grid[w[1]][k]).powi(2)).sum::<f64>();
        assert!(order.windows(2).all(|w| leap(w) <= 1.0), "{order:?}");
    }
}
