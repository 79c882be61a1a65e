//! How a motion is stepped: schemes, damping, steps, and the state that is stepped.
//!
//! Stands on: `solver` (its errors). Never knows: how a step is solved.

use crate::stall::SolveError;
use si::{Hertz, Metre, Second};

/// How a step is taken from the past.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    /// First order; damps every motion, the faster the more.
    ImplicitEuler,
    /// Second order; damps only motions that the step cannot resolve. Its first step is one of implicit Euler.
    Bdf2,
}

/// The settings of a march through time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct March {
    /// Time step.
    pub step: Second,
    /// How a step is taken.
    pub scheme: Scheme,
    /// α of Rayleigh's damping, 1/s: slow motions. A mode of angular frequency ω gets the ratio α/2ω + βω/2.
    pub mass_damping: Hertz,
    /// β of Rayleigh's damping, s: fast motions.
    pub stiffness_damping: Second,
    /// The last correction of a time step moves no node further than this part of the body's size.
    pub tolerance: f64,
}

impl Default for March {
    /// Second order at 240 steps a second, undamped, each solved to a millionth of the size: a tenth of a micrometre on
    /// a tail, a hundredth of what a camera resolves.
    fn default() -> Self {
        let (mass_damping, stiffness_damping) = (0.0, 0.0);
        Self { step: 1.0 / 240.0, scheme: Scheme::Bdf2, mass_damping, stiffness_damping, tolerance: 1e-6 }
    }
}

/// A march that chooses its own steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adaptive {
    /// Error that one step may make, as the largest distance of a node, m.
    pub tolerance: Metre,
    /// Steps are never shorter; the first one is of this length.
    pub shortest: Second,
    /// Steps are never longer.
    pub longest: Second,
}

/// A shape in motion.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// 3 a node, m.
    pub displacement: Vec<f64>,
    /// 3 a node, m/s.
    pub velocity: Vec<f64>,
}

impl State {
    /// `nodes` nodes at rest.
    pub fn rest(nodes: usize) -> Self {
        Self { displacement: vec![0.0; 3 * nodes], velocity: vec![0.0; 3 * nodes] }
    }
}

/// # Errors
/// [`SolveError::Setting`] when a number of `march` is out of range.
pub(crate) fn check(march: &March) -> Result<(), SolveError> {
    positive("the time step", march.step, "above 0 s")?;
    not_negative("the mass damping", march.mass_damping)?;
    not_negative("the stiffness damping", march.stiffness_damping)?;
    if !(march.tolerance > 0.0 && march.tolerance <= 1e-2) {
        let (what, range) = ("the tolerance of a time step", "above 0 and at most 0.01 of the body's size");
        return Err(SolveError::Setting { what, value: march.tolerance, range });
    }
    Ok(())
}

/// # Errors
/// [`SolveError::Setting`] when a number of `adaptive` is out of range.
pub(crate) fn check_adaptive(adaptive: &Adaptive) -> Result<(), SolveError> {
    positive("the error of a step", adaptive.tolerance, "above 0 m")?;
    positive("the shortest step", adaptive.shortest, "above 0 s")?;
    if adaptive.longest.is_nan() || adaptive.longest < adaptive.shortest {
        return Err(SolveError::Setting {
            what: "the longest step",
            value: adaptive.longest,
            range: "not below the shortest",
        });
    }
    Ok(())
}

fn positive(what: &'static str, value: f64, range: &'static str) -> Result<(), SolveError> {
    if value > 0.0 && value.is_finite() { Ok(()) } else { Err(SolveError::Setting { what, value, range }) }
}

fn not_negative(what: &'static str, value: f64) -> Result<(), SolveError> {
    let range = "a finite number, not below 0";
    if value >= 0.0 && value.is_finite() { Ok(()) } else { Err(SolveError::Setting { what, value, range }) }
}
