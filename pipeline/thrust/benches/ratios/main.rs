//! How much faster than real time flapping tails, of thick and of thin walls, move on one core, in air and in water, with the error beside each: the whole model, the
//! reduced one, and the twin made of it, the twin also with its gradient. At 240 steps a second, under a square wave of 200 mbar at 2 Hz.
//!
//! Then the waveform of most thrust in water, found by that gradient, against a sweep of square waves.
//!
//! The errors are largest distances of the tip marker, in per cent of the length. `-- --long` compares with the whole model over two
//! seconds instead of a quarter of one, some ten minutes.

mod tail;
mod waveform;

use std::time::Instant;

use fem::{DynamicSettings, InitialValueProblem, Scheme, State};
use hydro::Coefficients;
use nalgebra::DVector;
use si::Point2;
use sysid::{ForcedMotion, Model, ReducedBody, even_times};
use tail::Specimen;
use thrust::real_time::{Surroundings, twin_data};
use thrust::square_wave::SquareWave;
use thrust::water::Water;
use twin::{LossGradient, Twin, TwinData};

type Outcome<T> = diagnostics::Result<T>;
/// A path of the tip marker, and the CPU time that it took, s.
type Timed = (Vec<Point2>, f64);

/// Time steps a second, as in the study.
const RATE: f64 = 240.0;
/// Of the motions of the reduced model and the twin, s.
const DURATION: f64 = 4.0;
/// Hydrodynamic coefficients like those that the study identifies.
const WATER: Coefficients = Coefficients { added: 1.0, drag: 5.0 };
const WAVE: SquareWave = SquareWave { amplitude: 2e4, frequency: 2.0, sharpness: 6.0 };
/// Duration of the ramp from rest, as long as a valve takes to fill a chamber, s.
const RAMP: f64 = 0.15;

fn main() -> Outcome<()> {
    let thick = Specimen::thick()?;
    let body = thick.reduced()?;
    time_motions("thick_", &thick, &body)?;
    let thin = Specimen::thin()?;
    time_motions("", &thin, &thin.reduced()?)?;
    waveform::print(&thick, &body)
}

/// Prints the factors and errors of a tail's motions, named by its `prefix`.
fn time_motions(prefix: &str, specimen: &Specimen, body: &ReducedBody) -> Outcome<()> {
    println!("{} dofs, {} coordinates", specimen.model.system.dofs(), body.coordinates());
    let steps = (DURATION * RATE) as usize;
    for wet in [false, true] {
        let name = format!("{prefix}{}", if wet { "water" } else { "air" });
        let (path, seconds) = reduced(specimen, body, wet, steps)?;
        let twin = Twin::new(arrays(specimen, body, wet)?)?;
        let (own, own_seconds) = motion(&twin, steps)?;
        println!("real_time_factor_reduced_{name} = {:.1}", DURATION / seconds);
        println!("real_time_factor_{name} = {:.1}", DURATION / own_seconds);
        let [recorded, gradient] = with_gradient(&twin, steps)?;
        println!("real_time_factor_gradient_{name} = {:.1}", DURATION / gradient);
        println!("recording_over_motion_{name} = {:.2}", recorded / own_seconds);
        println!("gradient_over_motion_{name} = {:.2}", gradient / own_seconds);
        println!("twin_off_reduced_{name}_percent = {:.2e}", percent(&own, &path));
        if !wet {
            against_whole((prefix, specimen), (&path, &own), own_seconds / steps as f64)?;
        }
    }
    Ok(())
}

/// The whole model over a part of the same motion.
fn against_whole((prefix, specimen): (&str, &Specimen), (path, own): (&[Point2], &[Point2]), step: f64) -> Outcome<()> {
    let duration = if std::env::args().any(|word| word == "--long") { 2.0 } else { 0.25 };
    let steps = (duration * RATE) as usize;
    let (whole, seconds) = whole(specimen, steps)?;
    println!("twin_off_whole_{prefix}air_percent = {:.4}", percent(&own[..steps], &whole));
    println!("reduced_off_whole_{prefix}air_percent = {:.4}", percent(&path[..steps], &whole));
    println!("{prefix}whole_over_twin = {:.0}", seconds / (step * steps as f64));
    Ok(())
}

/// Largest distance, % of the length.
fn percent(a: &[Point2], b: &[Point2]) -> f64 {
    let far = |(a, b): (&Point2, &Point2)| (a[0] - b[0]).hypot(a[1] - b[1]);
    100.0 / tail::LENGTH * a.iter().zip(b).map(far).fold(0.0, f64::max)
}

/// Pressures of both sides, Pa.
fn pressures(t: f64) -> Vec<f64> {
    let part = (t / RAMP).min(1.0);
    WAVE.at(t).iter().map(|p| p * part * part * (3.0 - 2.0 * part)).collect()
}

fn settings() -> DynamicSettings {
    DynamicSettings { step: 1.0 / RATE, scheme: Scheme::Bdf2, ..DynamicSettings::default() }
}

