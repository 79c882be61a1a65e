//! Clock: the lamp lights in the film and in the log; its edges bring motion and pressure onto the video's clock.
//! Paper: section IV, synchronisation by an LED.
//!
//! Stands on: signal, the shutter of track. Never knows: pixels, a mesh.

use std::path::Path as FilePath;

use lab::PressureLog;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use si::{Point2, Second};
use signal::clock::Clock as Match;
use signal::edge::{self, Edge, Window};
use track::shutter::Shutter;

use crate::fault::{Fault, Outcome};
use crate::needs::Maybe;
use crate::records::{self, Camera, Gauge, Markers, Motion, Parts, Path, Spread, Tracks};
use crate::stage::{Desk, RawFile, Stage};
use crate::subject::Trial;

/// The stage.
pub struct Clock;

/// `[clock]` in `study.toml`.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// How long the shutter is open, as a part of the time between frames.
    exposure: f64,
    /// Over which part of its sampling interval the log's column of the lamp is a mean; 0 for an instant.
    log_mean: f64,
    /// Frames before the first command that count as rest, at least.
    rest_frames: usize,
}

impl Stage for Clock {
    type Settings = Settings;
    type Needs = (Maybe<Camera>, Tracks, Markers);
    type Makes = Motion;
    const STORY: &'static str = "the lamp's edges bring film and logs onto one clock";
    const EDITION: u32 = 3;

    fn raw(of: &Trial) -> Vec<RawFile> {
        vec![RawFile::new("pressure", &of.card.name, &of.trial.pressure)]
    }

    fn card(of: &Trial) -> Value {
        json!({
            "chambers": of.card.chamber.iter().map(|c| json!([c.name, c.log.word()])).collect::<Vec<_>>(),
            "lamp": [of.card.led.centre[1], of.card.camera.readout],
        })
    }

    fn run(
        of: &Trial,
        set: &Settings,
        (Maybe(camera), tracks, markers): Self::Needs,
        desk: &dyn Desk,
    ) -> Outcome<Motion> {
        let log = read_log(desk)?;
        let shutter = |c: Camera| Shutter { readout: of.card.camera.readout, height: c.size_px[1] };
        let late = camera.map_or(0.0, |c| shutter(c).late(of.card.led.centre[1]));
        let Met { clock, lamp, sigma, log_time, gauges } = met(of, &tracks, late, &log, set, desk)?;
        let rest_frames = rest_frames(&markers.time, &log_time, &gauges, set, desk)?;
        let rest: Vec<Point2> = markers.markers.iter().map(|m| m.mean(0..rest_frames)).collect();
        let paths = markers.markers.iter().zip(&markers.parts).zip(&rest);
        let moved = paths.map(|((path, parts), rest)| displaced(path, parts, *rest, rest_frames)).collect();
        let clock = records::Clock { offset: clock.offset, scale: clock.scale, lamp, sigma };
        Ok(Motion { time: markers.time, markers: moved, rest, gauges, log_time, clock })
    }
}

/// Film and log on the film's clock.
struct Met {
    clock: Match,
    lamp: Second,
    sigma: Second,
    log_time: Vec<Second>,
    gauges: Vec<Gauge>,
}

fn met(of: &Trial, tracks: &Tracks, late: Second, log: &PressureLog, set: &Settings, desk: &dyn Desk) -> Outcome<Met> {
    let (clock, lamp, sigma) = match_clocks(tracks, late, log, set).map_err(|e| named(desk, &e))?;
    let log_time = log.time.iter().map(|&t| clock.here(t)).collect();
    let gauges = of.card.chamber.iter().map(|chamber| gauge(chamber, log)).collect();
    Ok(Met { clock, lamp, sigma, log_time, gauges })
}

/// Whether a film's lamp, in pictures of `height` rows, and its log meet, with enough rest before the first command.
///
/// # Errors
/// A [`Fault`] that says which of the two has no edge, or what they disagree in.
pub(crate) fn meet(of: &Trial, set: &Settings, tracks: &Tracks, height: usize, desk: &dyn Desk) -> Outcome<()> {
    let late = Shutter { readout: of.card.camera.readout, height }.late(of.card.led.centre[1]);
    let met = met(of, tracks, late, &read_log(desk)?, set, desk)?;
    rest_frames(&tracks.time, &met.log_time, &met.gauges, set, desk).map(drop)
}

