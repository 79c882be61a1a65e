//! Assembly of the record of [`super::identify`]: moduli and their uncertainty, simulated levels.

use optimize::Residuals;
use si::Point2;

use super::fitting::Fitting;
use diagnostics::Result;
use records::{self, IdentificationDurations, Identified, Level};
use sysid::uncertainty::{self, Posterior};
use sysid::{Minimum, Model, Stiffened, by_node, residuals_of};
use workflow::stage::StageContext;

impl Fitting<'_> {
    /// The record, from the best point of the search; `finer` is the model on a finer mesh, or why there is none.
    ///
    /// # Errors
    /// A [`Diagnostic`](diagnostics::Diagnostic) when there is no equilibrium at the best moduli, or the data do not determine them.
    pub(crate) fn assemble_record(
        &self,
        minimum: &Minimum,
        finer: Result<Model, String>,
        context: &dyn StageContext,
    ) -> Result<Identified> {
        context.progress(0.95, "at the identified moduli");
        let (loss, best, levels) = (&self.loss, &minimum.moduli.history.best, &minimum.levels);
        let (elastic, misfit) = (loss.elastic(&best.at), &loss.misfit);
        let markers: Vec<Vec<Point2>> = levels.iter().map(|l| l.markers.clone()).collect();
        let highest = levels.iter().zip(&misfit.levels).max_by(|a, b| a.1.top().total_cmp(&b.1.top()));
        let residuals = self.whitened_residuals(minimum)?;
        let discretisation = self.discretisation_error(finer, (&elastic, levels), residuals);
        let discrepancy = self.estimated_discrepancy(residuals)?;
        let (covariance, chi_square) = discrepancy.posterior(misfit, residuals.0, residuals.1)?;
        let posterior = Posterior { covariance, discretisation, chi_square };
        let uncertainty = uncertainty::of(loss.body, &posterior, (&best.at, minimum.problem.bounds()));
        Ok(Identified {
            solids: loss.body.materials.iter().map(|m| m.name.clone()).collect(),
            sigma: elastic.youngs_moduli.iter().zip(&uncertainty.sigma).map(|(e, s)| e * s).collect(),
            best: elastic.youngs_moduli.clone(),
            stiffening: self.stiffening_with_sigma(minimum, &posterior),
            certificate: minimum.certificate.clone(),
            modulus_time: self.modulus_time,
            loss: misfit.loss(&markers),
            durations: IdentificationDurations {
                gradient_over_forward: minimum.gradient_over_forward,
                search: minimum.durations,
            },
            levels: self.simulated_levels(&markers),
            inflated: highest.map(|(level, _)| by_node(&level.displacement)).unwrap_or_default(),
            length: loss.body.length,
            noise: self.noise,
            discrepancy,
            uncertainty,
        })
    }

    /// Whitened residuals at the best point and the number of their parameters: the moduli's logarithms and, where the law stiffens, both
    /// ratios of stiffening.
    fn whitened_residuals<'m>(&self, minimum: &'m Minimum) -> Result<(&'m Residuals, usize)> {
        let solids = self.loss.body.materials.len();
        Ok(match &minimum.stiffened {
            Some(together) => (&together.residuals, solids + together.ratios.len()),
            None => (residuals_of(&minimum.moduli.history.best)?, solids),
        })
    }

    fn stiffening_with_sigma(&self, minimum: &Minimum, posterior: &Posterior) -> Option<records::Stiffening> {
        let solids = self.loss.body.materials.len();
        let with_sigma = |stiffened: &Stiffened| records::Stiffening {
            ratios: stiffened.ratios,
            sigma: [0, 1].map(|term| posterior.covariance.sigma(solids + term)),
        };
        minimum.stiffened.as_ref().map(with_sigma)
    }

    fn simulated_levels(&self, markers: &[Vec<Point2>]) -> Vec<Level> {
        let levels_with_origins = self.loss.misfit.levels.iter().zip(markers).zip(&self.origins);
        levels_with_origins
            .map(|((level, simulated), (trial, rest))| Level {
                trial: trial.clone(),
                pressures_pa: level.pressures.clone(),
                rest_m: rest.clone(),
                measured_m: level.measured.clone(),
                covariance_m2: level.covariance.clone(),
                shared_m2: level.shared.clone(),
                simulated_m: simulated.clone(),
            })
            .collect()
    }
}
