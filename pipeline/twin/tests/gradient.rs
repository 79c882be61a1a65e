//! The adjoint of a motion: the Taylor test, and central differences by everything that the motion depends on.
#![allow(clippy::unwrap_used)] // tests

use twin::example::beam;
use twin::{LossGradient, MotionGradient, Recording, Twin, TwinData};

/// Two checkpoints are passed.
const STEPS: usize = 80;
const STEP: f64 = 1.0 / 240.0;
/// Largest displacement, m, and speed, m/s, of the loss.
const SIZES: [f64; 2] = [0.005, 0.1];

/// What a loss is taken of: the arrays, and the pressures of both chambers at every step.
#[derive(Clone)]
struct Case {
    data: TwinData,
    pressures: Vec<[f64; 2]>,
}

impl Case {
    fn new(wet: bool) -> Self {
        let pressure = |n: usize, side: f64| {
            let t = n as f64 * STEP;
            1e4 * (1.0 - (-8.0 * t).exp()) * (1.0 + side * (25.0 * t).sin())
        };
        let mut data = beam(wet);
        // so large that the small strains of a beam feel them
        data.regions[0].stiffening = [1e7, 5e9];
        Self { data, pressures: (1..=STEPS).map(|n| [1.0, -1.0].map(|side| pressure(n, side))).collect() }
    }

    fn twin(&self) -> Twin {
        Twin::new(self.data.clone()).unwrap().with_tolerance(1e-11)
    }

    /// The motion; every tenth step is twice as long.
    fn recorded(&self) -> Recording {
        let twin = self.twin();
        let mut recording = twin.recording();
        for (n, pressures) in self.pressures.iter().enumerate() {
            let long = if n % 10 == 9 { 2.0 } else { 1.0 };
            twin.record(&mut recording, pressures, long * STEP).unwrap();
        }
        recording
    }

    /// L = Σ over the steps of wₙ (l + ½ l²) with l of the tip's displacement and of its velocity.
    fn loss(&self) -> f64 {
        let (twin, recording) = (self.twin(), self.recorded());
        (0..STEPS).map(|n| instant(&twin, &recording, n).0).sum()
    }

    fn gradient(&self) -> MotionGradient {
        let (twin, recording) = (self.twin(), self.recorded());
        twin.adjoint(&recording, &mut |n| instant(&twin, &recording, n).1).unwrap()
    }

    /// The central difference of the loss along a change of the case, by fourth-order weights.
    fn difference(&self, change: &dyn Fn(&mut Case, f64), step: f64) -> f64 {
        let loss = |by: f64| {
            let mut case = self.clone();
            change(&mut case, by * step);
            case.loss()
        };
        (8.0 * (loss(1.0) - loss(-1.0)) - (loss(2.0) - loss(-2.0))) / (12.0 * step)
    }
}

/// The part of one step in the loss, and its derivatives.
fn instant(twin: &Twin, recording: &Recording, n: usize) -> (f64, LossGradient) {
    let weight = (0.37 * n as f64).sin() / STEPS as f64;
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (mut value, mut by) = (0.0, Vec::new());
    for (of, size) in [recording.coordinates(n), recording.velocity(n)].into_iter().zip(SIZES) {
        let mut row = twin.output_row(1).to_vec();
        row.iter_mut().zip(twin.output_row(0)).for_each(|(y, x)| *y += 3.0 * x);
        let l = dot(&row, of) / size;
        value += weight * (l + 0.5 * l * l);
        by.push(row.iter().map(|row| weight * (1.0 + l) * row / size).collect());
    }
    let velocity = by.pop().unwrap();
    (value, LossGradient { coordinates: by.pop().unwrap(), velocity })
}

