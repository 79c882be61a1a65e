//! Motions: the position of every node of a body at any time, however it was computed.

use si::{Hertz, Newton, Point3, Second};

use super::PressureSweep;

use crate::valve::Trace;

/// A body in motion.
pub trait Motion: Sync {
    /// Positions of all nodes at time `t` (s), m.
    fn nodes(&self, t: Second) -> Vec<Point3>;

    /// As [`Motion::nodes`], but only the positions of the nodes `of` need be correct: a film shows the skin alone.
    fn nodes_of(&self, t: Second, of: &[u32]) -> Vec<Point3> {
        let _ = of;
        self.nodes(t)
    }

    /// Force on the holder at time `t` (s), positive forwards, N.
    fn pull(&self, _: Second) -> Newton {
        0.0
    }

    /// Thrust of the water at time `t` (s), N.
    fn thrust(&self, _: Second) -> Newton {
        0.0
    }
}

/// A motion through equilibria: the shapes of a pressure sweep, interpolated at the present pressure.
pub struct QuasistaticMotion<'a> {
    /// Nodes at rest, m.
    pub rest: &'a [Point3],
    /// Shapes by pressure.
    pub sweep: &'a PressureSweep,
    /// The pressure.
    pub trace: Trace,
}

impl QuasistaticMotion<'_> {
    /// Index of the first of the four levels around the pressure at time `t` (s), and the weights of the cubic through them (Lagrange);
    /// the pressure is clamped to the range of the sweep.
    pub(crate) fn cubic_weights(&self, t: Second) -> (usize, [f64; 4]) {
        let pressures = &self.sweep.pressures;
        let last = pressures.len() - 1;
        let pressure = self.trace.at(t).clamp(pressures[0], pressures[last]);
        let upper_level = pressures.partition_point(|p| *p <= pressure);
        let first = upper_level.saturating_sub(2).min(last - 3);
        (first, lagrange_weights(&pressures[first..first + 4], pressure))
    }

    /// Position of node `i`, interpolated between the levels from `first` on, m.
    fn node_position(&self, i: usize, first: usize, weights: &[f64; 4]) -> Point3 {
        let shapes = &self.sweep.shapes[first..first + 4];
        let displacement = |k: usize| (0..4).map(|r| weights[r] * shapes[r][k]).sum::<f64>();
        [0, 1, 2].map(|axis| self.rest[i][axis] + displacement(3 * i + axis))
    }
}

impl Motion for QuasistaticMotion<'_> {
    fn nodes(&self, t: Second) -> Vec<Point3> {
        let (first, weights) = self.cubic_weights(t);
        (0..self.rest.len()).map(|i| self.node_position(i, first, &weights)).collect()
    }

    fn nodes_of(&self, t: Second, of: &[u32]) -> Vec<Point3> {
        let ((first, weights), mut nodes) = (self.cubic_weights(t), self.rest.to_vec());
        of.iter().for_each(|i| nodes[*i as usize] = self.node_position(*i as usize, first, &weights));
        nodes
    }
}

/// Lagrange weights at `x` of the values at the four abscissae `nodes`.
fn lagrange_weights(nodes: &[f64], x: f64) -> [f64; 4] {
    let other_nodes = |i: usize| (0..4).filter(move |j| *j != i);
    [0, 1, 2, 3].map(|i| other_nodes(i).map(|j| (x - nodes[j]) / (nodes[i] - nodes[j])).product())
}

/// A motion stored at even times.
pub struct SampledMotion {
    /// Nodes at rest, m.
    pub rest: Vec<Point3>,
    /// Time of the first shape, s; at rest before it.
    pub start: Second,
    /// Shapes a second.
    pub rate: Hertz,
    /// Displacements, times × (nodes × 3), m.
    pub shapes: Vec<Vec<f32>>,
}

impl Motion for SampledMotion {
    /// Linear between stored shapes, constant outside.
    fn nodes(&self, t: Second) -> Vec<Point3> {
        let index = ((t - self.start) * self.rate).clamp(0.0, (self.shapes.len() - 1) as f64);
        let first = (index.floor() as usize).min(self.shapes.len().saturating_sub(2));
        let (before, after) = (&self.shapes[first], &self.shapes[(first + 1).min(self.shapes.len() - 1)]);
        let fraction = index - first as f64;
        let displacement = |k: usize| f64::from(before[k]) * (1.0 - fraction) + f64::from(after[k]) * fraction;
        let node = |(i, x): (usize, &Point3)| {
            [x[0] + displacement(3 * i), x[1] + displacement(3 * i + 1), x[2] + displacement(3 * i + 2)]
        };
        self.rest.iter().enumerate().map(node).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::RandomStream;
    use crate::settings::Settings;
    use crate::valve::{Command, ValveDisturbance, valve_response};

    #[test]
    fn a_sampled_motion_is_linear_between_its_shapes_and_constant_outside() {
        let rest = vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
        let shape = |k: f32| (0..6).map(|i| k * k * i as f32).collect::<Vec<f32>>();
        let motion = SampledMotion { rest, start: 0.5, rate: 4.0, shapes: vec![shape(0.0), shape(1.0), shape(2.0)] };
        // a quarter of the way from the second shape (1 · i) to the third (4 · i)
        assert_eq!(motion.nodes(0.5 + 1.25 / 4.0), [[1.0, 3.75, 6.5], [9.25, 12.0, 14.75]]);
        assert_eq!((motion.nodes(0.0), motion.nodes(2.0)), (motion.nodes(0.5), motion.nodes(1.0)));
        assert_eq!((motion.pull(1.0), motion.thrust(1.0)), (0.0, 0.0));
    }

    #[test]
    fn a_cubic_in_pressure_is_interpolated_exactly() {
        let shape = |p: f64| 1.0 + p - 2.0 * p * p + 0.5 * p * p * p;
        let pressures: Vec<f64> = [0.0, 700.0, 1800.0, 3000.0, 4000.0].to_vec();
        let shapes = pressures.iter().map(|p| vec![shape(p / 1000.0), 0.0, 0.0]).collect();
        let sweep = PressureSweep { pressures, shapes };
        let commands = [Command { time: 0.0, pressure: 2500.0 }];
        let trace = valve_response(
            &Settings::built_in().valve,
            &commands,
            ValveDisturbance::default(),
            &mut RandomStream::new(3, "valve"),
        );
        let motion = QuasistaticMotion { rest: &[[1.0, 2.0, 3.0]], sweep: &sweep, trace: trace.clone() };
        for t in [0.0, 0.06, 0.08, 0.1, 2.0] {
            let x = motion.nodes(t)[0][0];
            assert!((x - 1.0 - shape(trace.at(t) / 1000.0)).abs() < 1e-12, "{t}: {x}");
        }
    }

    #[test]
    fn a_sampled_motion_is_interpolated_linearly_and_constant_outside() {
        let motion =
            SampledMotion { rest: vec![[0.0; 3]], start: 0.5, rate: 10.0, shapes: vec![vec![0.0; 3], vec![1.0; 3]] };
        for (t, x) in [(0.0, 0.0), (0.55, 0.5), (0.6, 1.0), (9.0, 1.0)] {
            assert!((motion.nodes(t)[0][0] - x).abs() < 1e-12, "at {t}");
        }
    }
}
