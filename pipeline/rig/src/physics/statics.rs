//! Statics: the shapes that a body takes up a ladder of pressures on one side.
//!
//! Stands on: `fem`'s equilibrium. Never knows: time.

use fem::StaticSettings;
use lab::card::Side;
use si::Pascal;

use super::Body;
use crate::fault::Fault;

/// Displacements (nodes × 3, m) at each of `pressures` (Pa, rising, the first 0) on `side`.
///
/// Each rung starts from the two before it, carried on in a straight line. `tick` is called after each.
///
/// # Errors
/// [`Fault`] when no equilibrium is found on a rung.
pub fn ladder(body: &Body, side: Side, pressures: &[Pascal], tick: &dyn Fn()) -> Result<Vec<Vec<f64>>, Fault> {
    let mut solver = body.system.solver();
    let settings = StaticSettings { load_steps: 1, ..StaticSettings::default() };
    let mut rungs = vec![vec![0.0; 3 * body.mesh.nodes.len()]];
    for (rung, pressure) in pressures.iter().enumerate().skip(1) {
        let start = carried_on(&rungs, pressures);
        let found = solver
            .equilibrium(&body.one_side(side, *pressure), Some(&start), &settings)
            .map_err(|e| Fault::at(format!("equilibrium {rung} at {:.0} mbar", pressure / si::MILLIBAR), e))?;
        rungs.push(found.displacement);
        tick();
    }
    Ok(rungs)
}

/// The pressures at which to solve for a body that dwells at `levels` (Pa, rising): ambient, the levels themselves, so
/// that a dwell is met exactly, and `between` pressures spread evenly between each two.
pub fn rungs(levels: &[Pascal], between: usize) -> Vec<Pascal> {
    let stops: Vec<Pascal> = [0.0].into_iter().chain(levels.iter().copied()).collect();
    let parts = between + 1;
    let part = |pair: &[Pascal], i: usize| pair[0] + (pair[1] - pair[0]) * i as f64 / parts as f64;
    let above = stops.windows(2).flat_map(|pair| (1..=parts).map(|i| part(pair, i)).collect::<Vec<_>>());
    [0.0].into_iter().chain(above).collect()
}

/// The line through the last two rungs, at the next pressure.
fn carried_on(rungs: &[Vec<f64>], pressures: &[Pascal]) -> Vec<f64> {
    let last = rungs.len() - 1;
    let Some(before) = last.checked_sub(1) else { return rungs[last].clone() };
    let part = (pressures[last + 1] - pressures[last]) / (pressures[last] - pressures[before]);
    rungs[last].iter().zip(&rungs[before]).map(|(b, a)| b + part * (b - a)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rungs_stand_on_the_levels_and_evenly_between_them() {
        assert_eq!(rungs(&[4e3, 9e3], 0), [0.0, 4e3, 9e3]);
        assert_eq!(rungs(&[4e3, 9e3], 1), [0.0, 2e3, 4e3, 6.5e3, 9e3]);
    }
}
