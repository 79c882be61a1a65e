//! Equilibria of a body at rising pressures on one side.

use crate::side::Side;
use diagnostics::{Diagnostic, Result};
use fem::StaticSettings;
use si::Pascal;

use super::Body;

/// Newton's iteration stops when a step is shorter than this, relative to the body: convergence is quadratic, so the next step would be
/// of the order of its square.
pub(super) const TOLERANCE: f64 = 1e-6;

/// Equilibria at rising pressures on one side.
#[derive(Debug, Clone)]
pub struct PressureSweep {
    /// Rising from 0, Pa; four or more.
    pub pressures: Vec<Pascal>,
    /// Displacements at those pressures, pressures × (nodes × 3), m.
    pub shapes: Vec<Vec<f64>>,
}

/// Pressures from 0 to `top` (Pa) in `levels` equal steps.
pub fn even_pressures(top: Pascal, levels: usize) -> Vec<Pascal> {
    (0..=levels).map(|i| top * i as f64 / levels as f64).collect()
}

impl PressureSweep {
    /// The equilibria of `body` with `side` at `pressures` (Pa, rising from 0).
    ///
    /// `tick` is called after each.
    ///
    /// # Errors
    /// When an equilibrium is not found.
    pub fn solve_sweep(body: &Body, side: Side, pressures: &[Pascal], tick: &(dyn Fn() + Sync)) -> Result<Self> {
        let mut solver = body.system.solver();
        let settings = StaticSettings { load_steps: 1, tolerance: TOLERANCE, ..StaticSettings::default() };
        let mut shapes = vec![vec![0.0; 3 * body.mesh.nodes.len()]];
        for pressure in &pressures[1..] {
            let solved: Vec<(Pascal, &[f64])> =
                pressures.iter().copied().zip(shapes.iter().map(Vec::as_slice)).collect();
            let equilibrium = solver.equilibrium_from(&solved, &body.one_side(side, *pressure), &settings);
            let doing =
                || format!("equilibrium of the {} side at {:.0} mbar", side.channel_name(), pressure / si::MILLIBAR);
            shapes.push(equilibrium.map_err(|e| Diagnostic::from(e).while_doing(doing()))?.displacement);
            tick();
        }
        Ok(Self { pressures: pressures.to_vec(), shapes })
    }

    /// The level that is nearest to `pressure` (Pa), and its shape.
    pub(crate) fn nearest_level(&self, pressure: Pascal) -> (Pascal, &[f64]) {
        let upper = self.pressures.partition_point(|p| *p < pressure).min(self.pressures.len() - 1);
        let lower = upper.saturating_sub(1);
        let closer = pressure - self.pressures[lower] < self.pressures[upper] - pressure;
        let level = if closer { lower } else { upper };
        (self.pressures[level], &self.shapes[level])
    }
}