fn reduced(specimen: &Specimen, body: &ReducedBody, wet: bool, steps: usize) -> Outcome<Timed> {
    let (times, settings) = (even_times(1.0 / RATE, steps), settings());
    let motion = ForcedMotion { settings: &settings, pressures: &pressures, times: &times };
    let (rows, tip) = (specimen.stations(body), body.rows(&[specimen.tip()]));
    timed(1, || {
        let mut path = Vec::with_capacity(steps);
        let mut see = |q: &DVector<f64>, _: &DVector<f64>| path.push([0, 1].map(|k| (tip.row(k) * q)[0]));
        match wet {
            false => body.integrate_in_fluid(&motion, &mut fem::NoForce, &mut see)?,
            true => {
                let mut water = Water::around(&specimen.wet, &rows, WATER, true);
                body.integrate_in_fluid(&motion, &mut water, &mut see)?;
            }
        }
        Ok(path)
    })
}

fn arrays(specimen: &Specimen, body: &ReducedBody, wet: bool) -> Outcome<TwinData> {
    let rows = specimen.stations(body);
    let water = Surroundings { tail: &specimen.wet, rows: &rows, by: WATER, half: true };
    let data = twin_data(body, wet.then_some(&water), &[("tip", specimen.tip())])?;
    println!("{} points", data.points());
    Ok(data)
}

fn motion(twin: &Twin, steps: usize) -> Outcome<Timed> {
    let mut work = twin::Work::default();
    let recorded_path = timed(3, || {
        let mut state = twin.start();
        let mut path = Vec::with_capacity(steps);
        for step in 1..=steps {
            twin.step(&mut state, &pressures(step as f64 / RATE), 1.0 / RATE)?;
            path.push([twin.output(&state, 0), twin.output(&state, 1)]);
        }
        work = state.work();
        Ok(path)
    })?;
    let per_step = |count: usize| count as f64 / steps as f64;
    println!(
        "steps, residuals, tangents over steps: {:.2}, {:.2}, {:.3}",
        per_step(work.steps),
        per_step(work.residuals),
        per_step(work.tangents)
    );
    Ok(recorded_path)
}

/// CPU time of a recorded motion, and of it with the derivatives of the mean square of the tip's displacement by everything, s.
fn with_gradient(twin: &Twin, steps: usize) -> Outcome<[f64; 2]> {
    let record = || {
        let mut recording = twin.recording();
        let mut step = |n: usize| twin.record(&mut recording, &pressures(n as f64 / RATE), 1.0 / RATE);
        (1..=steps).try_for_each(&mut step)?;
        Outcome::Ok(recording)
    };
    let (_, recorded) = timed(3, || record().map(|_| Vec::new()))?;
    let (_, gradient) = timed(3, || {
        let (recording, row) = (record()?, twin.output_row(1));
        let mut loss = |n: usize| {
            let tip: f64 = row.iter().zip(recording.coordinates(n)).map(|(row, q)| row * q).sum();
            let coordinates = row.iter().map(|row| 2.0 * tip * row / steps as f64).collect();
            LossGradient { coordinates, velocity: Vec::new() }
        };
        let adjoint = twin.adjoint(&recording, &mut loss)?;
        Ok(adjoint.pressures.iter().map(|gradient| [gradient[0], gradient[1]]).collect())
    })?;
    Ok([recorded, gradient])
}

fn whole(specimen: &Specimen, steps: usize) -> Outcome<Timed> {
    let settings = settings();
    let mut solver = specimen.model.system.solver();
    specimen.silicone.apply(&mut solver)?;
    let rest_state = State::rest(specimen.model.system.mesh().nodes.len());
    let problem = InitialValueProblem { settings: &settings, initial: &rest_state, pressures: &pressures };
    timed(1, || {
        let mut path = Vec::with_capacity(steps);
        let spot = &specimen.model.markers[specimen.tip()];
        let mut see = |_: f64, state: &State| path.push(Model::in_plane(spot, &state.displacement));
        solver.integrate(&problem, steps, &mut see)?;
        Ok(path)
    })
}

/// The path of a motion, and the least CPU time of several runs of this thread, s.
fn timed(times: usize, mut run: impl FnMut() -> Outcome<Vec<Point2>>) -> Outcome<Timed> {
    let clock = Instant::now();
    let (mut least, mut path) = (f64::INFINITY, Vec::new());
    for _ in 0..times {
        let start_seconds = cpu(clock);
        path = run()?;
        least = least.min(cpu(clock) - start_seconds);
    }
    Ok((path, least))
}

/// Seconds that this thread has run, from the kernel where available, else from the wall clock.
fn cpu(start: Instant) -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = text.and_then(|line| line.split(' ').next().and_then(|word| word.parse::<f64>().ok()));
    nanoseconds.map_or_else(|| start.elapsed().as_secs_f64(), |ns| 1e-9 * ns)
}
