//! How long steps take at 1 kHz: mean, 99.9 % and worst of 10⁵ under pressures that fill the first two chambers in turn.
//!
//! `cargo run --release --example step_times -- tail.safetensors`; without a file it steps the example's beam in water.

use std::path::Path;
use std::time::Instant;

use twin::Twin;

/// Steps, and steps a second.
const STEPS: usize = 100_000;
const RATE: f64 = 1000.0;
/// Frequency of the pressures, Hz, and the part of their range that they fill.
const FREQUENCY: f64 = 2.0;
const PART: f64 = 0.5;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let data = match std::env::args().nth(1) {
        Some(file) => twin::file::read(Path::new(&file))?,
        None => twin::example::beam(true),
    };
    let twin = Twin::new(data)?;
    let (mut state, mut pressures) = (twin.start(), vec![0.0; twin.chambers().len()]);
    let mut times = Vec::with_capacity(STEPS);
    for n in 0..STEPS {
        let wave = (std::f64::consts::TAU * FREQUENCY * n as f64 / RATE).sin();
        for (pressure, (chamber, sign)) in pressures.iter_mut().zip(twin.chambers().iter().zip([1.0, -1.0])) {
            *pressure = PART * chamber.range[1].min(2e4) * (sign * wave).max(0.0);
        }
        let start = Instant::now();
        twin.step(&mut state, &pressures, 1.0 / RATE)?;
        times.push(start.elapsed().as_secs_f64());
    }
    let mean = times.iter().sum::<f64>() / STEPS as f64;
    times.sort_by(f64::total_cmp);
    let [late, worst] = [STEPS - STEPS / 1000, STEPS].map(|rank| 1e6 * times[rank - 1]);
    let work = state.work();
    println!(
        "mean {:.1} µs ({:.1} times real time), 99.9 % {late:.1} µs, worst {worst:.1} µs; {:.2} residuals and {:.2} tangents a step",
        1e6 * mean,
        1.0 / (RATE * mean),
        work.residuals as f64 / work.steps as f64,
        work.tangents as f64 / work.steps as f64
    );
    Ok(())
}
