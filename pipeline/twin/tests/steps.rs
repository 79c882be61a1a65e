//! Steps of a clamped beam: convergence, statics, energy, and a loop closed around it.
#![allow(clippy::unwrap_used)] // tests

#[path = "../examples/tip_control.rs"]
mod tip_control;

use tip_control::{follow, tuned};
use twin::example::{LENGTH, beam};
use twin::{Twin, TwinData, TwinError};

const HIGHEST: f64 = 2e4;

/// Tip along y at ten times of half a second that is made in `steps` steps, under a pressure that rises smoothly.
fn path(wet: bool, steps: usize) -> Vec<f64> {
    let twin = Twin::new(beam(wet)).unwrap();
    let (mut state, mut path) = (twin.start(), Vec::new());
    for n in 1..=steps {
        let t = 0.5 * n as f64 / steps as f64;
        let pressure = HIGHEST * (0.5 - 0.5 * (6.0 * t).cos()).powi(2);
        twin.step(&mut state, &[pressure, 0.0], 0.5 / steps as f64).unwrap();
        if n % (steps / 10) == 0 {
            path.push(twin.output(&state, 1));
        }
    }
    path
}

#[test]
fn halving_the_step_quarters_the_error() {
    let off = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    for wet in [false, true] {
        let fine = path(wet, 3200);
        assert!(fine[9] > 0.04 * LENGTH, "{fine:?}");
        let ratio = off(&path(wet, 200), &fine) / off(&path(wet, 400), &fine);
        assert!((3.4..4.6).contains(&ratio), "{ratio}");
    }
}

#[test]
fn under_a_lasting_pressure_the_beam_comes_to_the_equilibrium_of_its_long_term_modulus() {
    let settled = |data| {
        let twin = Twin::new(data).unwrap();
        let mut state = twin.start();
        (0..400).for_each(|_| twin.step(&mut state, &[0.0, HIGHEST], 0.05).unwrap());
        (twin.output(&state, 1), twin.chamber_volume(&state, 1))
    };
    let mut elastic = beam(false);
    elastic.regions[0].branches.clear();
    let ((tip, volume), (exact, _)) = (settled(beam(true)), settled(elastic));
    assert!(tip < -0.05 * LENGTH && (tip / exact - 1.0).abs() < 1e-5, "{tip} {exact}");
    assert!(volume > 1e-5, "a filled chamber grows");
}

#[test]
fn a_sudden_load_is_carried_in_parts_of_the_step() {
    let twin = Twin::new(beam(false)).unwrap();
    let mut state = twin.start();
    twin.step(&mut state, &[4.0 * HIGHEST, 0.0], 0.1).unwrap();
    assert!((state.time() - 0.1).abs() < 1e-12 && state.work().tangents > 0);
    let kept = state.clone();
    assert!(matches!(twin.step(&mut state, &[0.0], 1e-3), Err(TwinError::Input { .. })));
    assert!(matches!(twin.step(&mut state, &[0.0, f64::NAN], 1e-3), Err(TwinError::Input { .. })));
    assert!(matches!(twin.step(&mut state, &[0.0, 0.0], 0.0), Err(TwinError::Input { .. })));
    assert_eq!((state.time(), state.coordinates()), (kept.time(), kept.coordinates()));
}

#[test]
fn a_controller_at_a_kilohertz_brings_the_tip_to_its_target() {
    for wet in [false, true] {
        let twin = Twin::new(beam(wet)).unwrap();
        let controller = tuned(&twin, 1, HIGHEST).unwrap();
        let trace = follow(&twin, &controller, &|t| if t < 0.1 { 0.0 } else { -4e-3 }, 3.0).unwrap();
        assert_eq!(trace.len(), 3000);
        let late = trace.iter().filter(|[t, ..]| *t > 2.5);
        let off = late.fold(0.0, |most: f64, [_, goal, tip]| most.max((tip - goal).abs()));
        assert!(off < 0.02 * 4e-3, "off by {off} m");
        // without the loop the tip does not stay
        assert!(trace[150][2].abs() < 3.9e-3);
    }
}

#[test]
fn the_state_and_the_recording_of_another_twin_are_refused() {
    let beam = beam(false);
    let twin = Twin::new(beam.clone()).unwrap();
    let mut half = TwinData { chambers: beam.chambers[..1].to_vec(), ..beam.clone() };
    let mut elastic = beam.clone();
    elastic.regions[0].branches.clear();
    half.outputs.clear();
    for other in [Twin::new(half).unwrap(), Twin::new(elastic).unwrap()] {
        let error = twin.step(&mut other.start(), &[0.0; 2], 0.01).unwrap_err();
        assert!(matches!(error, TwinError::State { .. }), "{error}");
        assert!(matches!(twin.record(&mut other.recording(), &[0.0; 2], 0.01), Err(TwinError::State { .. })));
        let gradient = twin.adjoint(&other.recording(), &mut |_| unreachable!());
        assert!(matches!(gradient, Err(TwinError::State { .. })));
    }
}
