//! A reduced body at rest: f(q) = Σ p ∂V/∂q, the march's equations without time in them.
//!
//! Stands on: the march's step. Never knows: how the body came there.

use nalgebra::DVector;
use si::Pascal;

use super::Reduced;
use super::march::{PATIENT, ReducedError, Step, Still};
use crate::motion::march::March;
use crate::motion::stencil::Stencil;

impl Reduced {
    /// The shape in balance under `pressures` (one a chamber, Pa), sought from `guess`; `scale` (one a region) multiplies moduli.
    ///
    /// # Errors
    /// [`ReducedError::NoMotion`] at time 0 when none is found.
    pub fn equilibrium(
        &self,
        pressures: &[Pascal],
        scale: &[f64],
        guess: &DVector<f64>,
    ) -> Result<DVector<f64>, ReducedError> {
        let timeless = Stencil { gamma: 0.0, weights: Vec::new() };
        let nothing = || DVector::zeros(self.coordinates());
        let equations = Step {
            body: self,
            march: &March::default(),
            stencil: &timeless,
            pressures,
            scale,
            around: &Still,
            past: [nothing(), nothing(), nothing()],
        };
        equations.solve(guess.clone(), guess, &mut None, PATIENT).map_err(|change| ReducedError::no_motion(0.0, change))
    }
}
