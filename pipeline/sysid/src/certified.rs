//! Searches in a reduced model, certified by the whole body at their ends.
//!
//! The whole body is solved where a search begins; its equilibria and their derivatives train a reduced model, in which the search takes
//! seconds. At its end the whole body is solved again: where a marker differs by more than a tenth of its deviation, those equilibria enrich
//! the model and the search is repeated.

use serde::{Deserialize, Serialize};
use si::{Metre, Point2};

use crate::levels::{Derivatives, LevelSolver, PressureLevel, SimulatedLevel};
use crate::model::Elastic;
use diagnostics::Result;

/// Searches at most.
const ROUNDS: usize = 3;
/// The difference of a marker, over its deviation, from which the model is enriched.
const ENOUGH: f64 = 0.1;

/// How far a reduced model may be trusted at the answer of a search.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Certificate {
    /// The largest difference of a marker's displacement from that of the whole body at the answer, over its deviation.
    pub sigma: f64,
    /// Searches.
    pub rounds: usize,
    /// Equilibria of the whole body, those on paths between levels left out.
    pub whole_equilibria: usize,
}

impl Certificate {
    /// Whether no marker differs by more than a tenth of its deviation.
    pub fn holds(&self) -> bool {
        self.sigma < ENOUGH
    }
}

/// The end of a search with the whole body there.
pub struct Certified<T> {
    /// The constants there.
    pub elastic: Elastic,
    /// What the search found.
    pub found: T,
    /// The whole body there.
    pub levels: Vec<SimulatedLevel>,
    /// How far the end may be trusted.
    pub certificate: Certificate,
}

/// A search that is certified.
#[derive(Debug, Clone)]
pub struct CertifiedSearch {
    /// Where the reduced model is trained first.
    pub start: Elastic,
    /// By what the whole body's equilibria are derived, so that the model knows how shapes change with the constants that are searched.
    pub derivatives: Derivatives,
    /// Standard deviation of a displacement beside that of its measurement, m.
    pub discrepancy: Metre,
}

impl CertifiedSearch {
    /// Repeats the `search` in reduced models of the `whole` body until that body certifies its end. `progress` is called before each.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when the whole body has no equilibrium at the start or at an end, cannot be reduced, or the search fails.
    pub fn run<T>(
        &self,
        whole: &mut LevelSolver,
        search: &mut dyn FnMut(&mut LevelSolver) -> Result<(Elastic, T)>,
        progress: &dyn Fn(usize),
    ) -> Result<Certified<T>> {
        let (mut elastic, mut rounds) = (self.start.clone(), 0);
        let mut levels = whole.solve(&elastic, self.derivatives)?;
        loop {
            rounds += 1;
            progress(rounds);
            let mut reduced = whole.reduced()?;
            reduced.correct(&elastic, &levels)?;
            let found;
            (elastic, found) = search(&mut reduced)?;
            let predicted = reduced.solve(&elastic, Derivatives::None)?;
            whole.guess(&elastic, &predicted);
            levels = whole.solve(&elastic, self.derivatives)?;
            let sigma = self.difference(whole.levels(), (&predicted, &levels));
            let certificate = Certificate { sigma, rounds, whole_equilibria: (rounds + 1) * levels.len() };
            if certificate.holds() || rounds == ROUNDS {
                return Ok(Certified { elastic, found, levels, certificate });
            }
        }
    }

    /// The largest difference of two displacements of a marker over its deviation.
    fn difference(&self, measured: &[PressureLevel], (a, b): (&[SimulatedLevel], &[SimulatedLevel])) -> f64 {
        let mut largest: f64 = 0.0;
        for (level, (a, b)) in measured.iter().zip(a.iter().zip(b)) {
            for ((a, b), covariance) in a.markers.iter().zip(&b.markers).zip(&level.covariance) {
                largest = largest.max(self.standardised(a, b, [covariance[0], covariance[2]]));
            }
        }
        largest
    }

    fn standardised(&self, a: &Point2, b: &Point2, variances: [f64; 2]) -> f64 {
        let of_axis = |axis: usize| (a[axis] - b[axis]).abs() / variances[axis].sqrt().hypot(self.discrepancy);
        of_axis(0).max(of_axis(1))
    }
}
