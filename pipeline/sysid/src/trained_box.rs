//! A reduced model of a body over a box of moduli, in which many methods search and a whole landscape is simulated.
//!
//! The whole body teaches it along the path of rising pressure to the softest body of the box, at the middle, and with the softest and the
//! stiffest of the other solids.

use optimize::Bounds;
use si::Second;

use crate::certified::{Certificate, ROUNDS, certify_end};
use crate::levels::{Derivatives, LevelSolver};
use crate::loss::{Loss, SearchResult};
use crate::model::Elastic;
use crate::search::feasible_lower_bound;
use diagnostics::Result;

/// A search and how long it took, s.
pub type TimedSearch = (SearchResult, Second);

/// The whole body and its reduced model.
pub struct TrainedBox<'a> {
    loss: &'a Loss<'a>,
    whole: LevelSolver,
    reduced: LevelSolver,
    middle: Elastic,
    certificate: Certificate,
    whole_seconds: Second,
}

impl<'a> TrainedBox<'a> {
    /// Trained over `bounds` of the logarithms of the moduli about a body with the constants `middle`; the lower bound of the softest solid
    /// becomes that of the bodies with an equilibrium at every level. `whole` knows no equilibrium yet.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when there is no equilibrium at the middle, or the body cannot be reduced.
    pub fn new(loss: &'a Loss<'a>, mut whole: LevelSolver, middle: Elastic, bounds: &mut Bounds) -> Result<Self> {
        bounds.low[0] = feasible_lower_bound(&mut whole, &middle, bounds)?;
        for corner in modulus_corners(bounds) {
            // what has no equilibrium teaches nothing, and its loss is infinite in every search
            let _ = whole.solve(&loss.elastic(&corner), Derivatives::Sensitivities);
        }
        let levels = whole.solve(&middle, Derivatives::Sensitivities)?;
        let mut reduced = whole.train_reduced()?;
        reduced.correct_markers(&middle, Derivatives::Sensitivities, &levels)?;
        Ok(Self { loss, whole, reduced, middle, certificate: Certificate::default(), whole_seconds: 0.0 })
    }

    /// The reduced model.
    pub fn reduced(&self) -> &LevelSolver {
        &self.reduced
    }

    /// How long the whole body takes for its equilibria at all levels, on average over the ends that were certified, s of one core.
    pub fn whole_seconds(&self) -> Second {
        self.whole_seconds
    }

    /// The searches that `run` makes in the reduced model, certified at their ends: where the whole body differs there, it enriches the model
    /// and they are run again.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when a search fails or the whole body has no equilibrium at its end.
    pub fn certified(
        &mut self,
        run: &mut dyn FnMut(&LevelSolver) -> Result<Vec<TimedSearch>>,
    ) -> Result<(Vec<TimedSearch>, Certificate)> {
        loop {
            self.certificate = Certificate { rounds: self.certificate.rounds + 1, sigma: 0.0, ..self.certificate };
            self.whole_seconds = 0.0;
            let searches = run(&self.reduced)?;
            for (search, _) in &searches {
                self.certify_search(&self.loss.elastic(&search.history.best.at), searches.len())?;
            }
            if self.certificate.holds() || self.certificate.rounds == ROUNDS {
                return Ok((searches, self.certificate));
            }
            let levels = self.whole.solve(&self.middle, Derivatives::Sensitivities)?;
            self.reduced = self.whole.train_reduced()?;
            self.reduced.correct_markers(&self.middle, Derivatives::Sensitivities, &levels)?;
        }
    }

    /// Certifies one of so many `ends`.
    fn certify_search(&mut self, elastic: &Elastic, ends: usize) -> Result<()> {
        let certification = (Derivatives::Sensitivities, self.loss.misfit.discrepancy());
        let (levels, sigma) = certify_end((&mut self.whole, &mut self.reduced), elastic, certification)?;
        self.certificate.sigma = self.certificate.sigma.max(sigma);
        self.certificate.whole_equilibria += levels.len();
        self.whole_seconds += levels.iter().map(|level| level.forward_seconds).sum::<Second>() / ends as f64;
        Ok(())
    }
}

/// With the softest body, the softest and the stiffest of the other solids.
fn modulus_corners(bounds: &Bounds) -> [Vec<f64>; 2] {
    [&bounds.low, &bounds.high].map(|bound| bounds.low.iter().take(1).chain(bound.iter().skip(1)).copied().collect())
}
