//! Moduli and stiffening of a small bar come back from its displacements under pressure, and stay at the prior where it hardly strains.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

mod shared;

use fem::StaticSettings;
use optimize::optimisers::gauss_newton;
use optimize::{Bounds, Problem};
use sysid::{
    Certified, CertifiedSearch, Derivatives, Elastic, LevelSolver, Misfit, Model, NoiseModel, PressureLevel, Stiffened,
    StiffeningProblem,
};

/// Standard deviation of a measured displacement, m.
const SIGMA: f64 = 2e-6;
/// Of the prior of both ratios.
const PRIOR: [f64; 2] = [0.3, 0.5];

fn solver(model: &Model, levels: &[PressureLevel]) -> LevelSolver {
    let settings = StaticSettings { tolerance: 1e-8, ..StaticSettings::default() };
    LevelSolver::new(model.clone(), levels.to_vec(), settings, 1)
}

/// The displacements of the bar with the `hidden` constants at rising pressures up to `top` (Pa) in each chamber.
fn measured(model: &Model, hidden: &Elastic, top: f64) -> Vec<PressureLevel> {
    let at = |chamber: usize, part: usize| {
        let mut pressures = vec![0.0; 2];
        pressures[chamber] = top * part as f64 / 6.0;
        let covariance = vec![[SIGMA * SIGMA, 0.0, SIGMA * SIGMA]];
        PressureLevel { pressures, measured: vec![[0.0; 2]], covariance, shared: vec![[0.0; 3]], rest: vec![[0.0; 2]] }
    };
    let blank: Vec<PressureLevel> = (0..2).flat_map(|chamber| (1..=6).map(move |part| at(chamber, part))).collect();
    let simulated = solver(model, &blank).solve(hidden, Derivatives::None).unwrap();
    blank.into_iter().zip(simulated).map(|(level, is)| PressureLevel { measured: is.markers, ..level }).collect()
}

fn identified(model: &Model, levels: Vec<PressureLevel>) -> Stiffened {
    identification(model, levels).unwrap()
}

fn identification(model: &Model, levels: Vec<PressureLevel>) -> diagnostics::Result<Stiffened> {
    let misfit = misfit(levels);
    stiffened(model, &misfit, &mut solver(model, &misfit.levels))
}

fn misfit(levels: Vec<PressureLevel>) -> Misfit {
    Misfit::new(levels, &[6, 6], &NoiseModel { discrepancy_m: 0.0, scale_sigma: 0.0 }, 0.08).unwrap()
}

fn stiffened(model: &Model, misfit: &Misfit, solver: &mut LevelSolver) -> diagnostics::Result<Stiffened> {
    let bounds = Bounds { low: vec![-0.7; 2], high: vec![0.7; 2] };
    let moduli = Problem::new(&["soft", "stiff"], vec![0.0; 2], bounds).unwrap();
    let method = gauss_newton::Settings { iterations: 20, ..gauss_newton::Settings::default() };
    let problem = StiffeningProblem { model, misfit, moduli: &moduli, prior_sigma: PRIOR, method };
    problem.identify(solver, &|_| ())
}

#[test]
fn moduli_and_stiffening_come_back_where_the_silicone_strains() {
    let model = shared::bar("yeoh");
    let nominal = &model.nominal;
    let hidden = Elastic { youngs_moduli: vec![2.2e5, 4.6e6], stiffening: [0.08, 0.35], ..nominal.clone() };
    let found = identified(&model, measured(&model, &hidden, 2.4e4));
    let posterior = found.residuals.posterior(4).unwrap();
    for (k, [is, should]) in [[found.ratios[0], 0.08], [found.ratios[1], 0.35]].into_iter().enumerate() {
        let sigma = posterior.sigma(2 + k);
        println!("{is} ± {sigma} for {should}");
        assert!((is - should).abs() < 0.3 * sigma + 1e-3 && sigma < 0.7 * PRIOR[k], "{is} ± {sigma} for {should}");
    }
    for (k, should) in hidden.youngs_moduli.iter().enumerate() {
        let is = nominal.youngs_moduli[k] * found.at[k].exp();
        assert!((is / should - 1.0).abs() < 2e-3, "{is} for {should}");
    }
}

