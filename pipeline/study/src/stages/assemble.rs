//! Assembly of the record of [`super::identify`]: moduli and their uncertainty, landscape, simulated levels.

use optimize::optimisers::grid;
use optimize::{Bounds, Evaluation, Residuals};
use si::{Pascal, Point2};

use super::fitting::{Evaluated, Fitting, SearchResult};
use crate::records::{self, Identified, Level};
use diagnostics::Result;
use sysid::landscape;
use sysid::uncertainty::{self, Posterior};
use sysid::{Derivatives, Model, Stiffened, by_node, residuals_of};
use workflow::stage::StageContext;

/// The results of all searches.
pub(super) struct Searches {
    /// Of Gauss-Newton.
    pub best: SearchResult,
    /// Evaluations of the grid; empty where none was searched.
    pub grid: Vec<Evaluated>,
    /// The record of each search.
    pub records: Vec<records::Search>,
    /// The model on a finer mesh, or why there is none.
    pub finer: Result<Model, String>,
}

impl Fitting<'_> {
    /// The record, from the best point of Gauss-Newton and the evaluations of the grid.
    ///
    /// # Errors
    /// A [`Diagnostic`] when there is no equilibrium at the best moduli, or the data do not determine them.
    pub fn assemble(
        &self,
        searches: Searches,
        gradient_difference: Option<f64>,
        context: &dyn StageContext,
    ) -> Result<Identified> {
        context.progress(0.95, "at the identified moduli");
        let Searches { best: mut found, grid, records, finer } = searches;
        let best = &found.history.best;
        let elastic = self.elastic(&best.at);
        let levels = found.solver.solve(&elastic, Derivatives::None)?;
        let markers: Vec<Vec<Point2>> = levels.iter().map(|l| l.markers.clone()).collect();
        let highest = levels.iter().zip(&self.levels.levels).max_by(|a, b| a.1.top().total_cmp(&b.1.top()));
        let residuals = self.residuals(best)?;
        let discretisation = self.discretisation(finer, &elastic, &markers, residuals);
        let discrepancy = self.estimated(residuals)?;
        let (covariance, chi_square) = discrepancy.posterior(&self.levels, residuals.0, residuals.1)?;
        let posterior = Posterior { covariance, discretisation, chi_square };
        let uncertainty = uncertainty::of(self.body, &posterior, (&best.at, self.search.bounds()));
        let (surface, profiles) = self.surface(&grid)?;
        Ok(Identified {
            solids: self.body.materials.iter().map(|m| m.name.clone()).collect(),
            sigma: elastic.youngs_moduli.iter().zip(&uncertainty.sigma).map(|(e, s)| e * s).collect(),
            best: elastic.youngs_moduli.clone(),
            stiffening: self.stiffening(&posterior),
            modulus_time: self.modulus_time,
            loss: self.levels.loss(&markers),
            gradient_difference,
            gradient_over_forward: self.gradient_over_forward(&elastic, context)?,
            searches: records,
            surface,
            levels: self.simulated_levels(&markers),
            inflated: highest.map(|(level, _)| by_node(&level.displacement)).unwrap_or_default(),
            length: self.body.length,
            noise: self.noise,
            discrepancy,
            uncertainty,
            profiles,
        })
    }

    /// Whitened residuals at the best point and the number of their parameters: the moduli's logarithms and, where the law stiffens, both
    /// ratios of stiffening.
    pub(super) fn residuals<'a>(&'a self, best: &'a Evaluation) -> Result<(&'a Residuals, usize)> {
        let solids = self.body.materials.len();
        Ok(match &self.stiffened {
            Some(together) => (&together.residuals, solids + together.ratios.len()),
            None => (residuals_of(best)?, solids),
        })
    }

    fn stiffening(&self, posterior: &Posterior) -> Option<records::Stiffening> {
        let solids = self.body.materials.len();
        let of = |found: &Stiffened| records::Stiffening {
            ratios: found.ratios,
            sigma: [0, 1].map(|term| posterior.covariance.sigma(solids + term)),
        };
        self.stiffened.as_ref().map(of)
    }

    /// The landscape and the profiles, interpolated between the grid's points. A single point without equilibrium is extrapolated from its
    /// row; where more are missing, the grid's own losses are kept. Empty where no grid was searched, or not over two moduli.
    fn surface(&self, evaluated: &[Evaluated]) -> Result<(records::Surface, Vec<records::Profile>)> {
        let [first, second] = self.body.materials.as_slice() else {
            return Ok((records::Surface::default(), Vec::new()));
        };
        if evaluated.is_empty() {
            return Ok((records::Surface::default(), Vec::new()));
        }
        let Bounds { low, high } = self.search.bounds();
        let axis = |k: usize| grid::axis(low[k], high[k], self.set.grid_points);
        let points: Vec<(&[f64], &[Vec<Point2>])> =
            evaluated.iter().map(|t| (t.at.as_slice(), t.markers.as_slice())).collect();
        let Some(full) = landscape::completed(&points, &axis(0), &axis(1)) else {
            return Ok((self.coarse(evaluated, &axis(0), &axis(1)), Vec::new()));
        };
        let points: Vec<(&[f64], &[Vec<Point2>])> = full.iter().map(|(at, m)| (at.as_slice(), m.as_slice())).collect();
        let judge = |at: &[Vec<Point2>]| vec![self.levels.loss(at), self.levels.chi_square(at).unwrap_or(f64::NAN)];
        let fine = landscape::between(&points, self.set.landscape_points, &judge);
        let moduli = &self.model.nominal.youngs_moduli;
        let along = |axis: &[f64], k: usize| axis.iter().map(|x| moduli[k] * x.exp()).collect::<Vec<f64>>();
        let (across, up) = (along(&fine.across, 0), along(&fine.up, 1));
        let profiles = uncertainty::profiles([&first.name, &second.name], [&across, &up], &fine.values[1]);
        let critical = critical_pressures(evaluated, (&axis(0), &axis(1)), (&fine.across, &fine.up));
        Ok((records::Surface { across, up, loss: fine.values[0].clone(), critical }, profiles))
    }

    fn coarse(&self, evaluated: &[Evaluated], across: &[f64], up: &[f64]) -> records::Surface {
        let loss = |x: f64, y: f64| {
            let here = evaluated.iter().find(|t| t.at == [x, y]);
            here.map_or(f64::NAN, |t| self.levels.loss(&t.markers))
        };
        records::Surface {
            across: across.iter().map(|&x| self.elastic(&[x, 0.0]).youngs_moduli[0]).collect(),
            up: up.iter().map(|&y| self.elastic(&[0.0, y]).youngs_moduli[1]).collect(),
            loss: up.iter().flat_map(|&y| across.iter().map(move |&x| (x, y))).map(|(x, y)| loss(x, y)).collect(),
            critical: critical_pressures(evaluated, (across, up), (across, up)),
        }
    }

    fn simulated_levels(&self, markers: &[Vec<Point2>]) -> Vec<Level> {
        let all = self.levels.levels.iter().zip(markers).zip(&self.origins);
        all.map(|((model, simulated), (trial, rest))| Level {
            trial: trial.clone(),
            pressures_pa: model.pressures.clone(),
            rest_m: rest.clone(),
            measured_m: model.measured.clone(),
            covariance_m2: model.covariance.clone(),
            shared_m2: model.shared.clone(),
            simulated_m: simulated.clone(),
        })
        .collect()
    }
}

/// The pressures at which the slack walls buckle over both moduli, between those of the grid's points, Pa; 0 where one beside it does not.
fn critical_pressures(evaluated: &[Evaluated], coarse: (&[f64], &[f64]), fine: (&[f64], &[f64])) -> Vec<Pascal> {
    let at = |x: f64, y: f64| evaluated.iter().find(|t| t.at == [x, y]).and_then(|t| t.critical).unwrap_or(f64::NAN);
    landscape::linear(coarse, &at, fine).into_iter().map(|p| if p.is_nan() { 0.0 } else { p }).collect()
}
