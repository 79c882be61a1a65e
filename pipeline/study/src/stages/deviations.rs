//! The identified silicone perturbed by a fraction of one standard deviation along each principal axis of its uncertainty.
//!
//! Whatever is predicted with the silicone is simulated with each of these as well: the squares of the changes over [`PART`] add to the
//! variance.

use diagnostics::Result;
use optimize::posterior::principal_deviations;
use records::{Identified, Relaxation};
use sysid::{Model, Viscoelastic};

/// The part of a standard deviation. A sheet that is known to 30 % would otherwise draw the relaxation, which follows it in logarithms, far
/// beyond where that holds.
pub(super) const PART: f64 = 0.1;

/// An identified silicone with the uncertainty of its parameters.
pub(super) struct UncertainSilicone<'a> {
    pub model: &'a Model,
    pub identified: &'a Identified,
    pub relaxation: &'a Relaxation,
}

impl UncertainSilicone<'_> {
    /// The silicone perturbed along each principal axis of the moduli's covariance, and of that of the branches' strengths.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when a branch is one that no solid can have.
    pub(crate) fn perturbed_silicones(&self) -> Result<Vec<Viscoelastic>> {
        let moduli = &self.identified.uncertainty;
        let axes = principal_deviations(moduli.sigma.len(), &|i, j| moduli.on_the_same_mesh(i, j));
        axes.iter().map(|shift| self.silicone_with_moduli(shift)).chain(self.silicones_with_strengths()).collect()
    }

    /// The moduli perturbed by a shift of their logarithms, with the relaxation that would have been identified with them.
    fn silicone_with_moduli(&self, shift: &[f64]) -> Result<Viscoelastic> {
        let mut perturbed = self.identified.clone();
        perturbed.best.iter_mut().zip(shift).for_each(|(modulus, change)| *modulus *= (PART * change).exp());
        let spectrum =
            self.relaxation.spectrum.following(&shift.iter().map(|change| PART * change).collect::<Vec<_>>());
        Relaxation { spectrum, ..self.relaxation.clone() }.silicone(self.model, &perturbed)
    }

    /// Along each principal axis of the covariance of the strengths.
    fn silicones_with_strengths(&self) -> impl Iterator<Item = Result<Viscoelastic>> + '_ {
        let silicone_with =
            |spectrum| Relaxation { spectrum, ..self.relaxation.clone() }.silicone(self.model, self.identified);
        self.relaxation.spectrum.deviations(PART).map(silicone_with)
    }
}
