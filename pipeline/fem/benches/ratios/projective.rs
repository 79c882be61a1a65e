//! Projective dynamics against Newton's method: iterations and seconds of one implicit step and of its gradient, with a
//! sheet 1, 100 and 10000 times as stiff as its silicone.
//!
//! DiffPD on a 4 mm mesh of such a beam: 311, 700 and 2645 iterations forwards, 322, 1038 and more than 4000 backwards, at
//! ratios of 1, 100 and 12500; Newton 4 or 5 throughout (FACTS).

use crate::Outcome;
use crate::beams::{fine, system};
use crate::clock::timed;
use fem::{DynamicSettings, InitialValueProblem, Projective, ProjectiveSettings, Scheme, State, System};

/// One implicit step, s, under one chamber's pressure, Pa.
const STEP: f64 = 0.01;
const PRESSURE: f64 = 1e4;
const RATIOS: [f64; 3] = [1.0, 1e2, 1e4];

/// Iterations and seconds, forwards and backwards.
struct Effort {
    /// Of the step.
    forwards: (usize, f64),
    /// Of its gradient.
    backwards: (usize, f64),
}

/// The same step and gradient by both.
struct Comparison {
    /// Iterations of a local and a global step each.
    projective: Effort,
    /// Factors forwards, iterations with a factor backwards.
    newton: Effort,
    /// Seconds of the constant matrix and its factor, made once for all steps.
    prepared: f64,
    /// Seconds of the solver's own time step, with its refactorisation policy.
    integration: f64,
    /// How far their steps and their gradients lie apart, over the largest entry.
    apart: [f64; 2],
}

/// Takes one step from rest and its gradient by both methods.
fn compare(system: &System) -> Outcome<Comparison> {
    let set = ProjectiveSettings::default();
    let rest_state = State::rest(system.mesh().nodes.len());
    let pressures = [0.0, PRESSURE];
    let b: Vec<f64> = (0..rest_state.displacement.len()).map(|at| f64::from(u8::from(at % 3 == 1))).collect();
    let (prepared, mut projective) = timed(1, || Ok(Projective::new(system, STEP)?))?;
    let (there_s, (state, there)) = timed(1, || Ok(projective.step(&rest_state, &pressures, &[], &set)?))?;
    let (back_s, (z, back)) = timed(1, || Ok(projective.adjoint(&state.displacement, &pressures, &b, &set)?))?;
    let (steps_s, (exact, steps)) = timed(1, || Ok(projective.step_by_newton(&rest_state, &pressures, &[])?))?;
    let (solve_s, (w, solve)) = timed(1, || Ok(projective.adjoint_by_newton(&exact.displacement, &pressures, &b)?))?;
    let settings = DynamicSettings { step: STEP, scheme: Scheme::ImplicitEuler, ..DynamicSettings::default() };
    let mut solver = system.solver();
    let (integration, _) = timed(1, || {
        Ok(solver.integrate(
            &InitialValueProblem { settings: &settings, initial: &rest_state, pressures: &|_| pressures.to_vec() },
            1,
            &mut |_, _| (),
        )?)
    })?;
    Ok(Comparison {
        projective: Effort { forwards: (there, there_s), backwards: (back, back_s) },
        newton: Effort { forwards: (steps, steps_s), backwards: (solve, solve_s) },
        prepared,
        integration,
        apart: [apart(&state.displacement, &exact.displacement), apart(&z, &w)],
    })
}

/// Largest difference over the largest entry of `exact`.
fn apart(found: &[f64], exact: &[f64]) -> f64 {
    let largest = |most: f64, x: f64| most.max(x.abs());
    found.iter().zip(exact).map(|(a, b)| a - b).fold(0.0, largest) / exact.iter().copied().fold(0.0, largest)
}

fn line(name: &str, (its, s): (usize, f64), (steps, newton_s): (usize, f64), apart: f64) {
    let ratio = s / newton_s;
    println!(
        "  {name:9} {its:6} its {s:8.3} s   Newton {steps:3} {newton_s:7.3} s   {ratio:6.1} ×   apart {apart:.1e}"
    );
}

/// Prints two lines a ratio.
pub fn against_newton() -> Outcome<()> {
    let mesh = fine();
    for ratio in RATIOS {
        let system = system(mesh.clone(), ratio)?;
        let Comparison { projective, newton, prepared, integration, apart } = compare(&system)?;
        let dofs = system.dofs();
        println!(
            "sheet {ratio} × silicone, {dofs} dofs; constant factor {prepared:.3} s, time step {integration:.3} s"
        );
        line("forwards", projective.forwards, newton.forwards, apart[0]);
        line("backwards", projective.backwards, newton.backwards, apart[1]);
    }
    Ok(())
}
