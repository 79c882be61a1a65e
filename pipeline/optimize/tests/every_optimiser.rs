//! Every problem × every optimiser of the list: each must come as near to the known optimum as its kind can.
//!
//! A new optimiser is tested as soon as it is in `ALL`, once [`reach`] holds its settings and tolerance.

#![allow(clippy::unwrap_used)] // a test may unwrap; the lint recognises only functions marked as tests

use optimize::optimisers::{self, ALL, Settings};
use optimize::{Bounds, Evaluation, EvaluationLog, Finished, Needs, OptimiseError, Problem, Residuals, minimise};

/// A least-squares problem in two parameters with a known optimum.
struct Case {
    name: &'static str,
    residuals: fn(&[f64]) -> Vec<f64>,
    jacobian: fn(&[f64]) -> Vec<f64>,
    start: [f64; 2],
    low: [f64; 2],
    high: [f64; 2],
    optimum: [f64; 2],
}

const PROBLEMS: &[Case] = &[
    Case {
        name: "quadratic well",
        residuals: |x| vec![2.0 * (x[0] - 0.3) + 0.5 * (x[1] + 0.2), 0.7 * (x[1] + 0.2)],
        jacobian: |_| vec![2.0, 0.5, 0.0, 0.7],
        start: [-0.8, 0.9],
        low: [-1.0, -1.0],
        high: [1.0, 1.0],
        optimum: [0.3, -0.2],
    },
    Case {
        name: "rosenbrock",
        residuals: |x| vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]],
        jacobian: |x| vec![-20.0 * x[0], 10.0, -1.0, 0.0],
        start: [-1.2, 1.0],
        low: [-2.0, -1.0],
        high: [2.0, 3.0],
        optimum: [1.0, 1.0],
    },
    // Two logarithms of moduli: the residuals depend strongly and exponentially on their sum, weakly on their difference.
    Case {
        name: "narrow log valley",
        residuals: |x| vec![5.0 * ((x[0] + x[1] - 0.5).exp() - 1.0), 0.2 * (x[0] - x[1] + 0.9)],
        jacobian: |x| {
            let steep = 5.0 * (x[0] + x[1] - 0.5).exp();
            vec![steep, steep, 0.2, -0.2]
        },
        start: [1.0, -1.0],
        low: [-2.0, -2.0],
        high: [2.0, 2.0],
        optimum: [-0.2, 0.7],
    },
];

impl Case {
    fn problem(&self) -> Problem {
        let bounds = Bounds { low: self.low.to_vec(), high: self.high.to_vec() };
        Problem::new(&["body", "spine"], self.start.to_vec(), bounds).unwrap()
    }

    fn evaluate(&self, at: &[f64], needs: Needs) -> Evaluation {
        let r = Residuals { values: (self.residuals)(at), jacobian: (self.jacobian)(at) };
        Evaluation {
            at: at.to_vec(),
            loss: r.half_sum_of_squares(),
            gradient: (needs == Needs::Gradient).then(|| r.gradient(2)),
            residuals: (needs == Needs::Residuals).then_some(r),
        }
    }

    fn solve(&self, name: &str) -> EvaluationLog {
        let (settings, _) = reach(name);
        let mut optimiser = (optimisers::by_name(name).unwrap().build)(&self.problem(), &settings).unwrap();
        let mut answer = |batch: &[Vec<f64>], needs| -> Result<Vec<Evaluation>, OptimiseError> {
            Ok(batch.iter().map(|at| self.evaluate(at, needs)).collect())
        };
        minimise(optimiser.as_mut(), &mut answer).unwrap()
    }
}

