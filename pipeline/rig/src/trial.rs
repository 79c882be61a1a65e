//! One trial: commands → valve → motion of the body → film, logs and ground truth.

use std::path::Path;

use crate::side::Side;
use diagnostics::{Diagnostic, Result};
use lab::card::{Experiment, Medium};
use lab::truth::{TrueForce, TrueTrack, TrueTrial};
use serde::{Deserialize, Serialize};
use si::Second;

use crate::bench::{Bench, TrialRun};
use crate::camera::FrameMotion;
use crate::film::Frames;
use crate::physics::{Conditions, Motion, Staircase, TimeSpan};
use crate::pressure_log::{self, Clock};
use crate::random::RandomStream;
use crate::script::{self, Pneumatics, Script};
use crate::valve::ValveDisturbance;
use crate::{film, folder, force_log};

/// The ground truth of a trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TrialTruth {
    /// Its clocks and disturbances.
    pub(crate) trial: TrueTrial,
    /// Its load cell, where the trial has a force log.
    pub(crate) force: Option<TrueForce>,
}

/// Deviations of one run from the nominal conditions.
struct RunVariation {
    valve: ValveDisturbance,
    /// The silicone's moduli relative to those at the reference temperature.
    softening: f64,
}

impl RunVariation {
    // A staircase is recorded after a rest in a room of steady temperature: its silicone is at the reference temperature and has recovered
    // from the cycles before. Flapping softens it within the first cycle, which is less than the trial's rest and is not resolved.
    fn draw_variation(bench: &Bench, trial: &lab::card::Trial) -> Self {
        let (set, mut random) = (&bench.set.causes, RandomStream::new(bench.seed, &format!("causes {}", trial.id)));
        let mut within = |limit: f64| random.uniform([-limit, limit]);
        let valve = ValveDisturbance { supply: within(set.supply), jitter: set.jitter };
        let warmth = within(set.warmth);
        let moves = matches!(trial.experiment, Experiment::Flapping { .. });
        Self { valve, softening: if moves { 1.0 + warmth } else { 1.0 } }
    }
}

/// Records one trial into `folder` and returns its ground truth.
///
/// # Errors
/// When the solver does not converge or a file cannot be written.
pub(crate) fn record_trial(bench: &Bench, trial: &lab::card::Trial, folder: &Path) -> Result<TrialTruth> {
    let trial_name = format!("{}/{}", bench.name, trial.id);
    let task = bench.progress.begin_step("trial", &trial_name, 1);
    let mut random = RandomStream::new(bench.seed, &format!("trial {}", trial.id));
    let start = bench.profile.rest + random.unit() / bench.set.camera.rate;
    let script = script::write_script(&trial.experiment, start, bench.profile.rest);
    let clock = Clock::drawn(&bench.set.log, &mut random);
    let variation = RunVariation::draw_variation(bench, trial);
    let mut valve = RandomStream::new(bench.seed, &format!("valve {}", trial.id));
    let pneumatics = Pneumatics::of_valve(&bench.set.valve, script, variation.valve, &mut valve);
    let motion = solve_motion(bench, trial, &pneumatics, variation.softening).map_err(|e| e.of(&trial_name))?;
    let log = pressure_log::record_pressures(&bench.set.log, clock, &pneumatics, &mut random);
    folder::write_file(folder, &trial.pressure, lab::pressure::write(&log, lab::VIRTUAL_BENCH).as_bytes())?;
    let run = TrialRun { trial, pneumatics: &pneumatics, motion: motion.as_ref() };
    record_film(bench, &run, folder).map_err(|e| e.of(&trial_name))?;
    let tracks = format!("truth/{}.csv", trial.id);
    let true_tracks = true_tracks(bench, &run).map_err(|e| e.of(&trial_name))?;
    folder::write_file(folder, &tracks, lab::truth::write_tracks(&true_tracks, lab::VIRTUAL_BENCH).as_bytes())?;
    let truth = TrueTrial {
        id: trial.id.clone(),
        tracks,
        clock_offset: clock.offset,
        clock_scale: clock.scale,
        led_on: pneumatics.script.led_on,
        supply: variation.valve.supply,
        softening: variation.softening * bench.softened_model(trial).map_or(1.0, |softened| softened.mean),
        pose: Some(bench.renderer.of_recording(trial.medium, &trial.id).camera_pose()),
    };
    let force = force_log::record_trial(bench, &run, folder)?;
    task.end_step(&format!("{} frames", frame_count(bench, &pneumatics.script)));
    Ok(TrialTruth { trial: truth, force })
}

