//! Statics: the shapes that a body takes up a ladder of pressures on one side.
//!
//! Stands on: `fem`'s equilibrium. Never knows: time.

use fem::StaticSettings;
use lab::card::Side;
use si::Pascal;

use super::Body;
use crate::fault::Fault;

/// The last Newton step of an equilibrium is no longer than this part of the body: the one after it would be its square.
pub(super) const SETTLED: f64 = 1e-6;

/// Shapes at rising pressures on one side.
#[derive(Debug, Clone)]
pub struct Ladder {
    /// Rising from 0, Pa; four or more.
    pub pressures: Vec<Pascal>,
    /// Displacements at those pressures, nodes × 3, m.
    pub shapes: Vec<Vec<f64>>,
}

impl Ladder {
    /// Of `body` with `side` filled to `top` (Pa) in `rungs` even steps.
    ///
    /// Each rung starts from the three before it, carried on in a parabola. `tick` is called after each.
    ///
    /// # Errors
    /// [`Fault`] when no equilibrium is found on a rung.
    pub fn climb(body: &Body, side: Side, top: Pascal, rungs: usize, tick: &(dyn Fn() + Sync)) -> Result<Self, Fault> {
        let pressures: Vec<Pascal> = (0..=rungs).map(|i| top * i as f64 / rungs as f64).collect();
        let mut solver = body.system.solver();
        let settings = StaticSettings { load_steps: 1, tolerance: SETTLED, ..StaticSettings::default() };
        let mut shapes = vec![vec![0.0; 3 * body.mesh.nodes.len()]];
        for (rung, pressure) in pressures.iter().enumerate().skip(1) {
            let start = carried_on(&shapes);
            let found = solver
                .equilibrium(&body.one_side(side, *pressure), Some(&start), &settings)
                .map_err(|e| Fault::at(format!("equilibrium {rung} at {:.0} mbar", pressure / si::MILLIBAR), e))?;
            shapes.push(found.displacement);
            tick();
        }
        Ok(Self { pressures, shapes })
    }

    /// The shape of the rung nearest to `pressure` (Pa).
    pub fn nearest(&self, pressure: Pascal) -> &[f64] {
        let above = self.pressures.partition_point(|p| *p < pressure).min(self.pressures.len() - 1);
        let below = above.saturating_sub(1);
        let closer = pressure - self.pressures[below] < self.pressures[above] - pressure;
        &self.shapes[if closer { below } else { above }]
    }
}

/// The parabola through the last three rungs, at the next; a straight line through two.
fn carried_on(shapes: &[Vec<f64>]) -> Vec<f64> {
    let weights: &[f64] = match shapes.len() {
        1 => &[1.0],
        2 => &[-1.0, 2.0],
        _ => &[1.0, -3.0, 3.0],
    };
    let mut next = vec![0.0; shapes[0].len()];
    for (weight, shape) in weights.iter().zip(&shapes[shapes.len() - weights.len()..]) {
        next.iter_mut().zip(shape).for_each(|(sum, u)| *sum += weight * u);
    }
    next
}