/// Settings of an optimiser and the distance from the optimum (in units of the parameters) that it must reach.
fn reach(name: &str) -> (Settings, f64) {
    let mut set = Settings::default();
    let within = match name {
        "grid" => {
            set.grid.points_per_axis = 81;
            f64::NAN // its own test below: half a spacing, measured by the loss
        }
        "cma_es" => {
            set.cma_es.step_tolerance = 1e-8;
            set.cma_es.generations = 400;
            1e-6
        }
        "adam" => {
            set.adam.step = 0.05;
            set.adam.square_decay = 0.99;
            set.adam.step_tolerance = 1e-7;
            set.adam.iterations = 4000;
            2e-3
        }
        "gauss_newton" => {
            set.gauss_newton.iterations = 40;
            1e-6
        }
        other => panic!("`{other}` has no settings and tolerance here"),
    };
    (set, within)
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn every_optimiser_finds_every_optimum() {
    for member in ALL.iter().filter(|m| m.name != "grid") {
        for problem in PROBLEMS {
            let history = problem.solve(member.name);
            let off = distance(&history.best.at, &problem.optimum);
            let (_, within) = reach(member.name);
            println!("{:12} {:18} {:5} evaluations, {off:.2e} off", member.name, problem.name, history.entries.len());
            assert!(off < within, "{} is {off:.2e} off on {}, at {:?}", member.name, problem.name, history.best.at);
        }
    }
}

#[test]
fn a_grid_is_as_good_as_its_node_nearest_to_the_optimum() {
    for problem in PROBLEMS {
        let history = problem.solve("grid");
        let nearest = history.entries.iter().map(|t| &t.evaluation);
        let nearest =
            nearest.min_by(|a, b| distance(&a.at, &problem.optimum).total_cmp(&distance(&b.at, &problem.optimum)));
        assert!(history.best.loss <= nearest.unwrap().loss, "{}", problem.name);
        assert_eq!((history.entries.len(), history.iteration_count()), (81 * 81, 1));
    }
}

#[test]
fn no_optimiser_asks_outside_of_the_bounds() {
    for member in ALL {
        for problem in PROBLEMS {
            let bounds = problem.problem();
            let entries = problem.solve(member.name).entries;
            assert!(
                entries.iter().all(|t| bounds.bounds().contains_point(&t.evaluation.at)),
                "{} {}",
                member.name,
                problem.name
            );
        }
    }
}

#[test]
fn every_optimiser_asks_for_the_same_points_twice() {
    for member in ALL {
        for problem in PROBLEMS {
            assert!(problem.solve(member.name) == problem.solve(member.name), "{} {}", member.name, problem.name);
        }
    }
}

#[test]
fn every_optimiser_has_its_name_of_the_list() {
    for member in ALL {
        let built = (member.build)(&PROBLEMS[0].problem(), &Settings::default()).unwrap();
        assert_eq!(built.name(), member.name);
    }
}

#[test]
fn every_optimiser_asks_for_nothing_once_it_has_finished() {
    for member in ALL {
        let (settings, _) = reach(member.name);
        let mut optimiser = (member.build)(&PROBLEMS[0].problem(), &settings).unwrap();
        while optimiser.finished().is_none() {
            let (batch, needs) = (optimiser.ask(), optimiser.needs());
            let evaluations: Vec<_> = batch.iter().map(|at| PROBLEMS[0].evaluate(at, needs)).collect();
            optimiser.tell(&evaluations).unwrap();
        }
        assert!(optimiser.ask().is_empty(), "{}", member.name);
    }
}

#[test]
fn every_optimiser_refuses_a_loss_that_is_nan() {
    for member in ALL {
        let mut optimiser = (member.build)(&PROBLEMS[0].problem(), &Settings::default()).unwrap();
        let needs = optimiser.needs();
        let bad = |at: &Vec<f64>| Evaluation { loss: f64::NAN, ..PROBLEMS[0].evaluate(at, needs) };
        let evaluations: Vec<_> = optimiser.ask().iter().map(bad).collect();
        assert!(matches!(optimiser.tell(&evaluations), Err(OptimiseError::Loss { .. })), "{}", member.name);
    }
}

#[test]
fn every_optimiser_refuses_an_evaluation_at_another_point() {
    for member in ALL {
        let mut optimiser = (member.build)(&PROBLEMS[0].problem(), &Settings::default()).unwrap();
        let needs = optimiser.needs();
        let mut evaluations: Vec<_> = optimiser.ask().iter().map(|at| PROBLEMS[0].evaluate(at, needs)).collect();
        evaluations[0].at[0] += 0.01;
        assert!(matches!(optimiser.tell(&evaluations), Err(OptimiseError::OtherPoint { .. })), "{}", member.name);
    }
}

#[test]
fn every_problem_has_the_jacobian_of_its_residuals() {
    let h = 1e-6;
    for problem in PROBLEMS {
        let exact = (problem.jacobian)(&problem.start);
        for j in 0..2 {
            let shifted = |s: f64| {
                let mut x = problem.start;
                x[j] += s;
                (problem.residuals)(&x)
            };
            for (i, (up, down)) in shifted(h).iter().zip(shifted(-h)).enumerate() {
                let difference = (up - down) / (2.0 * h);
                // central differences of smooth functions of order 10: h² and round-off 1e-15/h
                assert!((difference - exact[2 * i + j]).abs() < 1e-7, "{} {i} {j}", problem.name);
            }
        }
    }
}

#[test]
fn gauss_newton_stops_on_a_bound_when_the_optimum_lies_beyond_it() {
    let problem = Case { high: [0.1, 1.0], ..PROBLEMS[0] };
    let history = problem.solve("gauss_newton");
    // with x0 held at 0.1: minimise (0.5 v − 0.4)² + (0.7 v)² over v = x1 + 0.2
    let v = 0.5 * 0.4 / (0.25 + 0.49);
    assert!(distance(&history.best.at, &[0.1, v - 0.2]) < 1e-6, "{:?}", history.best.at);
    assert!(matches!(history.finished, Finished::Converged { .. }));
}

#[test]
fn gauss_newton_follows_a_bound_through_a_curved_valley() {
    let problem = Case { low: [0.0, -2.0], ..PROBLEMS[2] };
    let history = problem.solve("gauss_newton");
    // on the bound x0 = 0 the steep residual alone fixes x1 = 0.5 but for the weak one: f′ = 25 s (s − 1) − 0.04 (0.9 − x1)
    let slope = |y: f64| 25.0 * (y - 0.5f64).exp() * ((y - 0.5f64).exp() - 1.0) - 0.04 * (0.9 - y);
    let best = &history.best.at;
    println!("{} evaluations, at {best:?}", history.entries.len());
    // half a millionth of way times a curvature of 25
    assert!(best[0] == 0.0 && slope(best[1]).abs() < 3e-5, "{best:?}, slope {:.2e}", slope(best[1]));
}

#[test]
fn gauss_newton_rejects_a_step_without_a_solution() {
    let problem = &PROBLEMS[1];
    let (settings, within) = reach("gauss_newton");
    let mut optimiser = (optimisers::by_name("gauss_newton").unwrap().build)(&problem.problem(), &settings).unwrap();
    // the first full step leads far down the valley's wall: say that nothing can be solved there
    let mut answer = |batch: &[Vec<f64>], needs| -> Result<Vec<Evaluation>, OptimiseError> {
        Ok(batch
            .iter()
            .map(|at| match at[1] < -0.5 {
                true => Evaluation::of_loss(at.clone(), f64::INFINITY),
                false => problem.evaluate(at, needs),
            })
            .collect())
    };
    let history = minimise(optimiser.as_mut(), &mut answer).unwrap();
    assert!(history.entries.iter().any(|t| t.evaluation.loss.is_infinite()), "the test should meet the hole");
    assert!(distance(&history.best.at, &problem.optimum) < within);
}

#[test]
fn gauss_newton_halves_a_step_without_a_solution_until_there_is_one() {
    let problem = &PROBLEMS[0];
    let (settings, _) = reach("gauss_newton");
    let mut optimiser = (optimisers::by_name("gauss_newton").unwrap().build)(&problem.problem(), &settings).unwrap();
    let start = optimiser.ask().remove(0);
    optimiser.tell(&[problem.evaluate(&start, Needs::Residuals)]).unwrap();
    let step = |at: &[f64]| -> Vec<f64> { at.iter().zip(&start).map(|(a, b)| a - b).collect() };
    let far = optimiser.ask().remove(0);
    for half in [0.5, 0.25] {
        let asked = optimiser.ask().remove(0);
        optimiser.tell(&[Evaluation::of_loss(asked, f64::INFINITY)]).unwrap();
        let next = optimiser.ask().remove(0);
        assert!(step(&far).iter().zip(step(&next)).all(|(far, near)| (near - half * far).abs() < 1e-12), "{next:?}");
    }
}

#[test]
fn gauss_newton_moves_no_parameter_farther_than_its_longest_step() {
    let problem = &PROBLEMS[2];
    let (mut settings, within) = reach("gauss_newton");
    settings.gauss_newton.longest_step = vec![0.1, 0.3];
    let mut optimiser = (optimisers::by_name("gauss_newton").unwrap().build)(&problem.problem(), &settings).unwrap();
    let mut answer = |batch: &[Vec<f64>], needs| -> Result<Vec<Evaluation>, OptimiseError> {
        Ok(batch.iter().map(|at| problem.evaluate(at, needs)).collect())
    };
    let history = minimise(optimiser.as_mut(), &mut answer).unwrap();
    let mut best = problem.start.to_vec();
    for Evaluation { at, .. } in history.entries.iter().map(|entry| &entry.evaluation) {
        let moved: Vec<f64> = at.iter().zip(&best).map(|(a, b)| (a - b).abs()).collect();
        assert!(moved[0] < 0.1 + 1e-12 && moved[1] < 0.3 + 1e-12, "{moved:?}");
        best = at.clone();
    }
    assert!(distance(&history.best.at, &problem.optimum) < within && history.entries.len() > 8);
}

#[test]
fn a_parameter_that_no_residual_depends_on_is_refused_by_name() {
    let problem = Case { jacobian: |_| vec![2.0, 0.0, 0.0, 0.0], ..PROBLEMS[0] };
    let mut optimiser =
        (optimisers::by_name("gauss_newton").unwrap().build)(&problem.problem(), &Settings::default()).unwrap();
    let evaluations: Vec<_> = optimiser.ask().iter().map(|at| problem.evaluate(at, Needs::Residuals)).collect();
    let error = optimiser.tell(&evaluations).unwrap_err();
    assert!(matches!(error, OptimiseError::Gradient { ref parameter, .. } if parameter == "spine"), "{error}");
}

#[test]
fn the_covariance_of_a_straight_line_is_the_textbook_one() {
    // y = a + b t at t = −1, 0, 1, residuals 1, −2, 1: σ² = 6 / (3 − 2), var a = σ²/3, var b = σ²/2, no covariance
    let line = Residuals { values: vec![1.0, -2.0, 1.0], jacobian: vec![1.0, -1.0, 1.0, 0.0, 1.0, 1.0] };
    let covariance = line.covariance(2).unwrap();
    assert!((covariance.sigma(0) - 2f64.sqrt()).abs() < 1e-12);
    assert!((covariance.sigma(1) - 3f64.sqrt()).abs() < 1e-12);
    assert!(covariance.correlation(0, 1).abs() < 1e-12);
}

#[test]
fn as_many_residuals_as_parameters_give_no_covariance() {
    let exact = Residuals { values: vec![0.1, 0.2], jacobian: vec![1.0, 0.0, 0.0, 1.0] };
    assert!(matches!(exact.covariance(2), Err(OptimiseError::Undetermined { parameters: 2, .. })));
}

#[test]
fn the_correlation_is_that_of_the_ellipse() {
    // JᵀJ = [2 1; 1 2], its inverse is [2 −1; −1 2] / 3
    let bent = Residuals { values: vec![1.0, 1.0, 1.0], jacobian: vec![1.0, 0.0, 0.0, 1.0, 1.0, 1.0] };
    let covariance = bent.covariance(2).unwrap();
    assert!((covariance.correlation(0, 1) + 0.5).abs() < 1e-12);
    assert!((covariance.correlation(1, 1) - 1.0).abs() < 1e-12);
}

/// The log of an optimiser on Rosenbrock's function with a budget that ends it before the optimum.
fn cut_short(name: &str, change: fn(&mut Settings)) -> EvaluationLog {
    let mut settings = reach(name).0;
    change(&mut settings);
    let mut optimiser = (optimisers::by_name(name).unwrap().build)(&PROBLEMS[1].problem(), &settings).unwrap();
    let mut answer = |batch: &[Vec<f64>], needs| -> Result<Vec<Evaluation>, OptimiseError> {
        Ok(batch.iter().map(|at| PROBLEMS[1].evaluate(at, needs)).collect())
    };
    minimise(optimiser.as_mut(), &mut answer).unwrap()
}

#[test]
fn an_optimiser_ends_with_its_budget_of_iterations() {
    for log in [
        cut_short("gauss_newton", |set| set.gauss_newton.iterations = 3),
        cut_short("adam", |set| set.adam.iterations = 3),
        cut_short("cma_es", |set| set.cma_es.generations = 3),
    ] {
        assert_eq!((log.iteration_count(), log.finished), (3, Finished::Budget));
    }
}

#[test]
fn the_step_of_adam_decays_as_it_is_set() {
    let log = cut_short("adam", |set| (set.adam.iterations, set.adam.step, set.adam.step_decay) = (3, 1e-4, 0.5));
    let steps: Vec<f64> = log.entries.windows(2).map(|two| two[1].evaluation.at[0] - two[0].evaluation.at[0]).collect();
    // so short a step leaves the gradient as it is: the step is α / (1 + d i)
    assert!((steps[1] / steps[0] - 1.0 / 1.5).abs() < 1e-3, "{steps:?}");
}

#[test]
fn gauss_newton_moves_a_parameter_on_its_bound_that_no_gradient_holds_there() {
    // x0 stands on its bound with a gradient of zero: the fit of x1 draws it inwards
    let problem = Case {
        residuals: |x| vec![x[0] + x[1] - 1.0, x[1] - 1.0],
        jacobian: |_| vec![1.0, 1.0, 0.0, 1.0],
        start: [1.0, 0.0],
        ..PROBLEMS[0]
    };
    let log = problem.solve("gauss_newton");
    assert!(log.entries[1].evaluation.at[0] < 0.5, "{:?}", log.entries[1]);
}

/// A line whose values are off by the error of a simulation, which its Jacobian does not know.
const SIMULATED: Case = Case {
    residuals: |x| vec![x[0] - 0.3 + 1e-3 * (3e4 * x[0]).sin() + 1.0, x[1] + 0.2 + 1e-3 * (3e4 * x[1]).cos()],
    jacobian: |_| vec![1.0, 0.0, 0.0, 1.0],
    start: [0.8, 0.9],
    optimum: [-0.7, -0.2],
    ..PROBLEMS[0]
};

#[test]
fn gauss_newton_ends_where_a_step_can_no_longer_lower_the_loss() {
    let spent = |fall_tolerance: f64| {
        let (mut settings, _) = reach("gauss_newton");
        settings.gauss_newton.fall_tolerance = fall_tolerance;
        let mut optimiser =
            (optimisers::by_name("gauss_newton").unwrap().build)(&SIMULATED.problem(), &settings).unwrap();
        let mut answer = |batch: &[Vec<f64>], needs| -> Result<Vec<Evaluation>, OptimiseError> {
            Ok(batch.iter().map(|at| SIMULATED.evaluate(at, needs)).collect())
        };
        let log = minimise(optimiser.as_mut(), &mut answer).unwrap();
        assert!(distance(&log.best.at, &SIMULATED.optimum) < 5e-3, "{:?}", log.best.at);
        log.entries.len()
    };
    let (with, without) = (spent(1e-4), spent(0.0));
    assert!(with <= 4 && without >= 2 * with, "{with} and {without} evaluations");
}
