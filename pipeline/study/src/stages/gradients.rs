//! Gradients: the adjoint gradient of the loss against finite differences.

use optimize::{Needs, Problem};

use diagnostics::Result;
use sysid::{LevelSolver, Loss, statics};

/// Step of the central differences, in logarithms of moduli: its truncation error is far below the solver's tolerance.
const DIFFERENCE: f64 = 1e-3;

/// Tolerance of the equilibria between which differences are taken, as a part of the specimen's size.
const EXACT: f64 = 1e-9;

/// Adjoint gradient against central differences at the start of a search, over the size of the gradient; from the equilibria of `known`.
///
/// # Errors
/// A [`Diagnostic`](diagnostics::Diagnostic) when there is no equilibrium at the start.
pub(super) fn gradient_difference(loss: &Loss, search: &Problem, solved: &LevelSolver) -> Result<f64> {
    let mut solver = solved.with(loss.misfit.levels.clone(), statics(EXACT));
    let start = [search.start()[0], search.start()[1]];
    let mut evaluate = |point: [f64; 2], needs: Needs| loss.evaluate(&mut solver, &point, needs, &mut Vec::new());
    let adjoint = evaluate(start, Needs::Gradient)?.gradient.unwrap_or_default();
    let size = adjoint.iter().fold(0.0_f64, |s, g| s.max(g.abs()));
    let mut worst = 0.0_f64;
    for k in 0..2 {
        let mut loss_beside = |sign: f64| {
            let mut point = start;
            point[k] += sign * DIFFERENCE;
            evaluate(point, Needs::Loss).map(|e| e.loss)
        };
        let difference = (loss_beside(1.0)? - loss_beside(-1.0)?) / (2.0 * DIFFERENCE);
        worst = worst.max((difference - adjoint[k]).abs() / size);
    }
    Ok(worst)
}
