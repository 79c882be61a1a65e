//! A relaxation spectrum comes back from the motion of a small bar: the whole model moves with nine branches, the reduced one is fitted with
//! four.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

mod shared;

use fem::{Branch, DynamicSettings, InitialValueProblem, Relaxation, Scheme, State};
use sysid::relaxation::{
    Film, Footage, IdentifiedBranch, IdentifiedSpectrum, SpectrumProblem, SpectrumSettings, Window,
};
use sysid::{Model, ReducedBody, Snapshots, TimeSteps};

/// Pa.
const PRESSURE: f64 = 4e3;
/// Held from 0 s, released at, filmed until, s.
const RELEASE: f64 = 1.2;
const END: f64 = 2.4;
/// Frames a second, and time steps a frame.
const RATE: f64 = 60.0;
const EACH: usize = 4;
/// By how much a modulus is off, in its logarithm.
const OFF: f64 = 0.03;

/// Two branches a decade, uneven: no sum of the fitted four.
fn hidden() -> Relaxation {
    let branch =
        |(k, strength): (i32, &f64)| Branch { strength: *strength, time: 10f64.powf(0.5 * f64::from(k) - 2.75) };
    let strengths = [0.08, 0.05, 0.07, 0.045, 0.035, 0.045, 0.03];
    Relaxation::maxwell(&(0..).zip(&strengths).map(branch).collect::<Vec<_>>()).unwrap()
}

fn pressures(t: f64) -> Vec<f64> {
    vec![
        if t < RELEASE { PRESSURE * (t / 0.05).min(1.0) } else { PRESSURE * (1.0 - (t - RELEASE) / 0.05).max(0.0) },
        0.0,
    ]
}

/// The end's path by the whole model, filmed.
fn filmed(model: &Model) -> Vec<Window> {
    let mut solver = model.system.solver();
    solver.set_relaxation(0, hidden()).unwrap();
    let step = 1.0 / (RATE * EACH as f64);
    let settings = DynamicSettings { step, scheme: Scheme::Bdf2, ..DynamicSettings::default() };
    let rest = State::rest(model.system.mesh().nodes.len());
    let mut path = vec![[0.0; 2]];
    let mut observe = |_: f64, state: &State| path.push(Model::in_plane(&model.markers[0], &state.displacement));
    let problem = InitialValueProblem { settings: &settings, initial: &rest, pressures: &pressures };
    solver.integrate(&problem, (END / step).round() as usize, &mut observe).unwrap();
    let window = |[begin, end]: [f64; 2], command: f64| {
        let frames = (0..path.len() / EACH).map(|k| (k as f64 / RATE, path[k * EACH]));
        let (times, seen) = frames.filter(|(t, _)| *t >= begin && *t < end).unzip();
        Window { begin, times, seen, command }
    };
    vec![window([0.0, RELEASE], PRESSURE), window([RELEASE, END], 0.0)]
}

#[test]
fn storage_and_loss_come_back_from_a_motion_by_a_spectrum_that_the_branches_cannot_represent() {
    let model = shared::bar("neo_hookean");
    let top = [1.2 * PRESSURE; 2];
    // the error of the reduction is to be small beside the residuals of this small motion: with 5e-4 the loss is a fifth off
    let kept = Snapshots { model: &model, elastic: &model.nominal, top: &top, length: 0.08, stroke: None }
        .reduce(3e-5)
        .unwrap()
        .data;
    let reduced = ReducedBody::of(&model, &model.nominal.clone().into(), &kept).unwrap();
    // the modulus that a static identification would find in the middle of the hold's end
    let held_at = 0.9;
    let mut held = model.nominal.clone();
    held.youngs_moduli[0] *= hidden().modulus(held_at);
    let steps = (0..=(END * 200.0) as usize).map(|i| i as f64 / 200.0);
    let gauge = |chamber: usize| {
        let times: Vec<f64> = steps.clone().collect();
        let values = times.iter().map(|t| pressures(*t)[chamber]).collect();
        signal::resample::Samples::new(times, values).unwrap()
    };
    let fine = TimeSteps { step: 1.0 / 240.0, vibration: 0.8, longest: 0.03 };
    let footage = Footage { windows: filmed(&model), marker: 0, exposure: 0.0 };
    let film = Film::new(footage, vec![gauge(0), gauge(1)], fine).unwrap();
    let settings = SpectrumSettings {
        times: vec![0.003, 0.03, 0.3, 3.0],
        branches_per_interval: 2,
        prior_strength: 0.1,
        prior_sigma: 1.0,
        sigma: 1e-4,
        iterations: 8,
        step_tolerance: 0.02,
    };
    let problem = SpectrumProblem {
        settings: &settings,
        model: &model,
        reduced: &reduced,
        held,
        modulus_time: held_at,
        films: &[film],
    };
    let found = problem.identify(&|_| ()).unwrap();
    let spectrum = found.spectrum.relaxation().unwrap();
    println!("{:?}, rmse {:e}, elastic {:e}", found.spectrum.branches, found.rmse, found.elastic_rmse);
    assert!(found.rmse < 0.3 * found.elastic_rmse, "{:e} {:e}", found.rmse, found.elastic_rmse);
    for frequency in [1.0, 3.0, 8.0] {
        let at = |s: &Relaxation| {
            let [storage, loss] = s.complex_modulus(std::f64::consts::TAU * frequency);
            [storage / s.modulus(held_at), loss / storage]
        };
        let ([storage, loss], [real_storage, real_loss]) = (at(&spectrum), at(&hidden()));
        println!("{frequency} Hz: storage {storage:.4} of {real_storage:.4}, loss {loss:.4} of {real_loss:.4}");
        assert!((storage / real_storage - 1.0).abs() < 0.015, "{frequency} Hz: {storage} {real_storage}");
        // the reduced model is not the whole one
        assert!((loss / real_loss - 1.0).abs() < 0.2, "{frequency} Hz: {loss} {real_loss}");
    }
    let within =
        |b: &IdentifiedBranch| b.sigma > 0.0 && b.sigma <= 1.0 + 1e-9 && (b.over_prior - b.sigma).abs() < 1e-12;
    assert!(found.spectrum.branches.len() == 7 && found.spectrum.branches.iter().all(within));
    // with a modulus that is 3 % too high the vibration leaves a storage that is 3 % too low, by the response as by another identification
    let mut stiffer = problem.clone();
    stiffer.held.youngs_moduli[0] *= OFF.exp();
    let again = stiffer.identify(&|_| ()).unwrap().spectrum;
    let change = |other: &IdentifiedSpectrum| (other.at(3.0).unwrap()[0] / found.spectrum.at(3.0).unwrap()[0]).ln();
    let (followed, real) = (change(&found.spectrum.following(&[OFF])), change(&again));
    println!("storage at 3 Hz: {followed:.4} by the response, {real:.4} identified anew");
    assert!(real < -0.4 * OFF && (followed - real).abs() < 0.25 * OFF, "{followed} {real}");
}

#[test]
fn a_film_in_which_nothing_changes_is_refused() {
    let window = Window { begin: 0.0, times: vec![0.0, 0.1], seen: vec![[0.0; 2]; 2], command: 0.0 };
    let steps = TimeSteps { step: 0.01, vibration: 0.1, longest: 0.1 };
    let footage = Footage { windows: vec![window], marker: 0, exposure: 0.0 };
    let refused = Film::new(footage, Vec::new(), steps).err().unwrap().to_string();
    assert!(refused.contains("no transient"), "{refused}");
}
