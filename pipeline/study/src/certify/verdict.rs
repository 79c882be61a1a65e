//! The verdict on one gradient: against converged central differences, the other direction, and Taylor's slope.
//!
//! Stands on: `knobs`. Never knows: how a loss is computed.

use std::fmt;

use super::knobs::Knob;
use crate::fault::Outcome;

/// Relative difference that a gradient may have from converged central differences.
const DIFFERENCE: f64 = 1e-6;
/// And from the forward sensitivity.
const FORWARD: f64 = 1e-7;
/// By how much the slope of what the gradient leaves may be off 2.
const SLOPE: f64 = 0.05;
/// What the gradient leaves is rounding below this part of the loss's change: a loss that is a straight line passes.
const STRAIGHT: f64 = 1e-7;

/// What was found for one parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Which parameter.
    pub name: String,
    /// ∂L/∂θ by the pass backwards, per unit of the parameter.
    pub backward: f64,
    /// Relative difference from central differences of fourth order.
    pub off_differences: f64,
    /// Relative difference from the forward sensitivity.
    pub off_forward: f64,
    /// Slope of |L(θ + ε) − L(θ) − ε ∂L/∂θ| over ε in logarithms; nothing when that is rounding.
    pub slope: Option<f64>,
}

impl Line {
    /// Whether all of it is as it should be.
    pub fn holds(&self) -> bool {
        let Self { off_differences, off_forward, slope, .. } = self;
        *off_differences <= DIFFERENCE && *off_forward <= FORWARD && slope.is_none_or(|at| (at - 2.0).abs() <= SLOPE)
    }
}

/// Turns one knob and judges.
pub(super) fn line(
    knob: &Knob,
    backward: f64,
    forward: f64,
    mut loss: impl FnMut(f64) -> Outcome<f64>,
) -> Outcome<Line> {
    let [above, below] = [loss(1.0)?, loss(-1.0)?];
    let [near_above, near_below] = [loss(0.5)?, loss(-0.5)?];
    let (wide, close) = ((above - below) / (2.0 * knob.turn), (near_above - near_below) / knob.turn);
    let difference = (4.0 * close - wide) / 3.0;
    let here = loss(0.0)?;
    let left = |there: f64, part: f64| (there - here - part * knob.turn * backward).abs();
    let (far, near) = (left(near_above, 0.5), left(loss(0.25)?, 0.25));
    let straight = far < STRAIGHT * (above - below).abs();
    let off = |other: f64| (backward - other).abs() / other.abs().max(f64::MIN_POSITIVE);
    Ok(Line {
        name: knob.name.clone(),
        backward,
        off_differences: off(difference),
        off_forward: off(forward),
        slope: (!straight).then(|| (far / near).log2()),
    })
}

/// What was found for a case.
#[derive(Debug, Clone, PartialEq)]
pub struct Certificate {
    /// Its file.
    pub case: String,
    /// Degrees of freedom.
    pub freedoms: usize,
    /// One a parameter.
    pub lines: Vec<Line>,
}

impl Certificate {
    /// Whether every line holds.
    pub fn holds(&self) -> bool {
        !self.lines.is_empty() && self.lines.iter().all(Line::holds)
    }
}

impl fmt::Display for Certificate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {} dofs", self.case, self.freedoms)?;
        let heads = ["parameter", "gradient", "off differences", "off forward", "Taylor slope"];
        writeln!(f, "  {:36} {:>14} {:>16} {:>13} {:>13}", heads[0], heads[1], heads[2], heads[3], heads[4])?;
        for line in &self.lines {
            let slope = line.slope.map_or("straight".into(), |slope| format!("{slope:.3}"));
            let Line { name, backward, off_differences, off_forward, .. } = line;
            let verdict = if line.holds() { "holds" } else { "FAILS" };
            writeln!(
                f,
                "  {name:36} {backward:14.6e} {off_differences:16.1e} {off_forward:13.1e} {slope:>13} {verdict}"
            )?;
        }
        let held = self.lines.iter().filter(|line| line.holds()).count();
        write!(
            f,
            "  {held} of {} hold: differences within {DIFFERENCE:.0e}, forward within {FORWARD:.0e}, slope 2 ± {SLOPE}",
            self.lines.len()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fem::Parameter;

    /// The line of a loss e^θ at θ = 1 whose gradient is said to be `backward`.
    fn judged(backward: f64) -> Line {
        let knob = Knob { name: "θ".into(), parameter: Parameter::MassDamping, value: 1.0, turn: 0.01 };
        line(&knob, backward, backward, |part| Ok((1.0 + 0.01 * part).exp())).unwrap()
    }

    #[test]
    fn a_true_gradient_holds_and_its_remainder_falls_with_the_square() {
        let line = judged(1f64.exp());
        assert!(line.holds() && line.off_differences < 1e-9, "{line:?}");
    }

    #[test]
    fn a_gradient_off_by_a_hundred_thousandth_fails() {
        assert!(!judged(1f64.exp() * (1.0 + 1e-5)).holds());
    }

    #[test]
    fn a_gradient_off_by_a_tenth_leaves_a_straight_line() {
        let slope = judged(1.1 * 1f64.exp()).slope.unwrap();
        assert!((slope - 1.0).abs() < 0.1, "{slope}");
    }
}
