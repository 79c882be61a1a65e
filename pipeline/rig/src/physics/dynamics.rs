//! Dynamics: a body's motion while the pressures of both sides change.
//!
//! Stands on: `fem`'s march (BDF2, Rayleigh damping). Never knows: what is commanded.

use fem::{March, Scheme, State};
use si::{Hertz, Pascal, Second};

use super::{Body, Recorded};
use crate::fault::Fault;

/// The motion from rest at `start` (s) until `end` (s), kept `rate` times a second from `start` on, under the pressures
/// (left, right; Pa) at any time (s). `step` (s) divides the time between kept shapes. `tick` is called after each of them.
///
/// # Errors
/// [`Fault`] when a step does not converge.
pub fn march(
    body: &Body,
    [start, end]: [Second; 2],
    rate: Hertz,
    step: Second,
    pressures: &dyn Fn(Second) -> [Pascal; 2],
    tick: &dyn Fn(),
) -> Result<Recorded, Fault> {
    let each = (1.0 / (rate * step)).round().max(1.0) as usize;
    let kept = ((end - start) * rate).ceil() as usize;
    let settings = March {
        step: 1.0 / (rate * each as f64),
        scheme: Scheme::Bdf2,
        mass_damping: 0.0,
        stiffness_damping: body.stiffness_damping,
        ..March::default()
    };
    let rest = State::rest(body.mesh.nodes.len());
    let mut shapes = vec![rest.displacement.iter().map(|u| *u as f32).collect::<Vec<f32>>()];
    let mut done = 0;
    let mut observe = |_: Second, state: &State| {
        done += 1;
        if done % each == 0 {
            shapes.push(state.displacement.iter().map(|u| *u as f32).collect());
            tick();
        }
    };
    let inside = |t: Second| {
        let [left, right] = pressures(start + t);
        body.pressures(left, right)
    };
    let mut solver = body.system.solver();
    solver
        .march(&settings, &rest, &inside, kept * each, &mut observe)
        .map_err(|e| Fault::at(format!("motion between {start:.3} s and {end:.3} s"), e))?;
    Ok(Recorded { rest: body.mesh.nodes.clone(), start, rate, shapes })
}
