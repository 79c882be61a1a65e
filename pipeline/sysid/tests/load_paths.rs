//! Equilibria far from those that are known are reached by a path, and the softest body with an equilibrium is found.

#![allow(clippy::unwrap_used)] // a test may fail where it stands

mod shared;

use fem::StaticSettings;
use optimize::Bounds;
use sysid::{Derivatives, Elastic, LevelSolver, Model, PressureLevel, feasible_lower_bound};

/// As in a search: without load steps from rest.
const SETTINGS: StaticSettings =
    StaticSettings { tolerance: 1e-8, load_steps: 1, max_iterations: 16, max_halvings: 0, reuse_factor: false };

fn level(pressures: [f64; 2]) -> PressureLevel {
    PressureLevel {
        pressures: pressures.to_vec(),
        measured: vec![[0.0; 2]],
        covariance: vec![[1e-10, 0.0, 1e-10]],
        shared: vec![[0.0; 3]],
        rest: vec![[0.0; 2]],
    }
}

/// The displacement of the end under `pressures`, by load stepping from rest.
fn by_load_stepping(model: &Model, elastic: &Elastic, pressures: [f64; 2]) -> [f64; 2] {
    let mut solver = model.system.solver();
    elastic.apply(&mut solver).unwrap();
    let settings = StaticSettings { load_steps: 30, ..StaticSettings::default() };
    Model::in_plane(&model.markers[0], &solver.equilibrium(&pressures, None, &settings).unwrap().displacement)
}

fn assert_close(is: [f64; 2], should: [f64; 2]) {
    let off = (is[0] - should[0]).hypot(is[1] - should[1]);
    assert!(off < 1e-5 * should[0].hypot(should[1]), "{is:?} for {should:?}");
}

#[test]
fn a_single_level_of_high_pressure_is_reached_from_rest() {
    let model = shared::bar("yeoh");
    let elastic = Elastic { stiffening: [0.1, 0.05], ..model.nominal.clone() };
    let mut solver = LevelSolver::new(model.clone(), vec![level([5e4, 0.0])], SETTINGS, 1);
    let found = solver.solve(&elastic, Derivatives::None).unwrap();
    assert_close(found[0].markers[0], by_load_stepping(&model, &elastic, [5e4, 0.0]));
}

#[test]
fn a_body_far_from_those_solved_before_is_reached() {
    let model = shared::bar("yeoh");
    let known = Elastic { stiffening: [0.1, 0.05], ..model.nominal.clone() };
    // the highest one from rest, in one step or by way of the levels below it
    let pressures = [[2e4, 0.0], [0.0, 4e4], [0.0, 1e4], [0.0, 1.0001e4], [0.0, 6e4]];
    let mut solver = LevelSolver::new(model.clone(), pressures.map(level).to_vec(), SETTINGS, 2);
    solver.solve(&known, Derivatives::None).unwrap();
    let other = Elastic { youngs_moduli: vec![1.1e5, 2e7], poissons_ratios: vec![0.4, 0.3], stiffening: [0.02, 0.15] };
    let found = solver.solve(&other, Derivatives::None).unwrap();
    for (pressures, simulated) in pressures.into_iter().zip(&found) {
        assert_close(simulated.markers[0], by_load_stepping(&model, &other, pressures));
    }
}

#[test]
fn the_feasible_lower_bound_has_an_equilibrium_and_less_has_none() {
    let bounds = Bounds { low: vec![-2.5, -1.0], high: vec![0.7, 1.0] };
    let at = |law: &str, stiffening: [f64; 2]| {
        let model = shared::bar(law);
        let elastic = Elastic { stiffening, ..model.nominal.clone() };
        let levels = vec![level([1.2e4, 0.0]), level([2.4e4, 0.0]), level([0.0, 2.4e4])];
        let mut solver = LevelSolver::new(model, levels, SETTINGS, 2);
        feasible_lower_bound(&mut solver, &elastic, &bounds).unwrap()
    };
    let (balloons, stiffens) = (at("neo_hookean", [0.0; 2]), at("yeoh", [0.3, 0.5]));
    println!("neo-Hookean {balloons}, stiffening {stiffens}");
    assert!(balloons > -2.0 && balloons < 0.5, "thin walls of neo-Hookean silicone balloon: {balloons}");
    assert_eq!(stiffens, -2.5, "those that stiffen do not");

    // the same body at that modulus has an equilibrium, and none somewhat below
    let model = shared::bar("neo_hookean");
    let scaled = |by: f64| {
        let youngs_moduli = model.nominal.youngs_moduli.iter().map(|e| e * by.exp()).collect();
        Elastic { youngs_moduli, ..model.nominal.clone() }
    };
    let mut solver = LevelSolver::new(model.clone(), vec![level([2.4e4, 0.0])], SETTINGS, 1);
    assert!(solver.solve(&scaled(balloons + 0.01), Derivatives::None).is_ok());
    assert!(solver.solve(&scaled(balloons - 0.2), Derivatives::None).is_err());
}