fn frame_count(bench: &Bench, script: &Script) -> usize {
    (script.length * bench.set.camera.rate).ceil() as usize
}

/// The motion of the body under the chamber pressures.
fn solve_motion<'a>(
    bench: &'a Bench,
    trial: &lab::card::Trial,
    pneumatics: &Pneumatics,
    softening: f64,
) -> Result<Box<dyn Motion + 'a>> {
    let Pneumatics { script, sides } = pneumatics;
    let model = bench.flapping_model;
    let fluid = (trial.medium == Medium::Water).then_some(bench.fluid);
    let span = TimeSpan { start: script.led_on, end: script.length, step: bench.profile.step };
    match &trial.experiment {
        Experiment::Staircase { .. } => {
            let side = Side::first_of(&trial.experiment);
            let index = usize::from(side == Side::Right);
            let staircase = Staircase { side, sweep: &bench.sweeps[index], trace: sides[index].clone() };
            Ok(Box::new(model.simulate_staircase(staircase, span, fluid)?))
        }
        Experiment::Flapping { .. } => {
            let pressures = |t: Second| [sides[0].at(t), sides[1].at(t)];
            let conditions = Conditions { fluid, softening, softened: bench.softened_model(trial) };
            Ok(Box::new(model.simulate_flapping(span, &pressures, &conditions)?))
        }
    }
}

fn record_film(bench: &Bench, run: &TrialRun, folder: &Path) -> Result<()> {
    let (camera, script) = (&bench.set.camera, &run.pneumatics.script);
    let recording = bench.renderer.of_recording(run.trial.medium, &run.trial.id);
    let visible = bench.subject.visible_nodes();
    let draw = |frame: usize| {
        let t = frame as f64 / camera.rate;
        let brightness = script.lamp_share(t + recording.lamp_delay(), 0.5 * camera.exposure);
        let motion = FrameMotion::sample(t, 1.0 / camera.rate, &|t| run.motion.nodes_of(t, &visible));
        let canvas = recording.tail_frame(bench.subject, &motion, brightness);
        bench.renderer.expose_canvas(&canvas, &run.trial.id, frame)
    };
    let frames = Frames { count: frame_count(bench, script), draw: &draw };
    let video = run.trial.video.as_deref().expect("the bench films every trial");
    film::write_film(&folder::prepared_path(folder, video)?, camera, &frames, &|| ())
}

/// The true places of every mark in every frame: the pixel at the time of its row, the point in space at the frame's time.
fn true_tracks(bench: &Bench, run: &TrialRun) -> Result<Vec<TrueTrack>> {
    let recording = bench.renderer.of_recording(run.trial.medium, &run.trial.id);
    let carriers = bench.subject.mark_nodes();
    let named = |name: &String| TrueTrack { marker: name.clone(), ..TrueTrack::default() };
    let mut tracks: Vec<TrueTrack> = bench.marks.iter().map(named).collect();
    for frame in 0..frame_count(bench, &run.pneumatics.script) {
        let t = frame as f64 / bench.set.camera.rate;
        let motion = FrameMotion::sample(t, 1.0 / bench.set.camera.rate, &|t| run.motion.nodes_of(t, &carriers));
        for (track, mark) in tracks.iter_mut().zip(&bench.subject.marks) {
            let pixel = mark.pixel_in_frame(&recording.view, &motion).ok_or_else(|| out_of_view(&track.marker, t))?;
            track.time.push(t);
            track.pixel.push(pixel);
            track.at.push(mark.centre_position(motion.current_nodes()));
        }
    }
    Ok(tracks)
}

fn out_of_view(mark: &str, t: Second) -> Diagnostic {
    Diagnostic::new(
        format!("mark {mark} leaves the field of view at {t:.3} s"),
        "the lens model has no pixel for its position",
        "raise the camera in bench.toml ([camera] above)",
    )
}
