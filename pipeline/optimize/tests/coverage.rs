//! 95 % intervals contain the truth in 95 of 100 repeats of a small identification whose truth is known.
//!
//! The case: a sheet in a soft body, bent by pressure from either side in two films; the displacements of each film have a common
//! scale error (walls not as drawn) and independent noise.

#![allow(clippy::unwrap_used)] // a test may unwrap; the lint recognises only functions marked as tests

use optimize::optimisers::{self, Settings};
use optimize::posterior::WITHIN_95;
use optimize::{Bounds, Evaluation, Needs, OptimiseError, Problem, Residuals, Whitening, minimise};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

const LEVELS: [f64; 5] = [0.2, 0.4, 0.6, 0.8, 1.0];
const MARKERS: [f64; 3] = [0.4, 0.6, 0.8];
const NOISE: f64 = 4e-3;
const SHARE: f64 = 0.02;
const REPEATS: usize = 200;

/// Displacement of a marker at a level: near the clamp the sheet contributes more stiffness, far from it the body; it stiffens.
fn displacement(log: [f64; 2], level: f64, marker: f64) -> f64 {
    let stiffness = 0.7 * marker * log[0].exp() + 0.5 * (1.2 - marker) * log[1].exp();
    (marker * level / stiffness).sinh() / (1.0 + 0.2 * level)
}

fn all(log: [f64; 2]) -> Vec<f64> {
    (0..2)
        .flat_map(|_| LEVELS.iter().flat_map(move |&p| MARKERS.iter().map(move |&m| displacement(log, p, m))))
        .collect()
}

/// Central differences: exact to 1e-9 here, far below the noise.
fn jacobian(log: [f64; 2]) -> Vec<f64> {
    let h = 1e-5;
    let by = |k: usize| {
        let shifted = |s: f64| {
            let mut at = log;
            at[k] += s;
            all(at)
        };
        let (up, down) = (shifted(h), shifted(-h));
        up.into_iter().zip(down).map(|(u, d)| (u - d) / (2.0 * h)).collect::<Vec<f64>>()
    };
    by(0).into_iter().zip(by(1)).flat_map(|(a, b)| [a, b]).collect()
}

fn normal(draw: &mut ChaCha8Rng) -> f64 {
    let mut unit = || ((draw.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64;
    (-2.0 * unit().ln()).sqrt() * (std::f64::consts::TAU * unit()).cos()
}

fn measured(truth: [f64; 2], draw: &mut ChaCha8Rng) -> Vec<f64> {
    let films: Vec<f64> = all(truth);
    let half = films.len() / 2;
    let shares = [SHARE * normal(draw), SHARE * normal(draw)];
    films.iter().enumerate().map(|(i, u)| u * (1.0 + shares[i / half]) + NOISE * normal(draw)).collect()
}

fn estimated_whitening(measured: &[f64]) -> Whitening {
    let half = measured.len() / 2;
    let block = |film: &[f64]| {
        let entry = |i: usize, j: usize| SHARE * SHARE * film[i] * film[j] + if i == j { NOISE * NOISE } else { 0.0 };
        (0..half).flat_map(|i| (0..half).map(move |j| (i, j))).map(|(i, j)| entry(i, j)).collect()
    };
    Whitening::new(&[block(&measured[..half]), block(&measured[half..])]).unwrap()
}

/// How often the 95 % interval of each parameter contains its truth, %.
fn coverage() -> [f64; 2] {
    let truth = [0.12, -0.2];
    let mut draw = ChaCha8Rng::seed_from_u64(20210907);
    let mut held = [0usize; 2];
    for _ in 0..REPEATS {
        let data = measured(truth, &mut draw);
        let whitening = estimated_whitening(&data);
        let bounds = Bounds { low: vec![-1.0; 2], high: vec![1.0; 2] };
        let problem = Problem::new(&["body", "spine"], vec![0.0; 2], bounds).unwrap();
        let mut answer = |batch: &[Vec<f64>], _: Needs| -> Result<Vec<Evaluation>, OptimiseError> {
            let one = |at: &Vec<f64>| {
                let log = [at[0], at[1]];
                let values = all(log).iter().zip(&data).map(|(s, m)| s - m).collect();
                let residuals = whitening.apply(&Residuals { values, jacobian: jacobian(log) }, 2)?;
                Ok(Evaluation { residuals: Some(residuals), ..Evaluation::of_loss(at.clone(), 0.0) })
            };
            batch.iter().map(one).collect()
        };
        let mut newton = (optimisers::by_name("gauss_newton").unwrap().build)(&problem, &Settings::default()).unwrap();
        let best = minimise(newton.as_mut(), &mut answer).unwrap().best;
        let posterior = best.residuals.unwrap().posterior(2).unwrap();
        for k in 0..2 {
            held[k] += usize::from((best.at[k] - truth[k]).abs() < WITHIN_95 * posterior.sigma(k));
        }
    }
    held.map(|h| 100.0 * h as f64 / REPEATS as f64)
}

/// Of 200 repeats 95 % ± 1.5 % (one standard deviation) are expected; 90 to 98 % are accepted.
#[test]
fn intervals_of_95_per_cent_contain_the_truth_in_90_to_98_per_cent_of_repeats() {
    let held = coverage();
    println!("held in {held:?} %");
    assert!(held.iter().all(|h| (90.0..=98.0).contains(h)), "{held:?} %");
}
