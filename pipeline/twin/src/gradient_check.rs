//! Gradient check of a reduced tail: its adjoint against differences, and the Taylor test along each parameter.
//!
//! The chambers are filled in turn, to a pressure that bends the tail to `FAR` of its largest shape. The loss is without symmetry and
//! takes coordinates and velocities at every step. A parameter is changed relative to itself.

use std::fmt;

use crate::data::{Chamber, TwinData};
use crate::error::TwinError;
use crate::gradient::{LossGradient, MotionGradient};
use crate::recording::Recording;
use crate::twin::Twin;

/// Steps a second.
const RATE: f64 = 240.0;
/// Angular frequency of the pressures, and the rate of their beginning, 1/s.
const BEAT: [f64; 2] = [25.0, 30.0];
/// Largest coordinate of the motion at least, relative to the largest shape.
const FAR: f64 = 0.1;
/// Relative change of a parameter: small enough for a parabola, large enough against the tolerance of a step. In water it also bounds the error
/// by the drag, whose |w| w has no second derivative.
const PART: f64 = 3e-3;
/// Tolerance of a step, relative to the largest shape.
const TOLERANCE: f64 = 1e-11;
/// Relative difference that a gradient may have from converged central differences.
const DIFFERENCE: f64 = 1e-6;
/// A derivative below this fraction of the largest is compared with that: differences have no more digits.
const SMALL: f64 = 1e-2;
/// Tolerance of the slope of the first-order remainder about 2.
const SLOPE: f64 = 0.05;
/// A remainder below this fraction of the loss's change is rounding: a linear loss passes.
const STRAIGHT: f64 = 1e-6;

/// The result for one parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Which parameter.
    name: String,
    /// ∂L/∂ ln θ by the adjoint.
    backward: f64,
    /// Relative difference from central differences of fourth order.
    off_differences: f64,
    /// Slope of the first-order remainder over the change in logarithms; nothing when that is rounding.
    slope: Option<f64>,
}

/// The results for a tail.
#[derive(Debug, Clone, PartialEq)]
pub struct TwinGradientReport {
    name: String,
    coordinates: usize,
    lines: Vec<Line>,
}

/// A tail under pressures, steps × chambers in Pa.
#[derive(Clone)]
struct Motion {
    data: TwinData,
    pressures: Vec<Vec<f64>>,
}

/// A number of a motion, by which it is changed.
type Change = Box<dyn Fn(&mut Motion, f64)>;

/// Checks the gradients of a tail called `name` over `steps` steps.
///
/// # Errors
/// [`TwinError`] when the arrays do not belong together or a step is not found.
pub fn run(name: &str, data: &TwinData, steps: usize) -> Result<TwinGradientReport, TwinError> {
    // the pressure that bends a tail far enough may be beyond those that it was reduced under, where its gradient is as exact
    let mut data = data.clone();
    data.chambers.iter_mut().for_each(|chamber| chamber.range = Chamber::UNLIMITED);
    let motion = Motion::new(&data, steps)?;
    let (twin, recording) = motion.record_motion()?;
    let gradient = twin.adjoint(&recording, &mut |step| step_loss(data.size, &recording, step).1)?;
    let changes = parameter_changes(&motion, &gradient);
    let largest = changes.iter().fold(0.0, |greatest: f64, (_, derivative, _)| greatest.max(derivative.abs()));
    let lines = changes.into_iter().map(|(name, backward, change)| {
        evaluate_parameter(name, [backward, SMALL * largest], |part| {
            let mut motion = motion.clone();
            change(&mut motion, part);
            motion.total_loss()
        })
    });
    Ok(TwinGradientReport {
        name: name.to_owned(),
        coordinates: data.coordinates(),
        lines: lines.collect::<Result<_, _>>()?,
    })
}

impl Motion {
    /// Under the least power of two of a pascal that bends it far enough.
    fn new(data: &TwinData, steps: usize) -> Result<Self, TwinError> {
        let mut amplitude = 1.0;
        loop {
            let motion =
                Self { data: data.clone(), pressures: pressure_histories(amplitude, data.chambers.len(), steps) };
            let (_, recording) = motion.record_motion()?;
            let shapes = (0..steps).flat_map(|step| recording.coordinates(step));
            let far = shapes.fold(0.0, |far: f64, q| far.max(q.abs()));
            // a tail without chambers does not move
            if far > FAR * data.size || far == 0.0 {
                return Ok(motion);
            }
            amplitude *= 2.0;
        }
    }

    fn record_motion(&self) -> Result<(Twin, Recording), TwinError> {
        let twin = Twin::new(self.data.clone())?.with_tolerance(TOLERANCE);
        let mut recording = twin.recording();
        self.pressures.iter().try_for_each(|pressures| twin.record(&mut recording, pressures, 1.0 / RATE))?;
        Ok((twin, recording))
    }

