//! Checks of films: readable to their end; brightness, length and frame rate; markers are visible.

use si::Point2;
use track::Gray;
use track::video::{Film, Frame, Info};
use track::{klt, led};

use super::board::RoughCamera;
use super::finding::Finding;
use super::{Look, rest};
use lab::card::Experiment;
use study::records::Tracks;
use study::stages::track::{Settings, Track, first_look, imported};
use study::subject::Trial;
use workflow::runner::inspection_context;
use workflow::stage::{Stage, StageContext};
use workflow::subject::Part;

/// A film decoded to its end: times and lamp, without markers; rows of a picture.
pub struct Seen {
    /// Times and lamp.
    pub tracks: Tracks,
    /// Rows.
    pub height: usize,
}

/// Least brightness of the lightest twentieth of a picture, of 255.
const LIGHT: u8 = 60;
/// A window wider by this factor should contain only a marker and light ground, except for this share.
const MARGIN: f64 = 1.3;
const BESIDE: f64 = 0.03;
/// Least change of brightness of a lamp that lights, of 255.
const LAMP: f64 = 10.0;
/// Least number of frames a cycle.
const FRAMES_A_CYCLE: f64 = 8.0;

/// The film of a trial where it can be read to its end, and the findings on it.
pub fn trial(look: &Look, of: &Trial, set: &Settings, camera: Option<&RoughCamera>) -> (Option<Seen>, Vec<Finding>) {
    let raw = Track::raw(of);
    let context = inspection_context(look.folders, &raw);
    if !of.trial.video.as_ref().is_some_and(|video| look.path(&of.card.name, video).exists()) {
        return (None, Vec::new());
    }
    match context.path("video").and_then(|path| Ok(Film::open(&path)?)) {
        Err(diagnostic) => (None, vec![diagnostic.into()]),
        Ok(film) => {
            let info = film.info();
            watched(film, &FirstFrame { of, set, info: &info, context: &context, camera })
        }
    }
}

fn watched(film: Film, check: &FirstFrame) -> (Option<Seen>, Vec<Finding>) {
    let FirstFrame { of, set, info, context, camera } = *check;
    let place = context.display_path("video");
    let mut found = fitting(&place, info, of);
    found.extend(camera.and_then(|camera| rest::size(&place, info, camera)));
    let mut tracks = Tracks { time: Vec::new(), led: Vec::new(), worst_residual: 0.0, markers: Vec::new() };
    let (first, last) = (of.trial.first_frame, of.trial.last_frame.unwrap_or(usize::MAX));
    for frame in film {
        let frame = match frame {
            Ok(frame) => frame,
            Err(e) => {
                found.push(Finding::message(&e.to_string()));
                return (None, found);
            }
        };
        if frame.index == first {
            found.extend(check.findings(&frame));
        }
        if (first..=last).contains(&frame.index) {
            tracks.time.push(frame.time);
            tracks.led.extend(of.card.led.iter().map(|lamp| led::brightness(&frame.gray, lamp.centre, lamp.radius)));
        }
    }
    if tracks.time.len() < 2 {
        let what = format!("{place} has {} frames to use", tracks.time.len());
        let why = format!("it has {}, and the card lets the trial begin at frame {first}", info.frames);
        found.push(Finding::fix(what, why, "correct first_frame and last_frame of this trial on the card"));
        return (None, found);
    }
    let imported = imported(&Part::part_of(of), set.tracker(info.rate), tracks.time.len(), context);
    match imported {
        Err(diagnostic) => found.push(diagnostic.into()),
        Ok(paths) => {
            let first: Vec<Point2> = paths.iter().filter_map(|path| path.at.first().copied()).collect();
            found.extend(camera.and_then(|camera| rest::places(&place, of, &first, camera)));
        }
    }
    let unlit = unlit(&place, &tracks.led);
    let seen = unlit.is_none().then_some(Seen { tracks, height: info.height });
    found.extend(unlit);
    (seen, found)
}

/// A lamp whose brightness hardly changes in the film: it gives no clock.
fn unlit(place: &str, led: &[f64]) -> Option<Finding> {
    let (low, high) = led.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), &v| (low.min(v), high.max(v)));
    (high - low < LAMP).then(|| {
        let what = format!("{place}: the lamp does not light: its disc stays between {low:.1} and {high:.1} of 255");
        let why = format!("a lamp that lights changes by {LAMP} at least");
        let act =
            "check centre and radius under [led] on the card, and that film and lamp were both on when the trial began";
        Finding::fix(what, why, act)
    })
}

