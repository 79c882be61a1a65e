//! One trial: script → valve → body → film, logs and truth.
//!
//! Stands on: the physics, the studio, the logger, the load cell. Never knows: the other trials, where the folder will end up.

use std::path::Path;

use lab::card::{Experiment, Medium, Side};
use lab::truth::{TrueForce, TrueTrack, TrueTrial};
use serde::{Deserialize, Serialize};
use si::Second;

use crate::camera::Passing;
use crate::draw::Draw;
use crate::fault::Fault;
use crate::logger::{self, Clock};
use crate::physics::{Body, Conditions, Fluid, Ladder, Motion, Swimmer};
use crate::progress::Progress;
use crate::script::{self, Script};
use crate::settings::{Profile, Settings};
use crate::studio::{Studio, Subject};
use crate::valve::{Trace, Unrest, follow};
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
    /// Its shapes by pressure, left and right.
    pub ladders: &'a [Ladder; 2],
    /// The specimen in the coordinates in which it moves.
    pub swimmer: &'a Swimmer<'a>,
    /// The water that it moves in.
    pub fluid: Fluid,
    /// The camera and its surroundings.
    pub studio: &'a Studio,
    /// What is filmed.
    pub subject: &'a Subject,
    /// Names of the marks.
    pub marks: &'a [String],
    /// Where progress goes.
    pub progress: &'a Progress,
}

/// What is hidden in a trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hidden {
    /// Its clocks and causes.
    pub trial: TrueTrial,
    /// Its load cell, where there was one.
    pub force: Option<TrueForce>,
}

/// What is off in one run.
struct Causes {
    unrest: Unrest,
    softening: f64,
}

impl Causes {
    /// Staircases are taken in a room that has come to rest: the silicone is as warm as the reference.
    fn drawn(bench: &Bench, trial: &lab::card::Trial) -> Self {
        let (set, mut draw) = (&bench.set.causes, Draw::new(bench.seed, &format!("causes {}", trial.id)));
        let mut within = |most: f64| draw.between([-most, most]);
        let unrest = Unrest { supply: within(set.supply), jitter: set.jitter };
        let warmth = within(set.warmth);
        let moves = matches!(trial.experiment, Experiment::Flapping { .. });
        Self { unrest, softening: if moves { 1.0 + warmth } else { 1.0 } }
    }
}

/// Records one trial into `folder` and returns what was hidden in it.
///
/// # Errors
/// [`Fault`] when the body cannot be solved or the disk refuses.
pub fn record(bench: &Bench, trial: &lab::card::Trial, folder: &Path) -> Result<Hidden, Fault> {
    let place = format!("{}/{}", bench.name, trial.id);
    let task = bench.progress.begin("trial", &place, 1);
    let mut draw = Draw::new(bench.seed, &format!("trial {}", trial.id));
    let start = bench.profile.rest + draw.unit() / bench.set.camera.rate;
    let script = script::write(&trial.experiment, start, bench.profile.rest);
    let clock = Clock::drawn(&bench.set.log, &mut draw);
    let causes = Causes::drawn(bench, trial);
    let mut valves = Draw::new(bench.seed, &format!("valve {}", trial.id));
    let sides = [&script.left, &script.right].map(|c| follow(&bench.set.valve, c, causes.unrest, &mut valves));
    let motion = solve(bench, trial, &script, &sides, causes.softening).map_err(|e| Fault::at(&place, e))?;
    let log = logger::record(&bench.set.log, clock, &script, [&sides[0], &sides[1]], &mut draw);
    folder::write(folder, &trial.pressure, lab::pressure::write(&log, lab::VIRTUAL_BENCH).as_bytes())?;
    shoot(bench, trial, motion.as_ref(), &script, folder, &place)?;
    let tracks = format!("truth/{}.csv", trial.id);
    let seen = true_tracks(bench, trial, motion.as_ref(), &script)?;
    folder::write(folder, &tracks, lab::truth::write_tracks(&seen, lab::VIRTUAL_BENCH).as_bytes())?;
    let hidden = TrueTrial {
        id: trial.id.clone(),
        tracks,
        clock_offset: clock.offset,
        clock_scale: clock.scale,
        led_on: script.led_on,
        supply: causes.unrest.supply,
        softening: causes.softening,
        pose: Some(bench.studio.set(trial.medium, &trial.id).pose()),
    };
    let force = weighing::of_trial(bench, trial, motion.as_ref(), &script, &sides, folder)?;
    task.done(&format!("{} frames", frames(bench, &script)));
    Ok(Hidden { trial: hidden, force })
}

/// Frames of a trial.
fn frames(bench: &Bench, script: &Script) -> usize {
    (script.length * bench.set.camera.rate).ceil() as usize
}

/// The motion of the body under what the valve makes of the script.
fn solve<'a>(
    bench: &'a Bench,
    trial: &lab::card::Trial,
    script: &Script,
    sides: &[Trace; 2],
    softening: f64,
) -> Result<Box<dyn Motion + 'a>, Fault> {
    let swimmer = bench.swimmer;
    let fluid = (trial.medium == Medium::Water).then_some(bench.fluid);
    let (span, step) = ([script.led_on, script.length], bench.profile.step);
    match &trial.experiment {
        Experiment::Staircase { side, .. } => {
            let of = usize::from(*side == Side::Right);
            let (ladder, trace) = (&bench.ladders[of], sides[of].clone());
            Ok(Box::new(swimmer.stairs(*side, ladder, trace, span, step, fluid)?))
        }
        Experiment::Flapping { .. } => {
            let pressures = |t: Second| [sides[0].at(t), sides[1].at(t)];
            let conditions = Conditions { fluid, softening };
            Ok(Box::new(swimmer.flap(span, step, &pressures, &conditions)?))
        }
    }
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
    let of = bench.subject.nodes();
    let draw = |frame: usize| {
        let t = frame as f64 / camera.rate;
        let lit = script.lamp(t + set.lamp_late(), 0.5 * camera.exposure);
        let by = Passing::around(t, 1.0 / camera.rate, &|t| motion.seen(t, &of));
        let canvas = set.tail(bench.subject, &by, lit);
        bench.studio.expose(&canvas, &trial.id, frame)
    };
    film::shoot(&folder::prepared(folder, &trial.video)?, camera, count, &draw, &|| ()).map_err(|e| Fault::at(place, e))
}

/// Where every mark truly is in every frame: in the picture as its rows were read, in space at the frame's own time.
fn true_tracks(
    bench: &Bench,
    trial: &lab::card::Trial,
    motion: &dyn Motion,
    script: &Script,
) -> Result<Vec<TrueTrack>, Fault> {
    let set = bench.studio.set(trial.medium, &trial.id);
    let of = bench.subject.mark_nodes();
    let named = |name: &String| TrueTrack { marker: name.clone(), ..TrueTrack::default() };
    let mut tracks: Vec<TrueTrack> = bench.marks.iter().map(named).collect();
    for frame in 0..frames(bench, script) {
        let t = frame as f64 / bench.set.camera.rate;
        let by = Passing::around(t, 1.0 / bench.set.camera.rate, &|t| motion.seen(t, &of));
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
