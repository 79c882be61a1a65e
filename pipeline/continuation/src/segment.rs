//! The part of a path between two of its points, and roots of functions along it by the Illinois method [dowell1971].

use crate::constraint::Constraint;
use crate::corrector::{Corrector, Guess};
use crate::error::StepFailure;
use crate::point::Sample;
use crate::subspace::Accuracy;
use si::Metre;

/// Points solved for at most.
const MAX_POINTS: usize = 40;
/// A root is found when the bracket is below this fraction of the segment, or the function of its value at the ends. The
/// bordered tangent is singular at a bifurcation, too: closer to it Newton's method ends in rounding.
const FOUND: f64 = 1e-6;
/// Where a point cannot be solved for, a bracket with a value below this fraction is close enough.
const CLOSE: f64 = 1e-3;

/// Two neighbouring points of a path.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Segment<'a> {
    pub from: &'a Sample,
    pub to: &'a Sample,
}

/// One end of a bracket.
struct End {
    /// Distance from the beginning of the segment.
    radius: Metre,
    value: f64,
    sample: Sample,
}

impl Segment<'_> {
    /// Distance of its ends.
    pub fn length(&self) -> Metre {
        self.increment().iter().map(|entry| entry * entry).sum::<f64>().sqrt()
    }

    /// u at its end less u at its beginning.
    pub(crate) fn increment(&self) -> Vec<f64> {
        self.to.u.iter().zip(&self.from.u).map(|(to, from)| to - from).collect()
    }

    /// Whether λ turns round between its ends.
    pub(crate) fn turns_round(&self) -> bool {
        let rate_along = |sample: &Sample| sparse::dot(&self.increment(), &sample.by_load);
        (rate_along(self.from) > 0.0) != (rate_along(self.to) > 0.0)
    }

    /// The point at which `value` changes its sign, which it must have done between the ends; solved again to the
    /// accuracy of a critical point.
    ///
    /// # Errors
    /// [`StepFailure`]
    pub fn find_root(&self, corrector: &mut Corrector, value: &dyn Fn(&Sample) -> f64) -> Result<Sample, StepFailure> {
        let end = |radius: f64, sample: &Sample| End { radius, value: value(sample), sample: sample.clone() };
        let length = self.length();
        let mut bracket = [end(0.0, self.from), end(length, self.to)];
        let scale = bracket.iter().fold(0.0, |largest: f64, end| largest.max(end.value.abs()));
        let mut last = usize::MAX;
        for _ in 0..MAX_POINTS {
            let radius = next_radius(&bracket);
            let sample = match self.point_at(corrector, radius, &bracket) {
                Ok(sample) => sample,
                Err(_) if nearest_end(&bracket).value.abs() <= CLOSE * scale => break,
                Err(cause) => return Err(cause),
            };
            let new_end = end(radius, &sample);
            let side = usize::from((new_end.value > 0.0) == (bracket[1].value > 0.0));
            let small = new_end.value.abs() <= FOUND * scale;
            bracket[side] = new_end;
            if small || bracket[1].radius - bracket[0].radius <= FOUND * length {
                break;
            }
            // Illinois: the value of an end that stays a second time counts half, so that both ends move.
            bracket[1 - side].value *= if last == side { 0.5 } else { 1.0 };
            last = side;
        }
        Ok(nearest_end(&bracket).sample.clone())
    }

    /// The point at distance `radius` from the beginning, guessed between two points around it.
    fn point_at(&self, corrector: &mut Corrector, radius: f64, around: &[End; 2]) -> Result<Sample, StepFailure> {
        let part = (radius - around[0].radius) / (around[1].radius - around[0].radius);
        let guess = guess_between(&around[0].sample, &around[1].sample, part);
        corrector.solve(guess, Constraint::Cylinder { centre: &self.from.u, radius }, Accuracy::Critical)
    }
}

/// The point at a `part` of the way from `from` to `to` on the cubic that has both ends and their tangents: a straight
/// line would stretch a thin wall where it rotates.
pub(crate) fn guess_between<'a>(from: &'a Sample, to: &Sample, part: f64) -> Guess<'a> {
    let segment = Segment { from, to };
    let (increment, length) = (segment.increment(), segment.length());
    let complement = 1.0 - part;
    let weights = [complement * complement * part, -part * part * complement].map(|weight| weight * length);
    let tangents = [from, to].map(|end| tangent_factor(end, &increment));
    let value = part * part * (3.0 - 2.0 * part);
    let mut u = from.u.clone();
    sparse::add(&mut u, value, &increment);
    let mut load_factor = from.load_factor + value * (to.load_factor - from.load_factor);
    for ((end, factor), weight) in [from, to].into_iter().zip(tangents).zip(weights) {
        sparse::add(&mut u, weight * factor, &end.by_load);
        load_factor += weight * factor;
    }
    Guess { u, load_factor, previous: Some(&from.u) }
}

/// dλ/ds, the factor that makes of du/dλ the unit tangent in the direction of `increment`.
fn tangent_factor(end: &Sample, increment: &[f64]) -> f64 {
    let norm = sparse::dot(&end.by_load, &end.by_load).sqrt();
    sparse::dot(&end.by_load, increment).signum() / norm
}

/// The end nearer to the root.
fn nearest_end(bracket: &[End; 2]) -> &End {
    &bracket[usize::from(bracket[1].value.abs() < bracket[0].value.abs())]
}

/// The secant's root, kept a hundredth off both ends; the middle where a value is not known.
fn next_radius([low, high]: &[End; 2]) -> f64 {
    let part = low.value / (low.value - high.value);
    let part = if part.is_finite() { part.clamp(0.01, 0.99) } else { 0.5 };
    low.radius + part * (high.radius - low.radius)
}