/// Length, rate and size against the card.
fn fitting(place: &str, info: &Info, of: &Trial) -> Vec<Finding> {
    let mut found = Vec::new();
    let (lasts, wanted) = (info.frames as f64 / info.rate, of.trial.experiment.duration());
    if lasts < wanted {
        let why = format!("the trial on the card lasts {wanted:.2} s");
        let act = "correct the trial on the card, or record the film again at its true rate";
        found.push(Finding::fix(format!("{place} lasts {lasts:.2} s ({} frames)", info.frames), why, act));
    }
    if let Experiment::Flapping { frequency, .. } = of.trial.experiment
        && info.rate < FRAMES_A_CYCLE * frequency
    {
        let what = format!("{place} has {:.1} frames a second, {:.1} a cycle", info.rate, info.rate / frequency);
        found.push(Finding::fix(what, format!("{FRAMES_A_CYCLE} a cycle are needed"), "film faster, or flap slower"));
    }
    if let Some([u, v]) = of.card.led.as_ref().map(|led| led.centre)
        && (u > info.width as f64 - 1.0 || v > info.height as f64 - 1.0)
    {
        let what = format!("{place}: the lamp at ({u}, {v}) px is out of the picture");
        let why = format!("pictures are {} × {} px", info.width, info.height);
        found.push(Finding::fix(what, why, "correct centre under [led] on the card, or film with the lamp in view"));
    }
    found
}

/// The check of the first frame of a trial.
#[derive(Clone, Copy)]
struct FirstFrame<'a> {
    of: &'a Trial,
    set: &'a Settings,
    /// Of its film.
    info: &'a Info,
    context: &'a dyn StageContext,
    camera: Option<&'a RoughCamera>,
}

impl FirstFrame<'_> {
    /// Brightness and markers in the first frame.
    fn findings(&self, frame: &Frame) -> Vec<Finding> {
        let Self { of, set, info, context, camera } = *self;
        let place = context.display_path("video");
        let light = lightest(&frame.gray);
        if light < LIGHT {
            let what = format!("{place} is dark: its lightest twentieth begins at {light} of 255");
            let act = "light the scene evenly, open the aperture, and record again";
            let why = format!("the least is {LIGHT}; markers are detected by their contrast");
            return vec![Finding::fix(what, why, act)];
        }
        let outside = |at: &Point2| at[0] > info.width as f64 - 1.0 || at[1] > info.height as f64 - 1.0;
        let clicked = of.card.marker.iter().filter(|_| of.made_elsewhere().is_none());
        let lost = clicked.filter_map(|m| Some((&m.name, m.clicked.filter(outside)?)));
        let out: Vec<Finding> = lost.map(|(name, at)| out_of_view(&place, name, at, info)).collect();
        if !out.is_empty() {
            return out;
        }
        match first_look(&Part::part_of(of), set.tracker(info.rate), frame, context) {
            Err(diagnostic) => vec![diagnostic.into()],
            Ok(places) => {
                let astray = camera.and_then(|camera| rest::places(&place, of, &places, camera));
                self.at_edges(&places, &frame.gray).into_iter().chain(astray).collect()
            }
        }
    }

    /// Markers beside another dark region, which would bias their centroid when the body moves.
    fn at_edges(&self, marks: &[Point2], picture: &Gray) -> Vec<Finding> {
        let (place, radius) = (self.context.display_path("video"), MARGIN * self.set.radius());
        let beside =
            self.of.card.marker.iter().zip(marks).map(|(marker, at)| (marker, klt::clutter(picture, *at, radius)));
        let evaluated = beside.filter(|(_, share)| *share > BESIDE).map(|(marker, share)| {
            let what = format!(
                "{place}: {:.0} % of the pixels within {radius:.0} px of marker `{}` are dark and not its own",
                100.0 * share,
                marker.name
            );
            let why = format!(
                "the limit is {:.0} %; as the body moves they enter the marker's window of {:.0} px",
                100.0 * BESIDE,
                radius / MARGIN
            );
            Finding::note(
                what,
                why,
                "put the marker farther from the body's edge, or lower radius under [track] in study.toml",
            )
        });
        evaluated.collect()
    }
}

fn out_of_view(place: &str, name: &str, [u, v]: Point2, info: &Info) -> Finding {
    let what = format!("{place}: marker `{name}` at ({u}, {v}) px is out of the picture");
    let why = format!("pictures are {} × {} px", info.width, info.height);
    Finding::fix(what, why, "click it in the first frame of this film, or film with every marker in view")
}

/// The 95 % quantile of the grey levels of a picture.
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
