//! Levels: what the films of a specimen showed at each held pressure, how sure that is, and how far a simulation is from it.
//!
//! The covariance of a film's displacements has three parts: the markers' own (pixels, camera), what the model leaves out at
//! each place, and a share by which all displacements of a film are off together (walls not as drawn, a valve's supply). The
//! films' shares are independent, so films of both sides together know the moduli better than either alone.
//!
//! Stands on: the ladder, fit's weighing. Never knows: an optimiser, a trial's role.

use fit::{Residuals, Weighing};
use si::{Metre, Point2};

use super::landscape;
use crate::fault::{Fault, Outcome};
use crate::model::{Rung, Simulated};
use crate::records::{Doubt, Level};

/// The levels of all films, film after film.
pub struct Levels {
    /// The levels.
    pub rungs: Vec<Rung>,
    weighing: Weighing,
    length: Metre,
}

impl Levels {
    /// Levels whose films are so many levels long.
    ///
    /// # Errors
    /// A [`Fault`] when the covariance of a film is none.
    pub fn new(rungs: Vec<Rung>, films: &[usize], doubt: &Doubt, length: Metre) -> Outcome<Self> {
        let mut first = 0;
        let blocks = films.iter().map(|&count| {
            first += count;
            covariance(&rungs[first - count..first], doubt)
        });
        let weighing = Weighing::new(&blocks.collect::<Vec<_>>()).map_err(Fault::from_tool)?;
        Ok(Self { rungs, weighing, length })
    }

    /// The levels that an identification kept.
    ///
    /// # Errors
    /// As [`Levels::new`].
    pub fn kept(levels: &[Level], doubt: &Doubt, length: Metre) -> Outcome<Self> {
        let films: Vec<usize> = levels.chunk_by(|a, b| a.trial == b.trial).map(<[Level]>::len).collect();
        let rung = |l: &Level| Rung {
            pressures: l.pressures_pa.clone(),
            measured: l.measured_m.clone(),
            spread: l.spread_m2.clone(),
        };
        Self::new(levels.iter().map(rung).collect(), &films, doubt, length)
    }

    /// Mean distance of simulated from measured displacements over the specimen's length.
    pub fn loss(&self, simulated: &[Vec<Point2>]) -> f64 {
        landscape::loss(&self.rungs, simulated, self.length)
    }

    /// Simulated less measured in deviations; `turns` are the derivatives of the constants by the searched parameters, in
    /// the order of the simulated slopes.
    ///
    /// # Errors
    /// A [`Fault`] when the simulation is of other levels.
    pub fn residuals(&self, simulated: &[Simulated], turns: &[f64]) -> Outcome<Residuals> {
        let (mut values, mut jacobian) = (Vec::new(), Vec::new());
        for (level, rung) in simulated.iter().zip(&self.rungs) {
            for (m, (simulated, measured)) in level.markers.iter().zip(&rung.measured).enumerate() {
                for k in 0..2 {
                    values.push(simulated[k] - measured[k]);
                    jacobian.extend(turns.iter().zip(&level.slopes).map(|(turn, slope)| slope[m][k] * turn));
                }
            }
        }
        self.weighing.apply(&Residuals { values, jacobian }, turns.len()).map_err(Fault::from_tool)
    }

    /// χ² of simulated displacements.
    ///
    /// # Errors
    /// A [`Fault`] when the simulation is of other levels.
    pub fn chi_square(&self, simulated: &[Vec<Point2>]) -> Outcome<f64> {
        let pairs = simulated.iter().zip(&self.rungs).flat_map(|(s, rung)| s.iter().zip(&rung.measured));
        let values = pairs.flat_map(|(s, m)| [s[0] - m[0], s[1] - m[1]]).collect();
        let weighed = self.weighing.apply(&Residuals { values, jacobian: Vec::new() }, 0).map_err(Fault::from_tool)?;
        Ok(2.0 * weighed.half_square())
    }
}

/// Of one film's displacements, row after row: levels × markers × 2.
fn covariance(film: &[Rung], doubt: &Doubt) -> Vec<f64> {
    let moved: Vec<f64> = film.iter().flat_map(|r| r.measured.iter().flat_map(|p| *p)).collect();
    let spread: Vec<[f64; 3]> = film.iter().flat_map(|r| r.spread.iter().copied()).collect();
    let own = |i: usize, j: usize| match (i / 2 == j / 2, i % 2, j % 2) {
        (false, ..) => 0.0,
        (_, 0, 0) => spread[i / 2][0] + doubt.discrepancy_m.powi(2),
        (_, 1, 1) => spread[i / 2][2] + doubt.discrepancy_m.powi(2),
        _ => spread[i / 2][1],
    };
    let entry = |i: usize, j: usize| own(i, j) + doubt.share.powi(2) * moved[i] * moved[j];
    (0..moved.len()).flat_map(|i| (0..moved.len()).map(move |j| (i, j))).map(|(i, j)| entry(i, j)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rung(moved: Point2) -> Rung {
        Rung { pressures: vec![1.0], measured: vec![moved], spread: vec![[1e-10, 2e-11, 4e-10]] }
    }

    #[test]
    fn a_share_that_a_whole_film_is_off_by_costs_little() {
        let doubt = Doubt { discrepancy_m: 1e-5, share: 0.02 };
        let films = vec![rung([1e-3, 5e-3]), rung([2e-3, 9e-3])];
        let levels = Levels::new(films.clone(), &[2], &doubt, 0.1).unwrap();
        let off = |by: [f64; 2]| -> Vec<Vec<Point2>> {
            films.iter().zip(by).map(|(r, b)| vec![r.measured[0].map(|v| (1.0 + b) * v)]).collect()
        };
        // one deviation of the share that both have in common
        assert!((levels.chi_square(&off([0.02, 0.02])).unwrap() - 1.0).abs() < 0.1);
        assert!(levels.chi_square(&off([0.02, -0.02])).unwrap() > 50.0);
    }

    #[test]
    fn a_markers_own_covariance_is_taken_whole() {
        let doubt = Doubt { discrepancy_m: 1e-5, share: 0.0 };
        let levels = Levels::new(vec![rung([0.0, 0.0])], &[1], &doubt, 0.1).unwrap();
        // S = [[2, 0.2], [0.2, 5]] e-10; r = (1e-5, 0): r S⁻¹ r = 5 / (10 − 0.04)
        let found = levels.chi_square(&[vec![[1e-5, 0.0]]]).unwrap();
        assert!((found - 5.0 / 9.96).abs() < 1e-9, "{found}");
    }
}
