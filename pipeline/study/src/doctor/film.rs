//! Films: readable to their end, light, long and fast enough; the marks are in sight, and so is the board.
//!
//! Stands on: track, the stages track and camera. Never knows: a log.

use si::Point2;
use track::Gray;
use track::video::{Film, Frame, Info};
use track::{klt, led};

use super::finding::Finding;
use super::{Look, log};
use crate::records::Tracks;
use crate::runner;
use crate::stage::{Desk, Stage};
use crate::stages::camera::{Camera, target};
use crate::stages::track::{Settings, Track, first_look};
use crate::subject::{Specimen, Trial};
use lab::card::Experiment;

/// A film that was seen to its end: times and lamp, without marks; rows of a picture.
pub struct Seen {
    /// Times and lamp.
    pub tracks: Tracks,
    /// Rows.
    pub height: usize,
}

/// A twentieth of a picture must be at least so light, of 255.
const LIGHT: u8 = 60;
/// A window so many times as wide should still hold a mark and light ground alone, but for this share.
const MARGIN: f64 = 1.3;
const BESIDE: f64 = 0.03;
/// A lamp that lights is at least so much lighter than before, of 255.
const LAMP: f64 = 10.0;
/// Frames a beat below which a motion cannot be told.
const FRAMES_A_BEAT: f64 = 8.0;

/// The film of a trial where it can be read to its end, and what was found in it.
pub fn trial(look: &Look, of: &Trial, set: &Settings) -> (Option<Seen>, Vec<Finding>) {
    let raw = Track::raw(of);
    let desk = runner::desk(look.folders, &raw);
    if !look.path(&of.card.name, &of.trial.video).exists() {
        return (None, Vec::new());
    }
    match desk.film("video") {
        Err(fault) => (None, vec![fault.into()]),
        Ok(film) => watched(film, of, set, &desk),
    }
}

fn watched(film: Film, of: &Trial, set: &Settings, desk: &dyn Desk) -> (Option<Seen>, Vec<Finding>) {
    let (info, place, lamp) = (film.info(), desk.place("video"), &of.card.led);
    let mut found = fitting(&place, &info, of);
    let mut tracks = Tracks { time: Vec::new(), led: Vec::new(), worst_residual: 0.0, markers: Vec::new() };
    let (first, last) = (of.trial.first_frame, of.trial.last_frame.unwrap_or(usize::MAX));
    for frame in film {
        let frame = match frame {
            Ok(frame) => frame,
            Err(e) => {
                found.push(Finding::said(&e.to_string()));
                return (None, found);
            }
        };
        if frame.index == first {
            found.extend(at_first(&frame, &info, of, set, desk));
        }
        if (first..=last).contains(&frame.index) {
            tracks.time.push(frame.time);
            tracks.led.push(led::brightness(&frame.gray, lamp.centre, lamp.radius));
        }
    }
    if tracks.time.len() < 2 {
        let what = format!("{place} has {} frames to use", tracks.time.len());
        let why = format!("it has {}, and the card lets the trial begin at frame {first}", info.frames);
        found.push(Finding::mend(what, why, "correct first_frame and last_frame of this trial on the card"));
        return (None, found);
    }
    let unlit = unlit(&place, &tracks.led);
    let seen = unlit.is_none().then_some(Seen { tracks, height: info.height });
    found.extend(unlit);
    (seen, found)
}

/// A lamp whose disc hardly changes through the film: no clock can be read from it.
fn unlit(place: &str, led: &[f64]) -> Option<Finding> {
    let (low, high) = led.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), &v| (low.min(v), high.max(v)));
    (high - low < LAMP).then(|| {
        let what =
            format!("{place}: the lamp is not seen to light: its disc stays between {low:.1} and {high:.1} of 255");
        let why = format!("a lamp that lights changes by {LAMP} at least");
        let act =
            "check centre and radius under [led] on the card, and that film and lamp were both on when the trial began";
        Finding::mend(what, why, act)
    })
}

/// Length, rate and size against the card.
fn fitting(place: &str, info: &Info, of: &Trial) -> Vec<Finding> {
    let mut found = Vec::new();
    let (lasts, wanted) = (info.frames as f64 / info.rate, log::span(&of.trial.experiment));
    if lasts < wanted {
        let why = format!("what the card says was done lasts {wanted:.2} s");
        let act = "correct the trial on the card, or record the film again at its true rate";
        found.push(Finding::mend(format!("{place} lasts {lasts:.2} s ({} frames)", info.frames), why, act));
    }
    if let Experiment::Flapping { frequency, .. } = of.trial.experiment
        && info.rate < FRAMES_A_BEAT * frequency
    {
        let what = format!("{place} has {:.1} frames a second, {:.1} a beat", info.rate, info.rate / frequency);
        found.push(Finding::mend(what, format!("{FRAMES_A_BEAT} a beat are needed"), "film faster, or flap slower"));
    }
    let [u, v] = of.card.led.centre;
    if u > info.width as f64 - 1.0 || v > info.height as f64 - 1.0 {
        let what = format!("{place}: the lamp at ({u}, {v}) px is out of the picture");
        let why = format!("pictures are {} × {} px", info.width, info.height);
        found.push(Finding::mend(what, why, "correct centre under [led] on the card, or film with the lamp in view"));
    }
    found
}

