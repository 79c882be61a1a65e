//! The verdict on one gradient: against converged central differences, the forward sensitivity, and the Taylor test.

use std::fmt;

use super::parameters::CaseParameter;
use diagnostics::Result;

/// Relative difference that a gradient may have from converged central differences.
const DIFFERENCE: f64 = 1e-6;
/// And from the forward sensitivity.
const FORWARD: f64 = 1e-7;
/// Tolerance of the slope of the first-order remainder about 2.
const SLOPE: f64 = 0.05;
/// A remainder below this fraction of the loss's change is rounding: a linear loss passes.
const STRAIGHT: f64 = 1e-7;
/// A change of the loss, which is of order one, below this is rounding: the parameter does not act, as a modulus does not
/// between grips whose displacement is given, and no relative difference of such a gradient means anything.
const ROUNDING: f64 = 1e-10;
/// How often a perturbation is divided by four where a parabola does not describe the loss over it.
const DIVISIONS: i32 = 2;

/// The result for one parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Which parameter.
    pub name: String,
    /// ∂L/∂θ by the adjoint, per unit of the parameter.
    pub backward: f64,
    /// Relative difference from central differences of fourth order.
    pub off_differences: f64,
    /// Relative difference from the forward sensitivity.
    pub off_forward: f64,
    /// Slope of |L(θ + ε) − L(θ) − ε ∂L/∂θ| over ε in logarithms; nothing when that is rounding.
    pub slope: Option<f64>,
}

impl Line {
    /// Whether all tolerances are met.
    pub fn holds(&self) -> bool {
        let Self { off_differences, off_forward, slope, .. } = self;
        *off_differences <= DIFFERENCE && *off_forward <= FORWARD && slope.is_none_or(|at| (at - 2.0).abs() <= SLOPE)
    }
}

/// Perturbs one parameter, by less where the differences have not converged, and evaluates the result.
pub(super) fn evaluate_line(
    parameter: &CaseParameter,
    backward: f64,
    forward: f64,
    mut loss: impl FnMut(f64) -> Result<f64>,
) -> Result<Line> {
    let gradients = [backward, forward];
    let mut line = evaluate_perturbation(parameter, gradients, &mut loss)?;
    for division in 1..=DIVISIONS {
        if line.holds() {
            break;
        }
        let scale = 0.25f64.powi(division);
        let closer = CaseParameter { turn: scale * parameter.turn, ..parameter.clone() };
        line = evaluate_perturbation(&closer, gradients, &mut |part| loss(scale * part))?;
    }
    Ok(line)
}

fn evaluate_perturbation(
    parameter: &CaseParameter,
    [backward, forward]: [f64; 2],
    loss: &mut impl FnMut(f64) -> Result<f64>,
) -> Result<Line> {
    let turn = parameter.turn;
    let [above, below] = [loss(1.0)?, loss(-1.0)?];
    if [above - below, backward * turn, forward * turn].iter().all(|change| change.abs() < ROUNDING) {
        return Ok(Line {
            name: parameter.name.clone(),
            backward,
            off_differences: 0.0,
            off_forward: 0.0,
            slope: None,
        });
    }
    let [near_above, near_below] = [loss(0.5)?, loss(-0.5)?];
    let (wide, close) = ((above - below) / (2.0 * turn), (near_above - near_below) / turn);
    let difference = (4.0 * close - wide) / 3.0;
    let loss_at_case = loss(0.0)?;
    let remainder = |there: f64, part: f64| (there - loss_at_case - part * turn * backward).abs();
    let (far, near) = (remainder(near_above, 0.5), remainder(loss(0.25)?, 0.25));
    let straight = far < STRAIGHT * (above - below).abs();
    let relative_error = |other: f64| (backward - other).abs() / other.abs().max(f64::MIN_POSITIVE);
    Ok(Line {
        name: parameter.name.clone(),
        backward,
        off_differences: relative_error(difference),
        off_forward: relative_error(forward),
        slope: (!straight).then(|| (far / near).log2()),
    })
}

/// The results for a case.
#[derive(Debug, Clone, PartialEq)]
pub struct GradientReport {
    /// Its file.
    pub case: String,
    /// Degrees of freedom.
    pub dofs: usize,
    /// One a parameter.
    pub lines: Vec<Line>,
}

impl GradientReport {
    /// Whether every parameter passes.
    pub fn holds(&self) -> bool {
        !self.lines.is_empty() && self.lines.iter().all(Line::holds)
    }
}

impl fmt::Display for GradientReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {} dofs", self.case, self.dofs)?;
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
        let passed = self.lines.iter().filter(|line| line.holds()).count();
        write!(
            f,
            "  {passed} of {} hold: differences within {DIFFERENCE:.0e}, forward within {FORWARD:.0e}, slope 2 ± {SLOPE}",
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
        let parameter = CaseParameter { name: "θ".into(), parameter: Parameter::MassDamping, value: 1.0, turn: 0.01 };
        evaluate_line(&parameter, backward, backward, |part| Ok((1.0 + 0.01 * part).exp())).unwrap()
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
    fn a_parameter_that_does_not_act_holds_only_with_a_gradient_of_zero() {
        let parameter = CaseParameter { name: "θ".into(), parameter: Parameter::MassDamping, value: 1.0, turn: 0.01 };
        let line = |backward: f64| evaluate_line(&parameter, backward, backward, |_| Ok(1.0)).unwrap();
        assert!(line(1e-20).holds() && !line(1e-3).holds());
    }

    /// ln θ at 1 over steps of 0.1: no parabola.
    #[test]
    fn a_perturbation_that_is_too_large_is_divided() {
        let parameter = CaseParameter { name: "θ".into(), parameter: Parameter::MassDamping, value: 1.0, turn: 0.1 };
        let line = evaluate_line(&parameter, 1.0, 1.0, |part| Ok((1.0 + 0.1 * part).ln())).unwrap();
        assert!(line.holds(), "{line:?}");
    }

    #[test]
    fn a_gradient_off_by_a_tenth_leaves_a_straight_line() {
        let slope = judged(1.1 * 1f64.exp()).slope.unwrap();
        assert!((slope - 1.0).abs() < 0.1, "{slope}");
    }
}
