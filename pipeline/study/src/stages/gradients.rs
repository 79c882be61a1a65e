//! Gradients: the adjoint gradient of the loss against finite differences, and its cost.

use fem::StaticSettings;
use optimize::{Needs, Problem};

use diagnostics::Result;
use sysid::{Elastic, LevelSolver, Loss, statics};
use workflow::stage::StageContext;

/// Step of the central differences, in logarithms of moduli: its truncation error is far below the solver's tolerance.
const DIFFERENCE: f64 = 1e-3;

/// Tolerance of the equilibria between which differences are taken, as a part of the specimen's size.
const EXACT: f64 = 1e-9;

/// Adjoint gradient against central differences at the start of a search, over the size of the gradient; from the equilibria of `known`.
///
/// # Errors
/// A [`Diagnostic`](diagnostics::Diagnostic) when there is no equilibrium at the start.
pub(super) fn gradient_difference(loss: &Loss, search: &Problem, known: &LevelSolver) -> Result<f64> {
    let mut solver = known.with(loss.misfit.levels.clone(), statics(EXACT));
    let start = [search.start()[0], search.start()[1]];
    let mut evaluate = |at: [f64; 2], needs: Needs| loss.evaluate(&mut solver, &at, needs, &mut Vec::new());
    let adjoint = evaluate(start, Needs::Gradient)?.gradient.unwrap_or_default();
    let size = adjoint.iter().fold(0.0_f64, |s, g| s.max(g.abs()));
    let mut worst = 0.0_f64;
    for k in 0..2 {
        let mut at = |sign: f64| {
            let mut at = start;
            at[k] += sign * DIFFERENCE;
            evaluate(at, Needs::Loss).map(|e| e.loss)
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
pub(super) fn gradient_over_forward(
    loss: &Loss,
    elastic: &Elastic,
    tolerance: f64,
    context: &dyn StageContext,
) -> Result<f64> {
    let levels = &loss.misfit.levels;
    let pressures = levels.iter().max_by(|a, b| a.top().total_cmp(&b.top())).map_or(&[][..], |top| &top.pressures);
    let mut solver = loss.model.system.solver();
    elastic.apply(&mut solver)?;
    let settings = StaticSettings { tolerance, ..StaticSettings::default() };
    let began = context.thread_seconds();
    let found = solver.equilibrium(pressures, None, &settings)?;
    let forward = context.thread_seconds() - began;
    solver.adjoint(&found, &found.displacement)?;
    Ok((context.thread_seconds() - began) / forward)
}
