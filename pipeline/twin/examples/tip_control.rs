//! A loop around a reduced tail at 1 kHz: a proportional-integral-derivative (PID) controller of the tip's lateral deflection that fills one
//! chamber or the other.
//!
//! `cargo run --release --example tip_control -- tail.safetensors tip_y` of an exported tail; the output is the marker's along y.

use twin::{Twin, TwinError};

/// Steps a second.
pub const RATE: f64 = 1000.0;

/// A controller: pressure by the error, its integral and the tip's velocity, in the chamber that bends towards the target.
#[derive(Debug, Clone, Copy)]
pub struct Controller {
    /// Pa/m.
    pub proportional: f64,
    /// Pa/(m s).
    pub integral: f64,
    /// Pa s/m, of the tip's own velocity: a target may jump.
    pub derivative: f64,
    /// Highest pressure, Pa.
    pub highest: f64,
    /// The output that is controlled.
    pub output: usize,
    /// The chamber that bends towards positive output, and the one that bends away from it.
    pub chambers: [usize; 2],
}

/// What a loop did: time (s), target and tip (m) of every step.
pub type Trace = Vec<[f64; 3]>;

/// Follows a `target` (m, of the time in s) for `duration` seconds.
///
/// # Errors
/// [`TwinError`] where the tail finds no step.
pub fn follow(twin: &Twin, by: &Controller, target: &dyn Fn(f64) -> f64, duration: f64) -> Result<Trace, TwinError> {
    let (mut state, mut sum, mut last, mut trace) = (twin.start(), 0.0, 0.0, Trace::new());
    for n in 0..(duration * RATE) as usize {
        let (goal, tip) = (target(n as f64 / RATE), twin.output(&state, by.output));
        let (error, velocity) = (goal - tip, (tip - last) * RATE);
        let command = by.proportional * error + by.integral * (sum + error / RATE) - by.derivative * velocity;
        last = tip;
        let pressure = command.clamp(-by.highest, by.highest);
        // the integral stands still while the valves are at their limit
        if command == pressure {
            sum += error / RATE;
        }
        let mut pressures = vec![0.0; by.chambers.iter().max().map_or(0, |last| last + 1)];
        pressures[by.chambers[usize::from(pressure < 0.0)]] = pressure.abs();
        twin.step(&mut state, &pressures, 1.0 / RATE)?;
        trace.push([state.time(), goal, twin.output(&state, by.output)]);
    }
    Ok(trace)
}

/// A controller for a tail of two chambers: the sign and the gains follow from where `highest` pressure in the first chamber moves the output.
///
/// # Errors
/// [`TwinError`] where the tail finds no step.
pub fn tuned(twin: &Twin, output: usize, highest: f64) -> Result<Controller, TwinError> {
    let mut state = twin.start();
    for n in 1..=200 {
        twin.step(&mut state, &[highest * f64::from(n) / 200.0, 0.0], 0.005)?;
    }
    let reach = twin.output(&state, output);
    let chambers = if reach > 0.0 { [0, 1] } else { [1, 0] };
    let stiffness = highest / reach.abs();
    let [proportional, integral, derivative] = [0.5, 5.0, 0.04].map(|gain| gain * stiffness);
    Ok(Controller { proportional, integral, derivative, highest, output, chambers })
}

#[allow(dead_code)] // a test takes this file as a module
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().ok_or("name the file of a tail, tail.safetensors")?;
    let twin = Twin::new(twin::file::read(std::path::Path::new(&file))?)?;
    let name = arguments.next().ok_or("name an output, such as m6_y")?;
    let output = twin.output_number(&name)?;
    let highest = twin.chambers().iter().map(|chamber| chamber.range[1]).fold(2e4, f64::min);
    let controller = tuned(&twin, output, highest)?;
    let start = std::time::Instant::now();
    let trace = follow(&twin, &controller, &|t| if t < 0.1 { 0.0 } else { 5e-3 }, 3.0)?;
    let seconds = start.elapsed().as_secs_f64();
    let last = trace[trace.len() - 1];
    println!(
        "tip {:.3} mm of {:.3} mm after {:.1} s; {:.1} times faster than real time",
        1e3 * last[2],
        1e3 * last[1],
        last[0],
        last[0] / seconds
    );
    Ok(())
}
