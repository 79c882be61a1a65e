//! One trial: script → valve → body → film, logs and truth.
//!
//! Stands on: the physics, the studio, the logger, the load cell. Never knows: the other trials, where the folder will end up.

use std::path::Path;

use lab::card::{Experiment, Side};
use lab::truth::{TrueForce, TrueTrack, TrueTrial};
use si::{Pascal, Second};

use crate::camera::Passing;
use crate::draw::Draw;
use crate::fault::Fault;
use crate::logger::{self, Clock};
use crate::physics::{self, Body, Motion, Quasistatic};
use crate::progress::Progress;
use crate::script::{self, Script};
use crate::settings::{Profile, Settings};
use crate::studio::{Studio, Subject};
use crate::valve::{Trace, follow};
use crate::{film, folder, weighing};

/// What all trials of a specimen share.
pub struct Bench<'a> {
    /// The settings.
    pub set: &'a Settings,
    /// How much and how finely.
    pub profile: &'a Profile,
    /// The specimen's name.
    pub name: &'a str,
    /// The specimen's seed.
    pub seed: u64,
    /// The specimen.
    pub body: &'a Body,
    /// The camera and its surroundings.
    pub studio: &'a Studio,
    /// What is filmed.
    pub subject: &'a Subject,
    /// Names of the marks.
    pub marks: &'a [String],
    /// Where progress goes.
    pub progress: &'a Progress,
}

/// Records one trial into `folder` and returns what was hidden in it.
///
/// # Errors
/// [`Fault`] when the body cannot be solved or the disk refuses.
pub fn record(bench: &Bench, trial: &lab::card::Trial, folder: &Path) -> Result<(TrueTrial, Option<TrueForce>), Fault> {
    let place = format!("{}/{}", bench.name, trial.id);
    let mut draw = Draw::new(bench.seed, &format!("trial {}", trial.id));
    let start = bench.profile.rest + draw.unit() / bench.set.camera.rate;
    let script = script::write(&trial.experiment, start, bench.profile.rest);
    let clock = Clock::drawn(&bench.set.log, &mut draw);
    let mut bursts = Draw::new(bench.seed, &format!("valve {}", trial.id));
    let sides = [&script.left, &script.right].map(|c| follow(&bench.set.valve, c, &mut bursts));
    let motion = solve(bench, &trial.experiment, &script, &sides, &place)?;
    let log = logger::record(&bench.set.log, clock, &script, [&sides[0], &sides[1]], &mut draw);
    folder::write(folder, &trial.pressure, lab::pressure::write(&log, lab::VIRTUAL_BENCH).as_bytes())?;
    shoot(bench, trial, motion.as_ref(), &script, folder, &place)?;
    let tracks = format!("truth/{}.csv", trial.id);
    let seen = true_tracks(bench, trial, motion.as_ref(), &script)?;
    folder::write(folder, &tracks, lab::truth::write_tracks(&seen, lab::VIRTUAL_BENCH).as_bytes())?;
    let (clock_offset, clock_scale) = (clock.offset, clock.scale);
    let truth = TrueTrial { id: trial.id.clone(), tracks, clock_offset, clock_scale, led_on: script.led_on };
    Ok((truth, weighing::of_trial(bench, trial, motion.as_ref(), &script, &sides, folder)?))
}

/// Frames of a trial.
fn frames(bench: &Bench, script: &Script) -> usize {
    (script.length * bench.set.camera.rate).ceil() as usize
}

/// The motion of the body under what the valve makes of the script.
fn solve(
    bench: &Bench,
    experiment: &Experiment,
    script: &Script,
    sides: &[Trace; 2],
    place: &str,
) -> Result<Box<dyn Motion>, Fault> {
    match experiment {
        Experiment::Staircase { side, .. } => quasistatic(bench, *side, sides, place),
        Experiment::Flapping { .. } => flapping(bench, script, sides, place),
    }
}

fn quasistatic(bench: &Bench, side: Side, sides: &[Trace; 2], place: &str) -> Result<Box<dyn Motion>, Fault> {
    let trace = sides[usize::from(side == Side::Right)].clone();
    let mut held: Vec<Pascal> = trace.settled().filter(|level| *level > 0.0).collect();
    held.sort_by(f64::total_cmp);
    held.dedup();
    let pressures = physics::rungs(&held, bench.profile.rungs_between);
    let task = bench.progress.begin("statics", place, pressures.len() - 1);
    let ladder = physics::ladder(bench.body, side, &pressures, &|| task.tick())?;
    task.done(&format!("{} equilibria of {} unknowns", pressures.len() - 1, bench.body.system.freedoms()));
    Ok(Box::new(Quasistatic { rest: bench.body.mesh.nodes.clone(), pressures, ladder, trace }))
}

fn flapping(bench: &Bench, script: &Script, sides: &[Trace; 2], place: &str) -> Result<Box<dyn Motion>, Fault> {
    let rate = bench.set.camera.rate;
    let start = (script.led_on * rate).floor() / rate;
    let task = bench.progress.begin("dynamics", place, ((script.length - start) * rate).ceil() as usize);
    let pressures = |t: Second| [sides[0].at(t), sides[1].at(t)];
    let span = [start, script.length];
    let motion = physics::march(bench.body, span, rate, bench.profile.step, &pressures, &|| task.tick())?;
    task.done(&format!("{} shapes of {} unknowns", motion.shapes.len(), bench.body.system.freedoms()));
    Ok(Box::new(motion))
}

fn shoot(
    bench: &Bench,
    trial: &lab::card::Trial,
    motion: &dyn Motion,
    script: &Script,
    folder: &Path,
    place: &str,
) -> Result<(), Fault> {
    let camera = &bench.set.camera;
    let count = frames(bench, script);
    let set = bench.studio.set(trial.medium, &trial.id);
    let draw = |frame: usize| {
        let t = frame as f64 / camera.rate;
        let lit = script.lamp(t + set.lamp_late(), 0.5 * camera.exposure);
        let by = Passing::around(t, 1.0 / camera.rate, &|t| motion.nodes(t));
        let canvas = set.tail(bench.subject, &by, lit);
        bench.studio.expose(&canvas, &trial.id, frame)
    };
    let task = bench.progress.begin("film", place, count);
    film::shoot(&folder::prepared(folder, &trial.video)?, camera, count, &draw, &|| task.tick())?;
    task.done(&format!("{count} frames"));
    Ok(())
}

/// Where every mark truly is in every frame: in the picture as its rows were read, in space at the frame's own time.
fn true_tracks(
    bench: &Bench,
    trial: &lab::card::Trial,
    motion: &dyn Motion,
    script: &Script,
) -> Result<Vec<TrueTrack>, Fault> {
    let set = bench.studio.set(trial.medium, &trial.id);
    let named = |name: &String| TrueTrack { marker: name.clone(), ..TrueTrack::default() };
    let mut tracks: Vec<TrueTrack> = bench.marks.iter().map(named).collect();
    for frame in 0..frames(bench, script) {
        let t = frame as f64 / bench.set.camera.rate;
        let by = Passing::around(t, 1.0 / bench.set.camera.rate, &|t| motion.nodes(t));
        for (track, mark) in tracks.iter_mut().zip(&bench.subject.marks) {
            let seen = mark.seen(&set.view, &by).ok_or_else(|| {
                let what = format!("mark {} leaves the camera's sight at {t:.3} s", track.marker);
                Fault::new(bench.name, &what, "the lens does not reach there", "hang the camera higher in bench.toml")
            })?;
            track.time.push(t);
            track.pixel.push(seen);
            track.at.push(mark.at(by.now()));
        }
    }
    Ok(tracks)
}