/// Light and marks in the first frame.
fn at_first(frame: &Frame, info: &Info, of: &Trial, set: &Settings, desk: &dyn Desk) -> Vec<Finding> {
    let light = lightest(&frame.gray);
    if light < LIGHT {
        let what = format!("{} is dark: its lightest twentieth begins at {light} of 255", desk.place("video"));
        let act = "light the scene evenly, open the aperture, and record again";
        return vec![Finding::mend(what, format!("{LIGHT} is the least; marks are found by their contrast"), act)];
    }
    let outside = |at: &Point2| at[0] > info.width as f64 - 1.0 || at[1] > info.height as f64 - 1.0;
    let clicked = of.card.marker.iter().filter(|_| of.made_elsewhere().is_none());
    let lost = clicked.filter_map(|m| Some((&m.name, m.clicked.filter(outside)?)));
    let out: Vec<Finding> = lost.map(|(name, at)| out_of_view(&desk.place("video"), name, at, info)).collect();
    if !out.is_empty() {
        return out;
    }
    match first_look(of, set, frame, info.rate, desk) {
        Err(fault) => vec![fault.into()],
        Ok(places) => at_edges(&desk.place("video"), of, &places, &frame.gray, MARGIN * set.radius()),
    }
}

/// Marks beside something else that is dark, which will pull at their middle once the body moves.
fn at_edges(place: &str, of: &Trial, marks: &[Point2], picture: &Gray, radius: f64) -> Vec<Finding> {
    let beside = of.card.marker.iter().zip(marks).map(|(marker, at)| (marker, klt::beside(picture, *at, radius)));
    let told = beside.filter(|(_, share)| *share > BESIDE).map(|(marker, share)| {
        let what = format!(
            "{place}: {:.0} % of what lies within {radius:.0} px of marker `{}` is dark and not its own",
            100.0 * share,
            marker.name
        );
        let why = format!(
            "{:.0} % is the most; as the body moves it comes into the mark's window of {:.0} px",
            100.0 * BESIDE,
            radius / MARGIN
        );
        Finding::note(
            what,
            why,
            "put the mark farther from the body's edge, or lower radius under [track] in study.toml",
        )
    });
    told.collect()
}

fn out_of_view(place: &str, name: &str, [u, v]: Point2, info: &Info) -> Finding {
    let what = format!("{place}: marker `{name}` at ({u}, {v}) px is out of the picture");
    let why = format!("pictures are {} × {} px", info.width, info.height);
    Finding::mend(what, why, "click it in the first frame of this film, or film with every mark in view")
}

/// The level above which a twentieth of a picture lies.
fn lightest(picture: &Gray) -> u8 {
    let mut counts = [0_usize; 256];
    picture.pixels.iter().for_each(|p| counts[usize::from(*p)] += 1);
    let mut left = picture.pixels.len() / 20;
    let mut level = 255;
    while level > 0 && counts[level] <= left {
        left -= counts[level];
        level -= 1;
    }
    level as u8
}

/// The film of the board: long enough, and the board is seen while it lies on the plane. Needed where a trial has a lens.
pub fn calibration(look: &Look, of: &Specimen) -> Vec<Finding> {
    let camera = &of.card.camera;
    let there = look.path(&of.card.name, &camera.calibration).exists();
    if !there || of.trials().iter().all(|trial| trial.in_space().is_some()) {
        return Vec::new();
    }
    let raw = Camera::raw(of);
    let desk = runner::desk(look.folders, &raw);
    board(of, &desk).err().into_iter().collect()
}

fn board(of: &Specimen, desk: &dyn Desk) -> Result<(), Finding> {
    let [from, to] = of.card.camera.plane.seconds;
    let (film, place) = (desk.film("calibration")?, desk.place("calibration"));
    let info = film.info();
    let lasts = info.frames as f64 / info.rate;
    if lasts < from {
        let why = format!("the card says that the board lies on the plane from {from} to {to} s");
        let act = "correct seconds under [camera.plane] on the card";
        return Err(Finding::mend(format!("{place} lasts {lasts:.2} s"), why, act));
    }
    let finder = target(&of.card.camera.board);
    let mut said = String::from("no frame lies there");
    for frame in film {
        let frame = frame.map_err(|e| Finding::said(&e.to_string()))?;
        if !(from..=to).contains(&frame.time) {
            continue;
        }
        match finder.find(&frame.gray) {
            Ok(_) => return Ok(()),
            Err(e) => said = e.to_string(),
        }
    }
    let why = said.replace("\n  why:", ";").replace("\n  do:", "; do:");
    let act = "check columns, rows and seconds on the card, or film the board again, whole and sharp";
    Err(Finding::mend(format!("{place} shows no board between {from} and {to} s"), why, act))
}
