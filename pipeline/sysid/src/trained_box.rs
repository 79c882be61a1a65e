//! A reduced model of a body over a box of moduli, in which many methods search and a whole landscape is simulated.
//!
//! The whole body teaches it along the path of rising pressure to the softest body of the box, at the middle, and with the softest and the
//! stiffest of the other solids.

use optimize::Bounds;
use si::Second;

use crate::certified::{Certificate, certify_end, largest_standardised};
use crate::levels::{Derivatives, LevelSolver, SimulatedLevel};
use crate::loss::{Loss, SearchResult};
use crate::model::Elastic;
use crate::search::feasible_lower_bound;
use diagnostics::Result;

/// A search and how long it took, s.
pub type TimedSearch = (SearchResult, Second);

/// Rounds at most: each repeats all searches of a comparison, which takes minutes.
const ROUNDS: usize = 3;

/// Ends whose markers are nearer to each other than this part of their deviations share the whole body's equilibria: methods that find one minimum
/// end a step apart, and each end costs the whole body all levels.
const SHARED: f64 = 1.0;

/// The whole body at the end of a search.
struct CertifiedEnd {
    elastic: Elastic,
    levels: Vec<SimulatedLevel>,
    round: usize,
}

/// The whole body and its reduced model.
pub struct TrainedBox<'a> {
    loss: &'a Loss<'a>,
    whole: LevelSolver,
    reduced: LevelSolver,
    middle: Elastic,
    certificate: Certificate,
    ends: Vec<CertifiedEnd>,
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
        Ok(Self { loss, whole, reduced, middle, certificate: Certificate::default(), ends: Vec::new() })
    }

    /// The reduced model.
    pub fn reduced(&self) -> &LevelSolver {
        &self.reduced
    }

    /// How long the whole body takes for its equilibria at all levels, on average over the ends where it was solved, s of one core.
    pub fn whole_seconds(&self) -> Second {
        let levels = self.ends.iter().flat_map(|end| &end.levels);
        levels.map(|level| level.forward_seconds).sum::<Second>() / self.ends.len().max(1) as f64
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
            let searches = run(&self.reduced)?;
            for (search, _) in &searches {
                let sigma = self.end_difference(&self.loss.elastic(&search.history.best.at))?;
                self.certificate.sigma = self.certificate.sigma.max(sigma);
            }
            if self.certificate.holds() || self.certificate.rounds == ROUNDS {
                return Ok((searches, self.certificate));
            }
            let levels = self.whole.solve(&self.middle, Derivatives::Sensitivities)?;
            self.reduced = self.whole.train_reduced()?;
            self.reduced.correct_markers(&self.middle, Derivatives::Sensitivities, &levels)?;
        }
    }

    /// The largest difference of a marker from the whole body at an end, over its deviation: by an end nearby where the whole body is known, and
    /// either certifies or was solved in this round; else by the whole body there.
    fn end_difference(&mut self, elastic: &Elastic) -> Result<f64> {
        let discrepancy = self.loss.misfit.discrepancy();
        let predicted = self.reduced.solve(elastic, Derivatives::None)?;
        for end in &self.ends {
            let nearby = self.reduced.solve(&end.elastic, Derivatives::None)?;
            let levels = self.whole.levels();
            let sigma = largest_standardised(levels, (&nearby, &end.levels), discrepancy);
            let is_shared = largest_standardised(levels, (&nearby, &predicted), discrepancy) < SHARED;
            if is_shared && (Certificate { sigma, ..self.certificate }.holds() || end.round == self.certificate.rounds)
            {
                return Ok(sigma);
            }
        }
        let certification = (Derivatives::Sensitivities, discrepancy);
        let (levels, sigma) = certify_end((&mut self.whole, &mut self.reduced), elastic, certification)?;
        self.certificate.whole_equilibria += levels.len();
        self.ends.push(CertifiedEnd { elastic: elastic.clone(), levels, round: self.certificate.rounds });
        Ok(sigma)
    }
}

/// With the softest body, the softest and the stiffest of the other solids.
fn modulus_corners(bounds: &Bounds) -> [Vec<f64>; 2] {
    [&bounds.low, &bounds.high].map(|bound| bounds.low.iter().take(1).chain(bound.iter().skip(1)).copied().collect())
}