fn read_log(desk: &dyn Desk) -> Outcome<PressureLog> {
    let place = desk.place("pressure");
    let bytes = desk.bytes("pressure")?;
    let text = String::from_utf8(bytes)
        .map_err(|e| Fault::new(format!("{place} is not text"), e, "export the log as CSV in UTF-8"))?;
    lab::pressure::parse(&text, FilePath::new(&place)).map_err(Fault::from_tool)
}

fn gauge(chamber: &lab::card::Chamber, log: &PressureLog) -> Gauge {
    let channel = log.side(chamber.log);
    Gauge { chamber: chamber.name.clone(), command: channel.command.clone(), measured: channel.measured.clone() }
}

/// A sample whose time is the middle of what it collects.
fn centred(width: Second) -> Window {
    Window { lead: 0.5 * width, width }
}

/// The video's clock against the log's, when the lamp lights in the film, and the largest deviation of the clock in it; the
/// lamp's rows are read `late` s after a frame's time.
fn match_clocks(
    tracks: &Tracks,
    late: Second,
    log: &PressureLog,
    set: &Settings,
) -> Result<(Match, Second, Second), String> {
    let time: Vec<Second> = tracks.time.iter().map(|t| t + late).collect();
    let apart = time.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let in_film = edge::edges_at(&time, &tracks.led, |_| centred(set.exposure * apart));
    let in_film = in_film.map_err(|e| format!("the lamp in the film: {e}"))?;
    let in_log = edge::edges(&log.series(&log.led), centred(set.log_mean / log.rate()));
    let in_log = in_log.map_err(|e| format!("the lamp in the log: {e}"))?;
    let times = |edges: &[Edge]| -> Vec<Second> { edges.iter().map(|e| e.time).collect() };
    let here = times(&in_film);
    let clock = Match::from_edges(&here, &times(&in_log)).map_err(|e| e.to_string())?;
    let sigma: Vec<Second> = in_film.iter().zip(&in_log).map(|(a, b)| a.sigma.hypot(b.sigma)).collect();
    let most = [tracks.time[0], tracks.time[tracks.time.len() - 1]].map(|t| Match::sigma(&here, &sigma, t));
    Ok((clock, here[0], most[0].max(most[1])))
}

/// Frames before the first command of any chamber.
fn rest_frames(
    time: &[Second],
    log_time: &[Second],
    gauges: &[Gauge],
    set: &Settings,
    desk: &dyn Desk,
) -> Outcome<usize> {
    let asked = |i: &usize| gauges.iter().any(|g| g.command[*i] > 0.0);
    let first = (0..log_time.len()).find(asked).map_or(f64::INFINITY, |i| log_time[i]);
    let frames = time.iter().take_while(|&&t| t < first).count();
    if frames >= set.rest_frames {
        return Ok(frames);
    }
    Err(Fault::new(
        format!("{} commands pressure after {frames} frames of the film", desk.place("pressure")),
        format!("rest is known from at least {} frames (study.toml, [clock] rest_frames)", set.rest_frames),
        "let the film begin earlier, before the first command",
    ))
}

/// Displacements from the mean of the first frames, with the noise of both and the errors that grow with the displacement.
fn displaced(path: &Path, parts: &Parts, rest: Point2, rest_frames: usize) -> Path {
    let at = path.at.iter().map(|p| [p[0] - rest[0], p[1] - rest[1]]).collect();
    let share = 1.0 / (rest_frames * rest_frames) as f64;
    let of_rest: Spread = [0, 1, 2].map(|k| share * parts.noise[..rest_frames].iter().map(|s| s[k]).sum::<f64>());
    let whole = |(noise, shared): (&Spread, &Spread)| [0, 1, 2].map(|k| noise[k] + shared[k] + of_rest[k]);
    Path { name: path.name.clone(), at, spread: parts.noise.iter().zip(&parts.shared).map(whole).collect() }
}

fn named(desk: &dyn Desk, error: &str) -> Fault {
    Fault::from_tool(format!("{} and its film do not meet: {error}", desk.place("pressure")))
}
