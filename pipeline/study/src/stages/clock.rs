//! Clock: the lamp lights in the film and in the log; its edges bring motion and pressure onto the video's clock.
//! Paper: section IV, synchronisation by an LED.
//!
//! Stands on: signal. Never knows: pixels, a mesh.

use std::path::Path as FilePath;

use lab::PressureLog;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use si::{Point2, Second, Series};
use signal::clock::Clock as Match;
use signal::edge::{self, Window};

use crate::fault::{Fault, Outcome};
use crate::records::{self, Gauge, Markers, Motion, Path, Tracks};
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
    type Needs = (Tracks, Markers);
    type Makes = Motion;
    const STORY: &'static str = "the lamp's edges bring film and logs onto one clock";
    const EDITION: u32 = 2;

    fn raw(of: &Trial) -> Vec<RawFile> {
        vec![RawFile::new("pressure", &of.card.name, &of.trial.pressure)]
    }

    fn card(of: &Trial) -> Value {
        json!({ "chambers": of.card.chamber.iter().map(|c| json!([c.name, c.log.word()])).collect::<Vec<_>>() })
    }

    fn run(of: &Trial, set: &Settings, (tracks, markers): Self::Needs, desk: &dyn Desk) -> Outcome<Motion> {
        let log = read_log(desk)?;
        let (clock, lamp) = match_clocks(&tracks, &log, set).map_err(|e| named(desk, &e))?;
        let log_time: Vec<Second> = log.time.iter().map(|&t| clock.here(t)).collect();
        let gauges: Vec<Gauge> = of.card.chamber.iter().map(|chamber| gauge(chamber, &log)).collect();
        let rest_frames = rest_frames(&markers.time, &log_time, &gauges, set, desk)?;
        let rest: Vec<Point2> = markers.markers.iter().map(|m| m.mean(0..rest_frames)).collect();
        let moved = markers.markers.iter().zip(&rest).map(|(path, rest)| displaced(path, *rest)).collect();
        let clock = records::Clock { offset: clock.offset, scale: clock.scale, lamp };
        Ok(Motion { time: markers.time, markers: moved, rest, gauges, log_time, clock })
    }
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

/// The video's clock against the log's, and when the lamp lights in the film.
fn match_clocks(tracks: &Tracks, log: &PressureLog, set: &Settings) -> Result<(Match, Second), String> {
    let frames = tracks.time.len();
    let span = tracks.time[frames - 1] - tracks.time[0];
    let rate = (frames - 1) as f64 / span;
    let film = Series::new(tracks.time[0], rate, tracks.led.clone()).map_err(|e| e.to_string())?;
    let in_film = edge::edges(&film, centred(set.exposure / rate));
    let in_film: Vec<Second> =
        in_film.map_err(|e| format!("the lamp in the film: {e}"))?.iter().map(|e| e.time).collect();
    let in_log = edge::edges(&log.series(&log.led), centred(set.log_mean / log.rate()));
    let in_log: Vec<Second> = in_log.map_err(|e| format!("the lamp in the log: {e}"))?.iter().map(|e| e.time).collect();
    let clock = Match::from_edges(&in_film, &in_log).map_err(|e| e.to_string())?;
    Ok((clock, in_film[0]))
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

fn displaced(path: &Path, rest: Point2) -> Path {
    let at = path.at.iter().map(|p| [p[0] - rest[0], p[1] - rest[1]]).collect();
    Path { at, ..path.clone() }
}

fn named(desk: &dyn Desk, error: &str) -> Fault {
    Fault::from_tool(format!("{} and its film do not meet: {error}", desk.place("pressure")))
}