#[test]
fn stiffening_stays_at_the_prior_where_the_silicone_hardly_strains() {
    let model = shared::bar("yeoh");
    let hidden = Elastic { stiffening: [0.2, 0.6], ..model.nominal.clone() };
    let found = identified(&model, measured(&model, &hidden, 5e2));
    let posterior = found.residuals.posterior(4).unwrap();
    for (k, (ratio, prior)) in found.ratios.iter().zip(PRIOR).enumerate() {
        assert!(ratio.abs() < 0.2 * prior, "{:?}", found.ratios);
        assert!((posterior.sigma(2 + k) / prior - 1.0).abs() < 0.05, "{}", posterior.sigma(2 + k));
    }
}

#[test]
fn a_pressure_that_no_initial_guess_bears_is_refused_and_not_searched_on() {
    let model = shared::bar("yeoh");
    let mut levels = measured(&model, &model.nominal, 5e2);
    levels.iter_mut().for_each(|level| level.pressures.iter_mut().for_each(|pressure| *pressure *= 1e5));
    let refused = identification(&model, levels).err().map(|error| error.to_string()).unwrap_or_default();
    assert!(refused.contains("equilibrium") && refused.contains("do:"), "{refused}");
}

#[test]
fn a_search_in_a_reduced_model_ends_where_that_of_the_whole_body_does() {
    let model = shared::bar("yeoh");
    let hidden = Elastic { youngs_moduli: vec![2.2e5, 4.6e6], stiffening: [0.08, 0.35], ..model.nominal.clone() };
    let mut levels = measured(&model, &hidden, 2.4e4);
    // off by some deviations, so that the least misfit is not that of the hidden constants
    for (number, level) in levels.iter_mut().enumerate() {
        level.measured[0][1] += 3.0 * SIGMA * (1.3 * number as f64).sin();
    }
    let misfit = misfit(levels.clone());
    let mut whole = solver(&model, &levels);
    let by = CertifiedSearch::new(model.nominal.clone(), Derivatives::StiffeningSensitivities, &misfit);
    let mut search = |reduced: &mut LevelSolver| {
        let found = stiffened(&model, &misfit, reduced)?;
        let factors = found.at.iter().map(|by| by.exp());
        let youngs_moduli = model.nominal.youngs_moduli.iter().zip(factors).map(|(modulus, by)| modulus * by).collect();
        Ok((Elastic { youngs_moduli, stiffening: found.ratios, ..model.nominal.clone() }, found))
    };
    let Certified { found, levels: at_the_end, certificate, .. } = by.run(&mut whole, &mut search, &|_| ()).unwrap();
    println!("{certificate:?}");
    assert!(certificate.holds() && certificate.whole_equilibria == 12 * (1 + certificate.rounds));
    let (alone, deviations) = (identified(&model, levels), found.residuals.posterior(4).unwrap());
    for (k, (reduced, whole)) in found.at.iter().zip(&alone.at).enumerate() {
        let sigma = deviations.sigma(k);
        // each search ends where a step would lower half the sum of squares by 1e-3: up to 0.045 deviations from its minimum
        assert!((reduced - whole).abs() < 0.1 * sigma, "{reduced} for {whole} ± {sigma}");
        let width = sigma / alone.residuals.posterior(4).unwrap().sigma(k);
        assert!((width - 1.0).abs() < 0.1, "an interval {width} times as wide");
    }
    // the levels are those of the whole body there
    let constants = Elastic {
        youngs_moduli: model.nominal.youngs_moduli.iter().zip(&found.at).map(|(e, by)| e * by.exp()).collect(),
        stiffening: found.ratios,
        ..model.nominal.clone()
    };
    let again = solver(&model, &misfit.levels).solve(&constants, Derivatives::None).unwrap();
    for (a, b) in at_the_end.iter().zip(&again) {
        assert!((a.markers[0][1] - b.markers[0][1]).abs() < 0.01 * SIGMA);
    }
}
