//! A run: one flapping trial as evenly spaced samples, each with force, markers, pressures and their rates.

use diagnostics::Result;
use hydro::{Tail, Terms};
use lab::card::Split;
use si::{Hertz, Metre, Newton, Pascal, Point2, Second, Series};

/// One trial, samples × each.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The trial's id.
    pub id: String,
    /// Commanded pressure, Pa.
    pub amplitude: Pascal,
    /// Flapping frequency, Hz.
    pub frequency: Hertz,
    /// Training or test, by the card.
    pub split: Option<Split>,
    /// Samples a second.
    pub rate: Hertz,
    /// s on the film's clock.
    pub time: Vec<Second>,
    /// Measured force, N.
    pub force: Vec<Newton>,
    /// Displacement of each marker, m: samples × markers.
    pub moved: Vec<Vec<Point2>>,
    /// Velocity of each marker, m/s: samples × markers.
    pub speed: Vec<Vec<Point2>>,
    /// Pressure of each chamber, Pa: samples × chambers.
    pub pressure: Vec<Vec<Pascal>>,
    /// Rate of each pressure, Pa/s: samples × chambers.
    pub pressure_rate: Vec<Vec<f64>>,
    /// The terms of theory, one set a sample.
    pub terms: Vec<TheoryTerms>,
}

/// The terms of elongated-body theory at one sample, N, with coefficients of one \[lighthill1971\].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TheoryTerms {
    /// ½ m ẏ² at the trailing edge, the form used in the paper.
    pub trailing_edge: f64,
    /// Momentum flux at the trailing edge.
    pub edge_flux: f64,
    /// Rate of the added-mass momentum.
    pub momentum_rate: f64,
    /// Drag for a coefficient of one.
    pub drag: f64,
    /// x acceleration of the last marker, m/s²: the inertia of the tail.
    pub tip_acceleration: f64,
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

    /// Samples of one cycle, at least one.
    pub fn samples_per_cycle(&self) -> usize {
        ((self.rate / self.frequency).round() as usize).max(1)
    }

    /// Lateral amplitude of the last marker, m.
    pub fn amplitude_of_tip(&self) -> Metre {
        let lateral = self.moved.iter().filter_map(|m| m.last()).map(|p| p[1]);
        let (low, high) =
            lateral.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), lateral| (l.min(lateral), h.max(lateral)));
        if high > low { 0.5 * (high - low) } else { 0.0 }
    }

    /// Mean measured force, N.
    pub(crate) fn mean_force(&self) -> Newton {
        self.force.iter().sum::<f64>() / self.len().max(1) as f64
    }

    /// The measured pressures as functions of time, one a chamber: the whole cycles of the run, repeated.
    ///
    /// # Errors
    /// A [`diagnostics::Diagnostic`] when a pressure is not finite.
    pub(crate) fn periodic_pressures(&self) -> Result<Vec<impl Fn(Second) -> Pascal>> {
        let cycles = (self.len() as f64 / self.rate * self.frequency).round().max(1.0);
        let period = cycles / self.frequency;
        let chambers = self.pressure.first().map_or(0, Vec::len);
        let periodic_pressure = |chamber: usize| -> Result<_> {
            let gauge = Series::new(0.0, self.rate, self.pressure.iter().map(|p| p[chamber]).collect())?;
            Ok(move |t: Second| gauge.at(t.rem_euclid(period)))
        };
        (0..chambers).map(periodic_pressure).collect()
    }

    /// Positions and velocities of the markers, pressures and their rates, as the network takes them: one row.
    pub fn row(&self, sample: usize) -> Vec<f32> {
        let flat_points = |values: &[Point2]| values.iter().flatten().map(|v| *v as f32).collect::<Vec<f32>>();
        let numbers = |values: &[f64]| values.iter().map(|v| *v as f32).collect::<Vec<f32>>();
        let motion = [flat_points(&self.moved[sample]), flat_points(&self.speed[sample])];
        [&motion[0][..], &motion[1], &numbers(&self.pressure[sample]), &numbers(&self.pressure_rate[sample])].concat()
    }
}

/// The terms of theory at every sample of a motion.
pub fn theory_terms(tail: &Tail, moved: &[Vec<Point2>], speed: &[Vec<Point2>], rate: Hertz) -> Vec<TheoryTerms> {
    let terms: Vec<Terms> = moved.iter().zip(speed).map(|(m, v)| tail.terms(m, v)).collect();
    let momentum_rate = central_rates(&terms.iter().map(|t| t.momentum.value).collect::<Vec<_>>(), rate);
    let axial_velocity: Vec<f64> = speed.iter().map(|v| v.last().map_or(0.0, |p| p[0])).collect();
    let tip_acceleration = central_rates(&axial_velocity, rate);
    let terms_at = |i: usize| {
        let t = &terms[i];
        TheoryTerms {
            trailing_edge: t.trailing_edge.value,
            edge_flux: t.edge_flux.value,
            momentum_rate: momentum_rate[i],
            drag: t.drag.value,
            tip_acceleration: tip_acceleration[i],
        }
    };
    (0..terms.len()).map(terms_at).collect()
}

/// Rates by central differences, one-sided at the ends.
pub fn central_rates(values: &[f64], rate: Hertz) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    let difference = |i: usize| {
        let (lower, upper) = (i.saturating_sub(1), (i + 1).min(last));
        if upper > lower { (values[upper] - values[lower]) * rate / (upper - lower) as f64 } else { 0.0 }
    };
    (0..values.len()).map(difference).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_of_a_parabola_are_exact_between_its_ends() {
        let values: Vec<f64> = (0..20).map(|i| (f64::from(i) / 10.0).powi(2)).collect();
        let found = central_rates(&values, 10.0);
        assert!((1..19).all(|i| (found[i] - 2.0 * i as f64 / 10.0).abs() < 1e-12));
    }
}
