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

#[test]
fn a_step_that_fails_leaves_the_state_as_it_was() {
    let mut data = beam(false);
    data.chambers.iter_mut().for_each(|chamber| chamber.range = twin::Chamber::UNLIMITED);
    let twin = Twin::new(data).unwrap();
    let mut state = twin.start();
    (1..=20).for_each(|n| twin.step(&mut state, &[1e3 * f64::from(n), 0.0], 4e-3).unwrap());
    let mut untouched = state.clone();
    // the first of these pressures that is too much for a step: its first half, up to the one before, is found and taken back
    let mut pressure = 1e5;
    while twin.step(&mut state, &[pressure, 0.0], 4e-3).is_ok() {
        (state, pressure) = (untouched.clone(), 2.0 * pressure);
        assert!(pressure < 1e30, "no step is too much");
    }
    assert!(state.work().steps > untouched.work().steps, "parts of the step were found");
    assert_eq!((state.time(), state.coordinates()), (untouched.time(), untouched.coordinates()));
    assert_eq!(state.velocity(), untouched.velocity());
    for state in [&mut state, &mut untouched] {
        twin.step(state, &[2e4, 0.0], 4e-3).unwrap();
    }
    let apart = state.coordinates().iter().zip(untouched.coordinates()).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f64::max) < 1e-7 * LENGTH, "the next step is the same to its tolerance");
}

#[test]
fn pressures_beyond_the_range_of_a_chamber_are_refused_by_name_and_ratio() {
    let twin = Twin::new(beam(false)).unwrap();
    let [low, high] = twin.chambers()[1].range;
    let mut state = twin.start();
    for (pressure, ratio) in [(10.0 * high, "10.0 times"), (-0.5 * high, "0.5 times")] {
        let error = twin.step(&mut state, &[0.0, pressure], 1e-3).unwrap_err();
        assert!(matches!(error, TwinError::Pressure { .. }));
        assert!(error.to_string().contains("`right`") && error.to_string().contains(ratio), "{error}");
    }
    assert_eq!(state.time(), 0.0);
    twin.step(&mut state, &[low, 1.005 * high], 1e-3).unwrap();
    assert!(twin.excursion(&state) > 0.0);
}

#[test]
fn an_output_that_there_is_not_is_refused_with_those_that_there_are() {
    let error = Twin::new(beam(false)).unwrap().output_number("tip").unwrap_err();
    assert!(error.to_string().contains("tip_x, tip_y"), "{error}");
}

#[test]
fn a_saved_state_goes_on_to_the_same_bits_and_others_are_refused() {
    for wet in [false, true] {
        let twin = Twin::new(beam(wet)).unwrap();
        let mut state = twin.start();
        assert_eq!(twin.restored(&twin.saved(&state).unwrap()).unwrap().coordinates(), state.coordinates());
        let pressure = |n: i32| [HIGHEST * (0.5 - 0.5 * (0.1 * f64::from(n)).cos()), 0.0];
        (0..40).for_each(|n| twin.step(&mut state, &pressure(n), 2e-3).unwrap());
        let bytes = twin.saved(&state).unwrap();
        let mut restored = twin.restored(&bytes).unwrap();
        assert_eq!(twin.saved(&restored).unwrap(), bytes);
        for n in 40..60 {
            for state in [&mut state, &mut restored] {
                twin.step(state, &pressure(n), 2e-3).unwrap();
            }
            assert_eq!(state.coordinates(), restored.coordinates());
        }
        let mut other = beam(wet);
        other.regions[0].branches.pop();
        let other = Twin::new(other).unwrap();
        for damaged in [&bytes[..bytes.len() - 8], &bytes[..bytes.len() - 3], &bytes[8..], &[]] {
            assert!(matches!(twin.restored(damaged), Err(TwinError::Saved { .. })));
        }
        assert!(matches!(other.restored(&bytes), Err(TwinError::Saved { .. })));
    }
}
