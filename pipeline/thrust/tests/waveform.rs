//! The waveform's gradient against differences, and its optimum against the square wave that it starts from.
#![allow(clippy::unwrap_used)] // tests

use hydro::{Stations, Tail};
use nalgebra::DMatrix;
use thrust::Run;
use thrust::ascent::Limits;
use thrust::square_wave::SquareWave;
use thrust::waveform::{PARAMETERS, Valve, Waveform};
use thrust::waveform_thrust::{Goal, WaveformModel};
use twin::example::{LENGTH, beam};
use twin::{Twin, TwinData};

const SQUARE: SquareWave = SquareWave { amplitude: 1.6e4, frequency: 2.0, sharpness: 3.0 };

/// Evaluates something of the beam in water, both of whose chambers are filled in turn.
fn with_model<T>(iterations: usize, of: impl Fn(&WaveformModel) -> T) -> T {
    let data: TwinData = beam(true);
    let twin = Twin::new(data.clone()).unwrap().with_tolerance(1e-10);
    let rows = DMatrix::from_fn(2, data.coordinates(), |i, j| twin.output_row(i)[j]);
    let stations = Stations { clamp: 0.0, marks: &[LENGTH], edge: LENGTH, end: LENGTH };
    let tail = Tail::new(998.0, &stations, 12, &|_| 0.02).unwrap();
    of(&WaveformModel {
        twin: &twin,
        chambers: &data.chambers,
        halves: &[Some(0), Some(1)],
        rows: &rows,
        theory: (&tail, [1.0, 1.0, 2.0, 0.1, 0.0]),
        share: 1.0,
        valve: Valve { filling: 0.05, emptying: 0.03 },
        limits: Limits { amplitude: 2e4, frequency: [1.0, 3.0], iterations },
        steps_per_cycle: 40,
        cycles: [1, 1],
    })
}

#[test]
fn the_gradient_by_all_harmonics_and_amplitudes_is_that_of_differences() {
    with_model(1, |model| {
        let mut waveform = Waveform::square(&SQUARE, &model.limits);
        waveform.numbers.iter_mut().enumerate().skip(1).for_each(|(n, x)| *x += 0.1 * (1.7 * n as f64).sin());
        for goal in [Goal::Thrust, Goal::ThrustPerAir] {
            let (value, gradient) = model.gradient(goal, &waveform).unwrap();
            let largest = gradient.iter().fold(0.0, |most: f64, by| most.max(by.abs()));
            assert!(value.abs() > 0.0 && gradient.len() == PARAMETERS);
            for n in [1, 2, 3, 4, 10, 18, 19, 21, 22, 36] {
                let at = |by: f64| {
                    let mut near = waveform.clone();
                    near.numbers[n] += by;
                    goal.value(&model.performance(&near).unwrap())
                };
                let difference = (at(1e-4) - at(-1e-4)) / 2e-4;
                // a valve that turns between filling and emptying, and a chamber between drawing and losing air, have a kink
                assert!(
                    (gradient[n] - difference).abs() < 1e-4 * largest,
                    "{goal:?} {n}: {} {difference}",
                    gradient[n]
                );
            }
        }
    });
}

#[test]
fn the_optimal_waveform_has_more_thrust_and_more_thrust_per_air_than_its_square_wave() {
    with_model(30, |model| {
        let start = Waveform::square(&SQUARE, &model.limits);
        let square = model.performance(&start).unwrap();
        for goal in [Goal::Thrust, Goal::ThrustPerAir] {
            let optimum = model.maximise(goal, &start).unwrap();
            let gain = goal.value(&optimum.performance) / goal.value(&square);
            println!("{goal:?}: {square:?} to {:?}, {gain:.3} times", optimum.performance);
            assert!(goal.value(&square) > 0.0 && gain > 1.05, "{goal:?}: {gain}");
            let [low, high] = Waveform::bounds();
            let inside = |(x, (low, high)): (&f64, (&f64, &f64))| (*low..=*high).contains(x);
            assert!(optimum.waveform.numbers.iter().zip(low.iter().zip(&high)).all(inside));
        }
    });
}

#[test]
fn one_frequency_and_one_side_leave_the_other_numbers_as_they_are() {
    with_model(10, |model| {
        let limits = Limits { frequency: [2.0, 2.0], ..model.limits };
        let model = WaveformModel { halves: &[Some(0), None], limits, ..*model };
        let start = Waveform::square(&SQUARE, &model.limits);
        let optimum = model.maximise(Goal::Thrust, &start).unwrap();
        assert!(optimum.performance.thrust > model.performance(&start).unwrap().thrust);
        let kept = |n: usize| optimum.waveform.numbers[n] == start.numbers[n];
        let of_side = (PARAMETERS - 1) / 2;
        assert!(kept(0) && (1 + of_side..PARAMETERS).all(kept) && !(1..=of_side).all(kept));
    });
}

/// Two cycles of the square wave behind the valve, as a recording; nothing was measured but pressures.
fn recorded(model: &WaveformModel) -> Run {
    let (rate, cycles) = (100.0 * SQUARE.frequency, 2);
    let steps = 100 * (cycles + 6);
    let side = |side: usize| {
        let commands: Vec<f64> = (0..steps).map(|n| SQUARE.at(f64::from(n as u32) / rate)[side]).collect();
        model.valve.follow(&commands, 1.0 / rate)[steps - 100 * cycles..].to_vec()
    };
    let [left, right] = [side(0), side(1)];
    let samples = left.len();
    Run {
        id: "recorded".into(),
        amplitude: SQUARE.amplitude,
        frequency: SQUARE.frequency,
        split: None,
        rate,
        time: (0..samples).map(|n| n as f64 / rate).collect(),
        force: vec![0.0; samples],
        moved: vec![Vec::new(); samples],
        speed: vec![Vec::new(); samples],
        pressure: left.into_iter().zip(right).map(|(l, r)| vec![l, r]).collect(),
        pressure_rate: vec![vec![0.0; 2]; samples],
        terms: Vec::new(),
    }
}

#[test]
fn optimal_waveforms_stand_beside_square_waves_and_a_recorded_flap() {
    with_model(20, |model| {
        let model = &WaveformModel { cycles: [6, 1], ..*model };
        let found = model.optimal_waveforms(&recorded(model)).unwrap();
        let exact = model.performance(&Waveform::square(&SQUARE, &model.limits)).unwrap();
        let of = found.recorded.performed;
        // interpolated between samples, in steps of another length than the valve's
        assert!((of.thrust_n / exact.thrust - 1.0).abs() < 0.02, "{of:?} {exact:?}");
        assert!((of.air_m3_s / exact.air - 1.0).abs() < 0.02 && (of.amplitude_m / exact.amplitude - 1.0).abs() < 0.02);
        assert!(found.sweep.len() == 36 && found.optima.len() == 2 && found.valve == model.valve);
        for optimum in &found.optima {
            println!("{}: {:.3} times {:?}", optimum.flap.name, optimum.gain(), optimum.square.performed);
            assert!(optimum.gain() > 1.0, "{}", optimum.gain());
            assert!(optimum.flap.pressure_pa.iter().flatten().all(|p| (0.0..=model.limits.amplitude).contains(p)));
        }
        let most = found.sweep.iter().map(|p| p.thrust_n).fold(0.0, f64::max);
        assert!((most - found.optima[0].square.performed.thrust_n).abs() < 1e-12);
    });
}
