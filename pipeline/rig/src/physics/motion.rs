//! Motions: where every node of a body is at any time, however it was computed.
//!
//! Stands on: `si`, the valve's trace. Never knows: finite elements, a camera.

use si::{Hertz, Newton, Point3, Second};

use super::Ladder;

use crate::valve::Trace;

/// A body in motion.
pub trait Motion: Sync {
    /// Positions of all nodes at time `t` (s), m.
    fn nodes(&self, t: Second) -> Vec<Point3>;

    /// As [`Motion::nodes`], but only the nodes `of` need be where they are: of many thousand, a film sees the skin's.
    fn seen(&self, t: Second, of: &[u32]) -> Vec<Point3> {
        let _ = of;
        self.nodes(t)
    }

    /// Forwards on the holder at time `t` (s), N.
    fn pull(&self, _: Second) -> Newton {
        0.0
    }

    /// Of the pull, the water's thrust, N.
    fn thrust(&self, _: Second) -> Newton {
        0.0
    }
}

/// So slow that the body is always in equilibrium: shapes up a ladder of pressures, and the pressure in time.
pub struct Quasistatic<'a> {
    /// Nodes at rest, m.
    pub rest: &'a [Point3],
    /// Shapes by pressure.
    pub ladder: &'a Ladder,
    /// The pressure.
    pub trace: Trace,
}

impl Quasistatic<'_> {
    /// The first of the four rungs around the pressure at time `t` (s), and the weights of the cubic through them (Lagrange); held
    /// beyond the ladder.
    pub fn rungs(&self, t: Second) -> (usize, [f64; 4]) {
        let pressures = &self.ladder.pressures;
        let last = pressures.len() - 1;
        let pressure = self.trace.at(t).clamp(pressures[0], pressures[last]);
        let above = pressures.partition_point(|p| *p <= pressure);
        let first = above.saturating_sub(2).min(last - 3);
        (first, lagrange(&pressures[first..first + 4], pressure))
    }

    /// Where node `i` is between the rungs from `first` on, m.
    fn node(&self, i: usize, first: usize, weights: &[f64; 4]) -> Point3 {
        let rungs = &self.ladder.shapes[first..first + 4];
        let moved = |k: usize| (0..4).map(|r| weights[r] * rungs[r][k]).sum::<f64>();
        [0, 1, 2].map(|axis| self.rest[i][axis] + moved(3 * i + axis))
    }
}

impl Motion for Quasistatic<'_> {
    fn nodes(&self, t: Second) -> Vec<Point3> {
        let (first, weights) = self.rungs(t);
        (0..self.rest.len()).map(|i| self.node(i, first, &weights)).collect()
    }

    fn seen(&self, t: Second, of: &[u32]) -> Vec<Point3> {
        let ((first, weights), mut nodes) = (self.rungs(t), self.rest.to_vec());
        of.iter().for_each(|i| nodes[*i as usize] = self.node(*i as usize, first, &weights));
        nodes
    }
}

/// Weights of the values at four places `at` in the cubic through them, at `x`.
fn lagrange(at: &[f64], x: f64) -> [f64; 4] {
    let others = |i: usize| (0..4).filter(move |j| *j != i);
    [0, 1, 2, 3].map(|i| others(i).map(|j| (x - at[j]) / (at[i] - at[j])).product())
}

/// A motion kept at even times.
pub struct Recorded {
    /// Nodes at rest, m.
    pub rest: Vec<Point3>,
    /// Time of the first shape, s; at rest before it.
    pub start: Second,
    /// Shapes a second.
    pub rate: Hertz,
    /// Displacements, times × (nodes × 3), m.
    pub shapes: Vec<Vec<f32>>,
}

impl Motion for Recorded {
    /// Linear between kept shapes; the first before them, the last after.
    fn nodes(&self, t: Second) -> Vec<Point3> {
        let place = ((t - self.start) * self.rate).clamp(0.0, (self.shapes.len() - 1) as f64);
        let first = (place.floor() as usize).min(self.shapes.len().saturating_sub(2));
        let (before, after) = (&self.shapes[first], &self.shapes[(first + 1).min(self.shapes.len() - 1)]);
        let share = place - first as f64;
        let moved = |k: usize| f64::from(before[k]) * (1.0 - share) + f64::from(after[k]) * share;
        let node = |(i, x): (usize, &Point3)| [x[0] + moved(3 * i), x[1] + moved(3 * i + 1), x[2] + moved(3 * i + 2)];
        self.rest.iter().enumerate().map(node).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Draw;
    use crate::settings::Settings;
    use crate::valve::{Command, Unrest, follow};

    #[test]
    fn a_cubic_in_pressure_is_met_between_rungs() {
        let shape = |p: f64| 1.0 + p - 2.0 * p * p + 0.5 * p * p * p;
        let pressures: Vec<f64> = [0.0, 700.0, 1800.0, 3000.0, 4000.0].to_vec();
        let shapes = pressures.iter().map(|p| vec![shape(p / 1000.0), 0.0, 0.0]).collect();
        let ladder = Ladder { pressures, shapes };
        let commands = [Command { time: 0.0, pressure: 2500.0 }];
        let trace = follow(&Settings::built_in().valve, &commands, Unrest::default(), &mut Draw::new(3, "valve"));
        let motion = Quasistatic { rest: &[[1.0, 2.0, 3.0]], ladder: &ladder, trace: trace.clone() };
        for t in [0.0, 0.06, 0.08, 0.1, 2.0] {
            let x = motion.nodes(t)[0][0];
            assert!((x - 1.0 - shape(trace.at(t) / 1000.0)).abs() < 1e-12, "{t}: {x}");
        }
    }

    #[test]
    fn a_recorded_motion_is_met_at_its_times_and_rests_before() {
        let motion =
            Recorded { rest: vec![[0.0; 3]], start: 0.5, rate: 10.0, shapes: vec![vec![0.0; 3], vec![1.0; 3]] };
        for (t, x) in [(0.0, 0.0), (0.55, 0.5), (0.6, 1.0), (9.0, 1.0)] {
            assert!((motion.nodes(t)[0][0] - x).abs() < 1e-12, "at {t}");
        }
    }
}
