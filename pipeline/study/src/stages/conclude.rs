//! Concluding: what the searches found becomes the record: the moduli and their certainty, the landscape, the levels as simulated.
//!
//! Stands on: fitting, the landscape, certainty. Never knows: how a search went on.

use fit::Bounds;
use fit::optimisers::grid;
use si::Point2;

use super::fitting::{Fitting, Searched, Told};
use super::{certainty, landscape};
use crate::fault::Outcome;
use crate::model::{Want, by_node};
use crate::records::{self, Identified, Level, Point};
use crate::stage::Desk;

impl Fitting<'_> {
    /// The record, from the best of the last search and what the grid showed.
    ///
    /// # Errors
    /// A [`Fault`] when there is no equilibrium at the best moduli, or the data do not fix them.
    pub fn conclude(
        &self,
        mut found: Searched,
        told: &[Told],
        searches: Vec<records::Search>,
        gradient_difference: Option<f64>,
        desk: &dyn Desk,
    ) -> Outcome<Identified> {
        desk.progress(0.95, "at the identified moduli");
        let best = &found.history.best;
        let elastic = self.elastic(&best.at);
        let levels = found.ladder.climb(&elastic, Want::Nothing)?;
        let markers: Vec<Vec<Point2>> = levels.iter().map(|l| l.markers.clone()).collect();
        let highest = levels.iter().zip(&self.levels.rungs).max_by(|a, b| a.1.top().total_cmp(&b.1.top()));
        let certainty = certainty::of(self.card, best, &self.search)?;
        let [body, spine] = [0, 1].map(|k| elastic.youngs_moduli[k] * certainty.sigma[k]);
        let (surface, profiles) = self.surface(told)?;
        Ok(Identified {
            best: self.point(&best.at),
            sigma: Point { body_e_pa: body, spine_e_pa: spine },
            loss: self.levels.loss(&markers),
            gradient_difference,
            gradient_over_forward: self.gradient_over_forward(&elastic)?,
            searches,
            surface,
            levels: self.shown(&markers),
            inflated: highest.map(|(level, _)| by_node(&level.displacement)).unwrap_or_default(),
            length: self.card.length,
            doubt: self.doubt,
            certainty,
            profiles,
        })
    }

    /// The landscape and the profiles between the grid's points, a lone one without equilibrium carried on from its row; the grid's own
    /// losses where more are missing, nothing where no grid was searched.
    fn surface(&self, told: &[Told]) -> Outcome<(records::Surface, Vec<records::Profile>)> {
        if told.is_empty() {
            return Ok((records::Surface::default(), Vec::new()));
        }
        let Bounds { low, high } = self.search.bounds();
        let axis = |k: usize| grid::axis(low[k], high[k], self.set.grid_points);
        let points: Vec<(&[f64], &[Vec<Point2>])> =
            told.iter().map(|t| (t.at.as_slice(), t.markers.as_slice())).collect();
        let Some(full) = landscape::completed(&points, &axis(0), &axis(1)) else {
            return Ok((self.coarse(told, &axis(0), &axis(1)), Vec::new()));
        };
        let points: Vec<(&[f64], &[Vec<Point2>])> = full.iter().map(|(at, m)| (at.as_slice(), m.as_slice())).collect();
        let judge = |at: &[Vec<Point2>]| vec![self.levels.loss(at), self.levels.chi_square(at).unwrap_or(f64::NAN)];
        let fine = landscape::between(&points, self.set.landscape_points, &judge);
        let moduli = self.model.nominal.youngs_moduli;
        let along = |axis: &[f64], k: usize| axis.iter().map(|x| moduli[k] * x.exp()).collect::<Vec<f64>>();
        let (body_e_pa, spine_e_pa) = (along(&fine.across, 0), along(&fine.up, 1));
        let profiles = certainty::profiles(&body_e_pa, &spine_e_pa, &fine.values[1]);
        Ok((records::Surface { body_e_pa, spine_e_pa, loss: fine.values[0].clone() }, profiles))
    }

    fn coarse(&self, told: &[Told], across: &[f64], up: &[f64]) -> records::Surface {
        let loss = |x: f64, y: f64| {
            let here = told.iter().find(|t| t.at == [x, y]);
            here.map_or(f64::NAN, |t| self.levels.loss(&t.markers))
        };
        records::Surface {
            body_e_pa: across.iter().map(|&x| self.point(&[x, 0.0]).body_e_pa).collect(),
            spine_e_pa: up.iter().map(|&y| self.point(&[0.0, y]).spine_e_pa).collect(),
            loss: up.iter().flat_map(|&y| across.iter().map(move |&x| (x, y))).map(|(x, y)| loss(x, y)).collect(),
        }
    }

    fn shown(&self, markers: &[Vec<Point2>]) -> Vec<Level> {
        let all = self.levels.rungs.iter().zip(markers).zip(&self.origins);
        all.map(|((rung, simulated), (trial, rest))| Level {
            trial: trial.clone(),
            pressures_pa: rung.pressures.clone(),
            rest_m: rest.clone(),
            measured_m: rung.measured.clone(),
            spread_m2: rung.spread.clone(),
            simulated_m: simulated.clone(),
        })
        .collect()
    }
}
