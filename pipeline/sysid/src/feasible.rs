//! Feasible lower bound of the body's modulus: below it the highest measured pressures have no equilibrium.

use fem::StaticSettings;
use optimize::Bounds;

use crate::levels::{Derivatives, LevelSolver, PressureLevel};
use crate::model::{Elastic, Model};

/// Step from stiff to soft, in the logarithm of the body's modulus.
const SOFTER: f64 = 0.1;

/// Logarithm, over the nominal value, of the lowest modulus of the body with an equilibrium at the highest pressure of each film, with
/// the nominal spine; the lower bound of the search where that has one.
///
/// Below it walls lose stability and the films cannot be simulated.
pub fn feasible_lower_bound(model: &Model, levels: &[PressureLevel], bounds: &Bounds) -> f64 {
    let settings = StaticSettings { tolerance: 1e-4, max_halvings: 0, max_iterations: 12, ..StaticSettings::default() };
    let top = levels.iter().map(PressureLevel::top).fold(0.0, f64::max);
    let highest: Vec<PressureLevel> = levels.iter().filter(|r| r.top() > 0.98 * top).cloned().collect();
    let count = highest.len();
    let mut solver = LevelSolver::new(model.clone(), highest, settings, count);
    let [body, spine] = model.nominal.youngs_moduli;
    let has_equilibrium = |solver: &mut LevelSolver, at: f64| {
        let youngs_moduli = [body * at.exp(), spine];
        solver.solve(&Elastic { youngs_moduli, ..model.nominal }, Derivatives::None).is_ok()
    };
    let (low, high) = (bounds.low[0], bounds.high[0]);
    // The bound is approached from the stiff side with warm starts: a failed equilibrium is the most expensive evaluation, and this
    // order meets only one.
    let steps = ((high - low) / SOFTER).ceil() as usize;
    if !has_equilibrium(&mut solver, high) {
        return low;
    }
    let lost = (1..=steps).find(|&k| !has_equilibrium(&mut solver, (high - SOFTER * k as f64).max(low)));
    lost.map_or(low, |k| (high - SOFTER * (k as f64 - 1.0)).min(high - SOFTER))
}
