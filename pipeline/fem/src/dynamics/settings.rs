//! Settings of time integration: schemes, damping, step size, and the initial value problem.

use crate::solve_error::SolveError;
use si::{Hertz, Metre, Pascal, Second};

/// Time integration scheme.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    /// First order; numerical damping of every motion, stronger at higher frequency.
    ImplicitEuler,
    /// Second-order backward differences; damps only motions that the step does not resolve. Its first step is one of
    /// implicit Euler.
    Bdf2,
    /// Without inertia and damping: each state is the equilibrium of its time, after all that relaxed before. The first
    /// step may carry the whole load; states have no velocity.
    QuasiStatic,
}

/// Settings of time integration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DynamicSettings {
    /// Time step.
    pub step: Second,
    /// Scheme.
    pub scheme: Scheme,
    /// α of Rayleigh damping, 1/s. A mode of angular frequency ω has the damping ratio α/2ω + βω/2.
    pub mass_damping: Hertz,
    /// β of Rayleigh damping, s.
    pub stiffness_damping: Second,
    /// The last Newton step of a time step moves no node further than this fraction of the body's size.
    pub tolerance: f64,
}

impl Default for DynamicSettings {
    /// Second order with 240 steps per second, undamped, each solved to a millionth of the size: a tenth of a
    /// micrometre on a tail, a hundredth of what a camera resolves.
    fn default() -> Self {
        let (mass_damping, stiffness_damping) = (0.0, 0.0);
        Self { step: 1.0 / 240.0, scheme: Scheme::Bdf2, mass_damping, stiffness_damping, tolerance: 1e-6 }
    }
}

/// Step size control by an error estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepControl {
    /// Largest local error of one step, over all nodes, m.
    pub tolerance: Metre,
    /// Shortest step; also the length of the first one.
    pub shortest: Second,
    /// Longest step.
    pub longest: Second,
}

/// An initial value problem: settings, initial state and pressure history.
#[derive(Clone, Copy)]
pub struct InitialValueProblem<'a> {
    /// How it is integrated.
    pub settings: &'a DynamicSettings,
    /// State at time 0.
    pub initial: &'a State,
    /// One pressure per chamber (Pa) at a time (s from the start).
    pub pressures: &'a dyn Fn(Second) -> Vec<Pascal>,
}

/// State of motion.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// 3 entries per node, m.
    pub displacement: Vec<f64>,
    /// 3 entries per node, m/s.
    pub velocity: Vec<f64>,
}

impl State {
    /// The undeformed body at rest, of `nodes` nodes.
    pub fn rest(nodes: usize) -> Self {
        Self { displacement: vec![0.0; 3 * nodes], velocity: vec![0.0; 3 * nodes] }
    }
}

/// # Errors
/// [`SolveError::Setting`] when a number of `settings` is out of range.
pub(crate) fn check_settings(settings: &DynamicSettings) -> Result<(), SolveError> {
    check_positive("the time step", settings.step, "above 0 s")?;
    not_negative("the mass damping", settings.mass_damping)?;
    not_negative("the stiffness damping", settings.stiffness_damping)?;
    if !(settings.tolerance > 0.0 && settings.tolerance <= 1e-2) {
        let (what, range) = ("the tolerance of a time step", "above 0 and at most 0.01 of the body's size");
        return Err(SolveError::Setting { what, value: settings.tolerance, range });
    }
    Ok(())
}

/// # Errors
/// [`SolveError::Setting`] when a number of `control` is out of range.
pub(crate) fn check_control(control: &StepControl) -> Result<(), SolveError> {
    check_positive("the error of a step", control.tolerance, "above 0 m")?;
    check_positive("the shortest step", control.shortest, "above 0 s")?;
    if control.longest.is_nan() || control.longest < control.shortest {
        return Err(SolveError::Setting {
            what: "the longest step",
            value: control.longest,
            range: "not below the shortest",
        });
    }
    Ok(())
}

fn check_positive(what: &'static str, value: f64, range: &'static str) -> Result<(), SolveError> {
    if value > 0.0 && value.is_finite() { Ok(()) } else { Err(SolveError::Setting { what, value, range }) }
}

fn not_negative(what: &'static str, value: f64) -> Result<(), SolveError> {
    let range = "a finite number, not below 0";
    if value >= 0.0 && value.is_finite() { Ok(()) } else { Err(SolveError::Setting { what, value, range }) }
}