type Change = (&'static str, Box<dyn Fn(&mut Case, f64)>, f64);

/// Every number that the motion depends on, as a relative change, and the derivative by it.
fn changes(case: &Case, by: &MotionGradient) -> Vec<Change> {
    fn change(name: &'static str, of: impl Fn(&mut Case) -> &mut f64 + 'static, by: f64) -> Change {
        (name, Box::new(move |case, part| *of(case) *= 1.0 + part), by)
    }
    let (of, region) = (&case.data.regions[0], &by.regions[0]);
    let mut all = vec![
        change("mu", |case| &mut case.data.regions[0].mu, region.mu * of.mu),
        change("lambda", |case| &mut case.data.regions[0].lambda, region.lambda * of.lambda),
        change("c20", |case| &mut case.data.regions[0].stiffening[0], region.stiffening[0] * of.stiffening[0]),
        change("c30", |case| &mut case.data.regions[0].stiffening[1], region.stiffening[1] * of.stiffening[1]),
    ];
    let youngs_modulus = of.mu * (3.0 * of.lambda + 2.0 * of.mu) / (of.lambda + of.mu);
    let scale = |case: &mut Case, part: f64| {
        let region = &mut case.data.regions[0];
        let [c20, c30] = &mut region.stiffening;
        [&mut region.mu, &mut region.lambda, c20, c30].into_iter().for_each(|modulus| *modulus *= 1.0 + part);
    };
    all.push(("Young's modulus", Box::new(scale), region.by_youngs_modulus(of) * youngs_modulus));
    for branch in 0..2 {
        for (which, name) in ["strength", "time"].into_iter().enumerate() {
            let own = region.branches[branch][which] * of.branches[branch][which];
            all.push(change(name, move |case| &mut case.data.regions[0].branches[branch][which], own));
        }
    }
    for (steps, chamber) in [(0..10, 0), (30..40, 1), (70..STEPS, 0)] {
        let own = steps.clone().map(|n| by.pressures[n][chamber] * case.pressures[n][chamber]).sum();
        let scaled = move |case: &mut Case, part: f64| {
            case.pressures[steps.clone()].iter_mut().for_each(|pressures| pressures[chamber] *= 1.0 + part);
        };
        all.push(("pressure", Box::new(scaled), own));
    }
    if !case.data.sections.is_empty() {
        let scaled = |numbers: &'static [usize]| {
            move |case: &mut Case, part: f64| {
                let each = case.data.sections.iter_mut();
                each.for_each(|section| numbers.iter().for_each(|k| section.by[*k] *= 1.0 + part));
            }
        };
        all.push(("added mass", Box::new(scaled(&[0, 2, 3])), by.water[0]));
        all.push(("drag", Box::new(scaled(&[1])), by.water[1]));
    }
    all
}

#[test]
fn in_air_and_in_water_the_adjoint_agrees_with_differences_by_everything_that_the_motion_depends_on() {
    for wet in [false, true] {
        let case = Case::new(wet);
        let gradient = case.gradient();
        for (name, change, own) in changes(&case, &gradient) {
            // longer ones differ by 1e-5 in water, where the drag's |w| w has no second derivative
            let difference = case.difference(&*change, 3e-3);
            println!("{name}: {own:.9e}, off by {:.1e}", (own / difference - 1.0).abs());
            assert!(
                (own - difference).abs() < 1e-6 * difference.abs().max(1e-2 * case.loss().abs()),
                "{name}: {own} {difference}"
            );
        }
    }
}

#[test]
fn the_remainder_of_the_first_order_falls_with_the_square_of_the_change() {
    for wet in [false, true] {
        let case = Case::new(wet);
        let all = changes(&case, &case.gradient());
        let slope: f64 = all.iter().map(|(_, _, own)| own).sum();
        let start = case.loss();
        let remainder = |part: f64| {
            let mut case = case.clone();
            all.iter().for_each(|(_, change, _)| change(&mut case, part));
            (case.loss() - start - part * slope).abs()
        };
        let rates: Vec<f64> = [2e-3, 1e-3, 5e-4].map(|part| (remainder(part) / remainder(0.5 * part)).log2()).to_vec();
        println!("Taylor rates {rates:?}");
        assert!(rates.iter().all(|rate| (rate - 2.0).abs() < 0.05), "{rates:?}");
    }
}

const SUDDEN: [[f64; 2]; 3] = [[0.0, 0.0], [8e4, 0.0], [0.0, 8e4]];
/// Iterations with which steps to those pressures (Pa) are carried in parts.
const FEW_ITERATIONS: usize = 9;

#[test]
fn a_recorded_motion_is_the_motion_and_parts_of_steps_share_their_pressures() {
    let (twin, data) = (Twin::new(beam(false)).unwrap().with_tolerance(1e-11), beam(false));
    let twin = twin.with_iterations(FEW_ITERATIONS);
    let (mut state, mut recording) = (twin.start(), twin.recording());
    for pressures in SUDDEN {
        twin.step(&mut state, &pressures, 0.1).unwrap();
        twin.record(&mut recording, &pressures, 0.1).unwrap();
        assert_eq!(recording.coordinates(recording.steps() - 1), state.coordinates());
    }
    assert!(state.work().steps > 3 && recording.steps() == 3, "{:?}", state.work());
    let case = Case { data, pressures: SUDDEN.to_vec() };
    let tip = |case: &Case| {
        let twin = case.twin().with_iterations(FEW_ITERATIONS);
        let mut recording = twin.recording();
        case.pressures.iter().for_each(|pressures| twin.record(&mut recording, pressures, 0.1).unwrap());
        recording
    };
    let value = |case: &Case| twin.output(tip(case).state(), 1);
    let last = |n: usize| LossGradient {
        coordinates: if n == 2 { twin.output_row(1).to_vec() } else { Vec::new() },
        velocity: Vec::new(),
    };
    let by = twin.adjoint(&tip(&case), &mut |n| last(n)).unwrap();
    for step in 0..3 {
        let at = |change: f64| {
            let mut case = case.clone();
            case.pressures[step][0] += change;
            value(&case)
        };
        let difference = (at(10.0) - at(-10.0)) / 20.0;
        println!("{step}: off by {:.1e}", (by.pressures[step][0] / difference - 1.0).abs());
        assert!((by.pressures[step][0] / difference - 1.0).abs() < 1e-5, "{step}: {difference} {by:?}");
    }
}
