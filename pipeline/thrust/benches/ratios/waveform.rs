//! The waveform of most thrust, and of most thrust per air, against a sweep of square waves through the same valve.

use crate::tail::Specimen;
use crate::{Outcome, WATER};
use sysid::ReducedBody;
use thrust::ascent::Limits;
use thrust::real_time::{Surroundings, twin_data};
use thrust::square_wave::SquareWave;
use thrust::waveform::{Valve, Waveform};
use thrust::waveform_thrust::{Goal, WaveformModel};
use twin::Twin;

/// As the study measures on its logs: filling to within 5 % takes 150 to 230 ms, of which 40 to 85 ms are dead time; the time constant of
/// emptying from 200 mbar. The dead times shift the whole cycle.
const VALVE: Valve = Valve { filling: 0.045, emptying: 0.04 };
/// As in the study: the ranges of the recorded flaps.
const LIMITS: Limits = Limits { amplitude: 2e4, frequency: [1.0, 3.0], iterations: 60 };
/// Lighthill's terms, and the drag of a plate.
const THEORY: [f64; 5] = [1.0, 1.0, 2.0, 0.0, 0.0];
/// Amplitudes (relative to the highest) and frequencies of the sweep.
const SWEEP: [usize; 2] = [4, 9];

/// Prints thrust and air of the best of the sweep and of the optimum for each goal.
pub fn print(specimen: &Specimen, body: &ReducedBody) -> Outcome<()> {
    let stations = specimen.stations(body);
    let water = Surroundings { tail: &specimen.wet, rows: &stations, by: WATER, half: true };
    let data = twin_data(body, Some(&water), &[("tip", specimen.tip())])?;
    let twin = Twin::new(data.clone())?;
    let model = WaveformModel {
        twin: &twin,
        chambers: &data.chambers,
        halves: &[Some(0), Some(1)],
        rows: &stations,
        theory: (&specimen.wet, THEORY),
        share: 0.5,
        valve: VALVE,
        limits: LIMITS,
        steps_per_cycle: 60,
        cycles: [6, 1],
    };
    for (name, goal) in [("thrust", Goal::Thrust), ("thrust_per_air", Goal::ThrustPerAir)] {
        let start = best_of_sweep(&model, goal)?;
        let square = model.performance(&start)?;
        let optimum = model.maximise(goal, &start)?;
        let text = |of: &thrust::waveform_thrust::Performance| {
            format!("{:.2} mN with {:.2} ml/s", 1e3 * of.thrust, 1e6 * of.air)
        };
        println!("best square wave for {name}: {} at {:.2} Hz", text(&square), start.frequency(&LIMITS));
        println!(
            "best waveform for {name}: {} at {:.2} Hz",
            text(&optimum.performance),
            optimum.waveform.frequency(&LIMITS)
        );
        println!("waveform_over_sweep_{name} = {:.3}", goal.value(&optimum.performance) / goal.value(&square));
    }
    Ok(())
}

fn best_of_sweep(model: &WaveformModel, goal: Goal) -> Outcome<Waveform> {
    let mut best: Option<(f64, Waveform)> = None;
    for (a, f) in (1..=SWEEP[0]).flat_map(|a| (0..SWEEP[1]).map(move |f| (a, f))) {
        let normalised_coordinates = [a as f64 / SWEEP[0] as f64, f as f64 / (SWEEP[1] - 1) as f64];
        let wave = LIMITS.wave(normalised_coordinates, SquareWave { amplitude: 0.0, frequency: 0.0, sharpness: 6.0 });
        let waveform = Waveform::square(&wave, &LIMITS);
        let value = goal.value(&model.performance(&waveform)?);
        if best.as_ref().is_none_or(|(most, _)| value > *most) {
            best = Some((value, waveform));
        }
    }
    Ok(best.map(|(_, waveform)| waveform).unwrap_or_else(|| Waveform { numbers: Vec::new() }))
}