    fn total_loss(&self) -> Result<f64, TwinError> {
        let (_, recording) = self.record_motion()?;
        Ok((0..self.pressures.len()).map(|step| step_loss(self.data.size, &recording, step).0).sum())
    }
}

/// Pressures of chambers that are filled in turn, Pa: steps × chambers.
fn pressure_histories(amplitude: f64, chambers: usize, steps: usize) -> Vec<Vec<f64>> {
    let pressure_at = |t: f64, chamber: usize| {
        let phase = std::f64::consts::TAU * chamber as f64 / chambers as f64;
        amplitude * (1.0 - (-BEAT[1] * t).exp()) * (1.0 + (BEAT[0] * t + phase).sin())
    };
    (1..=steps).map(|step| (0..chambers).map(|chamber| pressure_at(step as f64 / RATE, chamber)).collect()).collect()
}

/// The part of one step in the loss, and its derivatives: Σ (l + ½ l²) over l = Σ w q/s and l = Σ w q̇/(s BEAT).
fn step_loss(size: f64, recording: &Recording, step: usize) -> (f64, LossGradient) {
    let part = |values: &[f64], size: f64| {
        let weight = |m: usize| (0.37 * (m + 1) as f64 + 0.11 * step as f64).sin() / size;
        let l: f64 = values.iter().enumerate().map(|(m, x)| weight(m) * x).sum();
        (l + 0.5 * l * l, (0..values.len()).map(|m| weight(m) * (1.0 + l)).collect::<Vec<_>>())
    };
    let (shape, coordinates) = part(recording.coordinates(step), size);
    let (speed, velocity) = part(recording.velocity(step), size * BEAT[0]);
    (shape + speed, LossGradient { coordinates, velocity })
}

/// Every parameter: its name, the derivative by its logarithm, and its change.
fn parameter_changes(motion: &Motion, gradient: &MotionGradient) -> Vec<(String, f64, Change)> {
    let of_regions = (0..motion.data.regions.len()).flat_map(|region| region_changes(motion, gradient, region));
    let of_chambers = (0..motion.data.chambers.len()).map(|chamber| {
        let derivative =
            gradient.pressures.iter().zip(&motion.pressures).map(|(gradient, p)| gradient[chamber] * p[chamber]).sum();
        let change = move |motion: &mut Motion, part: f64| {
            motion.pressures.iter_mut().for_each(|pressures| pressures[chamber] *= 1.0 + part);
        };
        (format!("chamber {chamber}, pressure"), derivative, Box::new(change) as Change)
    });
    let mut changes: Vec<_> = of_regions.chain(of_chambers).collect();
    if !motion.data.sections.is_empty() {
        changes.push((
            "water, added mass".into(),
            gradient.water[0],
            Box::new(|motion, part| scale_water(motion, part, &[0, 2, 3])),
        ));
        changes.push((
            "water, drag".into(),
            gradient.water[1],
            Box::new(|motion, part| scale_water(motion, part, &[1])),
        ));
    }
    changes
}

/// The parameters of one region that are not zero.
fn region_changes(motion: &Motion, gradient: &MotionGradient, region: usize) -> Vec<(String, f64, Change)> {
    let (properties, gradient) = (&motion.data.regions[region], &gradient.regions[region]);
    let mut changes: Vec<(String, f64, Change)> = vec![
        (
            format!("region {region}, mu"),
            gradient.mu * properties.mu,
            Box::new(move |m, part| m.data.regions[region].mu *= 1.0 + part),
        ),
        (
            format!("region {region}, lambda"),
            gradient.lambda * properties.lambda,
            Box::new(move |m, part| m.data.regions[region].lambda *= 1.0 + part),
        ),
    ];
    for term in (0..2).filter(|term| properties.stiffening[*term] != 0.0) {
        let change = move |m: &mut Motion, part: f64| m.data.regions[region].stiffening[term] *= 1.0 + part;
        let derivative = gradient.stiffening[term] * properties.stiffening[term];
        changes.push((format!("region {region}, C{}0", term + 2), derivative, Box::new(change)));
    }
    for (branch, which) in (0..properties.branches.len()).flat_map(|branch| [(branch, 0), (branch, 1)]) {
        let change = move |m: &mut Motion, part: f64| m.data.regions[region].branches[branch][which] *= 1.0 + part;
        let derivative = gradient.branches[branch][which] * properties.branches[branch][which];
        let name = format!("region {region}, {} of branch {branch}", ["strength", "time"][which]);
        changes.push((name, derivative, Box::new(change)));
    }
    changes
}

