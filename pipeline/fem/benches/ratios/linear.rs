//! The case at which DiffPD was measured: 33 thousand dofs in 4-node tetrahedra, on one thread (FACTS: CPU seconds).

use crate::Outcome;
use crate::beams::{fine, system};
use crate::clock::{say, timed};
use crate::quadratic::{counted, peak_memory};
use fem::{DynamicSettings, InitialValueProblem, LossGradient, Scheme, State, StaticSettings};

/// s, one thread: a static solve, one implicit step, 20 steps with gradient.
const DIFFPD_STATIC: f64 = 136.0;
const DIFFPD_STEP: f64 = 38.0;
const DIFFPD_GRADIENT: f64 = 542.0;

/// The same with this solver.
pub fn as_diffpd() -> Outcome<()> {
    let system = system(fine(), 12500.0)?;
    println!("4-node hollow beam: {system:?}, entries {:?}", system.entries());
    crate::iteration::iteration(&system)?;
    let mut solver = system.solver();
    let set = StaticSettings { load_steps: 1, ..StaticSettings::default() };
    let (time, at) = timed(1, || Ok(solver.equilibrium(&[0.0, 2e4], None, &set)?))?;
    say(&counted("static solve, 200 mbar", &at), time, Some((DIFFPD_STATIC, "DiffPD's")));
    let settings = DynamicSettings { step: 1.0 / 100.0, scheme: Scheme::ImplicitEuler, ..DynamicSettings::default() };
    let rest = State::rest(system.mesh().nodes.len());
    let push = |_: f64| vec![0.0, 1e4];
    let (step, _) = timed(1, || {
        Ok(system.solver().integrate(
            &InitialValueProblem { settings: &settings, initial: &rest, pressures: &push },
            1,
            &mut |_, _| (),
        )?)
    })?;
    say("the first implicit Euler step, 100 mbar at once", step, Some((DIFFPD_STEP, "DiffPD's")));
    let (forward, made) = timed(1, || {
        Ok(solver.record(
            &InitialValueProblem { settings: &settings, initial: &rest, pressures: &push },
            20,
            usize::MAX,
        )?)
    })?;
    say("20 steps", forward, None);
    say("a step, on the average of 20", forward / 20.0, Some((DIFFPD_STEP, "DiffPD's")));
    let last = made.steps();
    let mut ask = |n: usize, state: &State| {
        let displacement = if n == last { state.displacement.clone() } else { Vec::new() };
        LossGradient { displacement, ..LossGradient::default() }
    };
    let (backward, _) = timed(1, || Ok(solver.trajectory_adjoint(&made, &mut ask)?))?;
    say("their gradient", backward, Some((forward, "the 20 steps")));
    say("20 steps with gradient", forward + backward, Some((DIFFPD_GRADIENT, "DiffPD's")));
    Ok(())
}

/// A motion of 2000 steps and its gradient, with checkpoints that take 400 MB at most.
pub fn long_motion() -> Outcome<()> {
    let system = system(fine(), 12500.0)?;
    let settings = DynamicSettings { step: 1e-3, stiffness_damping: 1e-3, ..DynamicSettings::default() };
    let rest = State::rest(system.mesh().nodes.len());
    let beat = |time: f64| vec![5e3 * (1.0 - (12.0 * time).cos()), 0.0];
    let mut solver = system.solver();
    let (forward, made) = timed(1, || {
        Ok(solver.record(
            &InitialValueProblem { settings: &settings, initial: &rest, pressures: &beat },
            2000,
            400_000_000,
        )?)
    })?;
    println!("{} dofs, {} steps in {} segments", system.dofs(), made.steps(), made.segments());
    say("2000 steps", forward, None);
    let mut ask = |n: usize, state: &State| {
        let displacement = if n == 2000 { state.displacement.clone() } else { Vec::new() };
        LossGradient { displacement, ..LossGradient::default() }
    };
    let (backward, _) = timed(1, || Ok(solver.trajectory_adjoint(&made, &mut ask)?))?;
    say("their gradient, with recomputation", backward, Some((forward, "the 2000 steps")));
    println!("peak memory {}", peak_memory());
    Ok(())
}
