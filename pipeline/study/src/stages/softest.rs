//! Softest: how soft a body may be before the films' highest pressures have no shape.
//!
//! Stands on: the ladder. Never knows: which methods search the box.

use fem::StaticSettings;
use fit::Bounds;

use crate::model::{Elastic, Ladder, Model, Rung, Want};

/// Step of the way from stiff to soft, in the logarithm of the body's modulus.
const SOFTER: f64 = 0.1;

/// Logarithm over the nominal value of the softest body that surely has a shape at the highest pressure of each film, with the
/// nominal spine; the box's lower end where that has one.
///
/// Below it the films cannot be simulated, whatever is plausible: walls leave their shapes. It is come upon from the stiff side,
/// each shape warm from the last, because a shape that is not there is sought longest.
pub fn softest(model: &Model, rungs: &[Rung], bounds: &Bounds) -> f64 {
    let settings = StaticSettings { tolerance: 1e-4, halvings: 0, iterations: 12, ..StaticSettings::default() };
    let top = rungs.iter().map(Rung::top).fold(0.0, f64::max);
    let highest: Vec<Rung> = rungs.iter().filter(|r| r.top() > 0.98 * top).cloned().collect();
    let count = highest.len();
    let mut ladder = Ladder::new(model.clone(), highest, settings, count);
    let [body, spine] = model.nominal.youngs_moduli;
    let bears = |ladder: &mut Ladder, at: f64| {
        let youngs_moduli = [body * at.exp(), spine];
        ladder.climb(&Elastic { youngs_moduli, ..model.nominal }, Want::Nothing).is_ok()
    };
    let (low, high) = (bounds.low[0], bounds.high[0]);
    let steps = ((high - low) / SOFTER).ceil() as usize;
    if !bears(&mut ladder, high) {
        return low;
    }
    let lost = (1..=steps).find(|&k| !bears(&mut ladder, (high - SOFTER * k as f64).max(low)));
    lost.map_or(low, |k| (high - SOFTER * (k as f64 - 1.0)).min(high - SOFTER))
}