fn scale_water(motion: &mut Motion, part: f64, numbers: &[usize]) {
    for section in &mut motion.data.sections {
        numbers.iter().for_each(|k| section.by[*k] *= 1.0 + part);
    }
}

/// Evaluates the result for one parameter from losses at its changes; `smallest_scale` is what a difference is compared with at least.
fn evaluate_parameter(
    name: String,
    [backward, smallest_scale]: [f64; 2],
    loss: impl Fn(f64) -> Result<f64, TwinError>,
) -> Result<Line, TwinError> {
    let [above, below] = [loss(PART)?, loss(-PART)?];
    let [near_above, near_below] = [loss(0.5 * PART)?, loss(-0.5 * PART)?];
    let difference = (8.0 * (near_above - near_below) - (above - below)) / (6.0 * PART);
    let unchanged = loss(0.0)?;
    let remainder = |there: f64, part: f64| (there - unchanged - part * backward).abs();
    let (far, near) = (remainder(above, PART), remainder(near_above, 0.5 * PART));
    let straight = far < STRAIGHT * (above - below).abs().max(smallest_scale * PART);
    let off_differences = (backward - difference).abs() / difference.abs().max(smallest_scale).max(f64::MIN_POSITIVE);
    Ok(Line { name, backward, off_differences, slope: (!straight).then(|| (far / near).log2()) })
}

impl Line {
    fn holds(&self) -> bool {
        self.off_differences <= DIFFERENCE && self.slope.is_none_or(|at| (at - 2.0).abs() <= SLOPE)
    }
}

impl TwinGradientReport {
    /// Whether every parameter passes.
    pub fn holds(&self) -> bool {
        !self.lines.is_empty() && self.lines.iter().all(Line::holds)
    }
}

impl fmt::Display for TwinGradientReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {} coordinates", self.name, self.coordinates)?;
        let heads = ["parameter", "gradient", "off differences", "Taylor slope"];
        writeln!(f, "  {:36} {:>14} {:>16} {:>13}", heads[0], heads[1], heads[2], heads[3])?;
        for line in &self.lines {
            let slope = line.slope.map_or("straight".into(), |slope| format!("{slope:.3}"));
            let verdict = if line.holds() { "holds" } else { "FAILS" };
            let Line { name, backward, off_differences, .. } = line;
            writeln!(f, "  {name:36} {backward:14.6e} {off_differences:16.1e} {slope:>13} {verdict}")?;
        }
        let (held, all) = (self.lines.iter().filter(|line| line.holds()).count(), self.lines.len());
        write!(
            f,
            "  {held} of {all} hold: differences within {DIFFERENCE:.0e}, slope 2 ± {SLOPE}; gradients by logarithms"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::beam;

    #[test]
    fn every_gradient_of_the_example_holds_in_air_and_in_water() {
        for (name, count) in [("air", 10), ("water", 12)] {
            let report = run(name, &beam(name == "water"), 12).unwrap();
            println!("{report}");
            assert!(report.holds() && report.lines.len() == count, "{report}");
        }
    }

    #[test]
    fn a_gradient_off_by_a_hundred_thousandth_fails() {
        let judged = |off: f64| {
            evaluate_parameter("e".into(), [1f64.exp() * (1.0 + off), 0.0], |part| Ok((1.0 + part).exp())).unwrap()
        };
        assert!(judged(0.0).holds() && !judged(1e-5).holds());
    }

    #[test]
    fn a_report_holds_when_it_has_lines_and_each_of_them_does() {
        let judged = |off: f64| {
            evaluate_parameter("e".into(), [1f64.exp() * (1.0 + off), 0.0], |part| Ok((1.0 + part).exp())).unwrap()
        };
        let report = |lines: Vec<Line>| TwinGradientReport { name: "e".into(), coordinates: 1, lines };
        assert!(report(vec![judged(0.0), judged(0.0)]).holds());
        assert!(!report(vec![judged(0.0), judged(1e-3)]).holds() && !report(Vec::new()).holds());
    }

    #[test]
    fn a_remainder_falls_with_the_square_of_the_change_and_a_line_has_none() {
        let curved = evaluate_parameter("e".into(), [1f64.exp(), 0.0], |part| Ok((1.0 + part).exp())).unwrap();
        assert!((curved.slope.unwrap() - 2.0).abs() < 0.01 && curved.off_differences < 1e-9, "{:?}", curved.slope);
        let straight = evaluate_parameter("a".into(), [3.0, 0.0], |part| Ok(1.0 + 3.0 * part)).unwrap();
        assert!(straight.slope.is_none() && straight.off_differences < 1e-9);
    }
}
