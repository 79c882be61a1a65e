//! Time integration of the whole body, the reference for the reduced model.

use diagnostics::{Diagnostic, Result};
use fem::{DynamicSettings, InitialValueProblem, Scheme, State};
use si::{Hertz, Pascal, Second};

use super::{Body, SampledMotion};

/// The interval of a motion and its sampling.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    /// The body is at rest until then, s.
    pub start: Second,
    /// s.
    pub end: Second,
    /// Stored shapes a second, from `start` on.
    pub rate: Hertz,
    /// Largest time step, s; the step used divides the time between stored shapes.
    pub step: Second,
}

/// The motion under the pressures (left, right; Pa) at any time (s), by BDF2. `tick` is called after
/// each stored shape.
///
/// # Errors
/// When a step does not converge.
pub fn integrate(
    body: &Body,
    sampling: &Sampling,
    pressures: &dyn Fn(Second) -> [Pascal; 2],
    tick: &dyn Fn(),
) -> Result<SampledMotion> {
    let Sampling { start, end, rate, step } = *sampling;
    let each = (1.0 / (rate * step)).round().max(1.0) as usize;
    let stored = ((end - start) * rate).ceil() as usize;
    let settings =
        DynamicSettings { step: 1.0 / (rate * each as f64), scheme: Scheme::Bdf2, ..DynamicSettings::default() };
    let rest_state = State::rest(body.mesh.nodes.len());
    let mut shapes = vec![rest_state.displacement.iter().map(|u| *u as f32).collect::<Vec<f32>>()];
    let mut steps = 0;
    let mut observe = |_: Second, state: &State| {
        steps += 1;
        if steps % each == 0 {
            shapes.push(state.displacement.iter().map(|u| *u as f32).collect());
            tick();
        }
    };
    let chambers = |t: Second| {
        let [left, right] = pressures(start + t);
        body.pressures(left, right)
    };
    let problem = InitialValueProblem { settings: &settings, initial: &rest_state, pressures: &chambers };
    body.system
        .solver()
        .integrate(&problem, stored * each, &mut observe)
        .map_err(|e| Diagnostic::from(e).while_doing(format!("motion between {start:.3} s and {end:.3} s")))?;
    Ok(SampledMotion { rest: body.mesh.nodes.clone(), start, rate, shapes })
}
