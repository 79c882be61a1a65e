//! Gradients: the adjoint gradient of the loss against finite differences, and its cost.

use fem::StaticSettings;
use optimize::Needs;

use super::fitting::Fitting;
use diagnostics::Result;
use sysid::Elastic;
use workflow::stage::StageContext;

/// Step of the central differences, in logarithms of moduli: its truncation error is far below the solver's tolerance.
const DIFFERENCE: f64 = 1e-3;

/// Tolerance of the equilibria between which differences are taken, as a part of the specimen's size.
const EXACT: f64 = 1e-9;

impl Fitting<'_> {
    /// Adjoint gradient against central differences at the start, over the size of the gradient.
    ///
    /// # Errors
    /// A [`Diagnostic`](diagnostics::Diagnostic) when there is no equilibrium at the start.
    pub(crate) fn gradient_difference(&self) -> Result<f64> {
        let mut solver = self.solver(&self.levels.levels, EXACT);
        let start = [self.search.start()[0], self.search.start()[1]];
        let mut loss = |at: [f64; 2], needs: Needs| self.evaluate(&mut solver, &at, needs, &mut Vec::new());
        let adjoint = loss(start, Needs::Gradient)?.gradient.unwrap_or_default();
        let size = adjoint.iter().fold(0.0_f64, |s, g| s.max(g.abs()));
        let mut worst = 0.0_f64;
        for k in 0..2 {
            let mut at = |sign: f64| {
                let mut at = start;
                at[k] += sign * DIFFERENCE;
                loss(at, Needs::Loss).map(|e| e.loss)
            };
            let difference = (at(1.0)? - at(-1.0)?) / (2.0 * DIFFERENCE);
            worst = worst.max((difference - adjoint[k]).abs() / size);
        }
        Ok(worst)
    }

    /// Processor time of an equilibrium with its gradient over that of the equilibrium alone, from rest (no known shape) to the highest level.
    ///
    /// # Errors
    /// A [`Diagnostic`](diagnostics::Diagnostic) when there is no equilibrium there.
    pub(crate) fn gradient_over_forward(&self, elastic: &Elastic, context: &dyn StageContext) -> Result<f64> {
        let pressures =
            self.levels.levels.iter().max_by(|a, b| a.top().total_cmp(&b.top())).map_or(&[][..], |top| &top.pressures);
        let mut solver = self.model.system.solver();
        elastic.apply(&mut solver)?;
        let settings = StaticSettings { tolerance: self.set.static_tolerance, ..StaticSettings::default() };
        let began = context.thread_seconds();
        let found = solver.equilibrium(pressures, None, &settings)?;
        let forward = context.thread_seconds() - began;
        solver.adjoint(&found, &found.displacement)?;
        Ok((context.thread_seconds() - began) / forward)
    }
}
