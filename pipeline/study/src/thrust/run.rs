//! A run: one beating trial as samples at one rate, each with force, marks, pressures and their rates.
//!
//! Stands on: hydro (its terms). Never knows: where the samples came from.

use hydro::{Tail, Terms};
use lab::card::Split;
use si::{Hertz, Metre, Newton, Pascal, Point2, Second};

/// One trial, samples × each.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The trial's id.
    pub id: String,
    /// Commanded pressure, Pa.
    pub amplitude: Pascal,
    /// Beats a second, Hz.
    pub frequency: Hertz,
    /// What the card makes of it.
    pub split: Option<Split>,
    /// Samples a second.
    pub rate: Hertz,
    /// s on the film's clock.
    pub time: Vec<Second>,
    /// What is to be told, N.
    pub force: Vec<Newton>,
    /// Displacement of each mark, m: samples × marks.
    pub moved: Vec<Vec<Point2>>,
    /// Velocity of each mark, m/s: samples × marks.
    pub speed: Vec<Vec<Point2>>,
    /// Pressure of each chamber, Pa: samples × chambers.
    pub pressure: Vec<Vec<Pascal>>,
    /// Rate of each pressure, Pa/s: samples × chambers.
    pub pressure_rate: Vec<Vec<f64>>,
    /// The parts of theory, a set a sample.
    pub terms: Vec<Parts>,
}

/// The parts of theory at one sample, N, before any coefficient.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Parts {
    /// ½ m ẏ² at the trailing edge: the paper's.
    pub simple: f64,
    /// Lighthill's terms at the trailing edge.
    pub shed: f64,
    /// Rate of Lighthill's momentum.
    pub gained: f64,
    /// Drag for a coefficient of one.
    pub drag: f64,
    /// x acceleration of the last mark, m/s²: what the tail's own mass pulls by.
    pub jerked: f64,
}

impl Run {
    /// Samples.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// Samples of one beat, at least one.
    pub fn beat(&self) -> usize {
        ((self.rate / self.frequency).round() as usize).max(1)
    }

    /// Half the way that the last mark goes sideways, m.
    pub fn swing(&self) -> Metre {
        let y = self.moved.iter().filter_map(|m| m.last()).map(|p| p[1]);
        let (low, high) = y.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), y| (l.min(y), h.max(y)));
        if high > low { 0.5 * (high - low) } else { 0.0 }
    }

    /// Positions and velocities of the marks, pressures and their rates, as the network takes them: one row.
    pub fn row(&self, sample: usize) -> Vec<f32> {
        let points = |of: &[Point2]| of.iter().flatten().map(|v| *v as f32).collect::<Vec<f32>>();
        let numbers = |of: &[f64]| of.iter().map(|v| *v as f32).collect::<Vec<f32>>();
        let marks = [points(&self.moved[sample]), points(&self.speed[sample])];
        [&marks[0][..], &marks[1], &numbers(&self.pressure[sample]), &numbers(&self.pressure_rate[sample])].concat()
    }
}

/// The parts of theory at every sample of a motion.
pub fn parts(tail: &Tail, moved: &[Vec<Point2>], speed: &[Vec<Point2>], rate: Hertz) -> Vec<Parts> {
    let terms: Vec<Terms> = moved.iter().zip(speed).map(|(m, v)| tail.terms(m, v)).collect();
    let gained = rates(&terms.iter().map(|t| t.momentum.value).collect::<Vec<_>>(), rate);
    let forward: Vec<f64> = speed.iter().map(|v| v.last().map_or(0.0, |p| p[0])).collect();
    let jerked = rates(&forward, rate);
    let one = |i: usize| {
        let t = &terms[i];
        Parts { simple: t.simple.value, shed: t.shed.value, gained: gained[i], drag: t.drag.value, jerked: jerked[i] }
    };
    (0..terms.len()).map(one).collect()
}

/// Rates by central differences, one-sided at the ends.
pub fn rates(values: &[f64], rate: Hertz) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    let at = |i: usize| {
        let (from, to) = (i.saturating_sub(1), (i + 1).min(last));
        if to > from { (values[to] - values[from]) * rate / (to - from) as f64 } else { 0.0 }
    };
    (0..values.len()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_of_a_parabola_are_exact_between_its_ends() {
        let values: Vec<f64> = (0..20).map(|i| (f64::from(i) / 10.0).powi(2)).collect();
        let found = rates(&values, 10.0);
        assert!((1..19).all(|i| (found[i] - 2.0 * i as f64 / 10.0).abs() < 1e-12));
    }
}
