//! Checks of films: readable to their end; brightness, length and frame rate; markers are visible.

use si::Point2;
use track::Gray;
use track::video::{Film, Frame, Info};
use track::{klt, led};

use super::board::RoughCamera;
use super::finding::Finding;
use super::side::FirstMotion;
use super::{Project, rest};
use lab::card::Experiment;
use records::Tracks;
use records::subject::Trial;
use study::stages::track::{Settings, Track, first_look, imported_paths};
use workflow::runner::inspection_context;
use workflow::stage::{Stage, StageContext};
use workflow::subject::Part;

/// A film decoded to its end: times and lamp, without markers; rows of a picture.
pub struct DecodedFilm {
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
pub(crate) fn film_findings(
    project: &Project,
    subject: &Trial,
    settings: &Settings,
    camera: Option<&RoughCamera>,
) -> (Option<DecodedFilm>, Vec<Finding>) {
    let raw = Track::raw(subject);
    let context = inspection_context(project.folders, &raw);
    if !subject.trial.video.as_ref().is_some_and(|video| project.file_path(&subject.card.name, video).exists()) {
        return (None, Vec::new());
    }
    match context.path("video").and_then(|path| Ok(Film::open(&path)?)) {
        Err(diagnostic) => (None, vec![diagnostic.into()]),
        Ok(film) => {
            let info = film.info();
            decode_film(film, &FirstFrame { subject, settings, info: &info, context: &context, camera })
        }
    }
}

fn decode_film(film: Film, check: &FirstFrame) -> (Option<DecodedFilm>, Vec<Finding>) {
    let FirstFrame { subject, settings, info, context, camera } = *check;
    let film_path = context.display_path("video");
    let mut findings = card_mismatches(&film_path, info, subject);
    findings.extend(camera.and_then(|camera| rest::size_mismatch(&film_path, info, camera)));
    let Some(tracks) = read_frames(film, check, &mut findings) else { return (None, findings) };
    if tracks.time.len() < 2 {
        let defect = format!("{film_path} has {} frames to use", tracks.time.len());
        let first = subject.trial.first_frame;
        let reason = format!("it has {}, and the card lets the trial begin at frame {first}", info.frames);
        findings.push(Finding::fix(defect, reason, "correct first_frame and last_frame of this trial on the card"));
        return (None, findings);
    }
    let imported = imported_paths(&Part::part_of(subject), settings.tracker(info.rate), tracks.time.len(), context);
    match imported {
        Err(diagnostic) => findings.push(diagnostic.into()),
        Ok(paths) => {
            let first: Vec<Point2> = paths.iter().filter_map(|path| path.at.first().copied()).collect();
            findings.extend(camera.and_then(|camera| rest::displaced_marker(&film_path, subject, &first, camera)));
        }
    }
    let dark_lamp = unlit_lamp(&film_path, &tracks.led);
    let decoded = dark_lamp.is_none().then_some(DecodedFilm { tracks, height: info.height });
    findings.extend(dark_lamp);
    (decoded, findings)
}

/// Times and lamp of the trial's frames; none where one cannot be decoded, which is then the last of the `findings`.
fn read_frames(film: Film, check: &FirstFrame, findings: &mut Vec<Finding>) -> Option<Tracks> {
    let subject = check.subject;
    let mut tracks = Tracks { time: Vec::new(), led: Vec::new(), worst_residual: 0.0, markers: Vec::new() };
    let (first, last) = (subject.trial.first_frame, subject.trial.last_frame.unwrap_or(usize::MAX));
    let mut motion: Option<FirstMotion> = None;
    for frame in film {
        let frame = match frame {
            Ok(frame) => frame,
            Err(e) => {
                findings.push(Finding::message(&e.to_string()));
                return None;
            }
        };
        if frame.index == first {
            let (seen, in_frame) = check.frame_findings(&frame);
            findings.extend(in_frame);
            let settings = check.settings.tracker(check.info.rate);
            motion =
                seen.and_then(|pixels| FirstMotion::begin(subject, check.camera, (&frame.gray, &pixels), settings));
        } else if let Some(motion) = &mut motion {
            motion.follow(&frame.gray);
        }
        if (first..=last).contains(&frame.index) {
            tracks.time.push(frame.time);
            tracks
                .led
                .extend(subject.card.led.iter().map(|lamp| led::brightness(&frame.gray, lamp.centre, lamp.radius)));
        }
    }
    findings.extend(motion.and_then(|motion| motion.finding(&check.context.display_path("video"))));
    Some(tracks)
}

/// A lamp whose brightness hardly changes in the film: it gives no clock.
fn unlit_lamp(film_path: &str, led: &[f64]) -> Option<Finding> {
    let (low, high) = led.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), &v| (low.min(v), high.max(v)));
    (high - low < LAMP).then(|| {
        let defect =
            format!("{film_path}: the lamp does not light: its disc stays between {low:.1} and {high:.1} of 255");
        let reason = format!("a lamp that lights changes by {LAMP} at least");
        let action =
            "check centre and radius under [led] on the card, and that film and lamp were both on when the trial began";
        Finding::fix(defect, reason, action)
    })
}

/// Length, rate and size against the card.
fn card_mismatches(film_path: &str, info: &Info, subject: &Trial) -> Vec<Finding> {
    let mut findings = Vec::new();
    let (duration, required) = (info.frames as f64 / info.rate, subject.trial.experiment.duration());
    if duration < required {
        let reason = format!("the trial on the card lasts {required:.2} s");
        let action = "correct the trial on the card, or record the film again at its true rate";
        findings.push(Finding::fix(
            format!("{film_path} lasts {duration:.2} s ({} frames)", info.frames),
            reason,
            action,
        ));
    }
    if let Experiment::Flapping { frequency, .. } = subject.trial.experiment
        && info.rate < FRAMES_A_CYCLE * frequency
    {
        let defect = format!("{film_path} has {:.1} frames a second, {:.1} a cycle", info.rate, info.rate / frequency);
        findings.push(Finding::fix(
            defect,
            format!("{FRAMES_A_CYCLE} a cycle are needed"),
            "film faster, or flap slower",
        ));
    }
    if let Some([u, v]) = subject.card.led.as_ref().map(|led| led.centre)
        && (u > info.width as f64 - 1.0 || v > info.height as f64 - 1.0)
    {
        let defect = format!("{film_path}: the lamp at ({u}, {v}) px is out of the picture");
        let reason = format!("pictures are {} × {} px", info.width, info.height);
        findings.push(Finding::fix(
            defect,
            reason,
            "correct centre under [led] on the card, or film with the lamp in view",
        ));
    }
    findings
}

/// The check of the first frame of a trial.
#[derive(Clone, Copy)]
struct FirstFrame<'a> {
    subject: &'a Trial,
    settings: &'a Settings,
    /// Of its film.
    info: &'a Info,
    context: &'a dyn StageContext,
    camera: Option<&'a RoughCamera>,
}

impl FirstFrame<'_> {
    /// The markers in the first frame, px, where they are found, and the findings on its brightness and on them.
    fn frame_findings(&self, frame: &Frame) -> (Option<Vec<Point2>>, Vec<Finding>) {
        let Self { subject, settings, info, context, camera } = *self;
        let film_path = context.display_path("video");
        let quantile = light_quantile(&frame.gray);
        if quantile < LIGHT {
            let defect = format!("{film_path} is dark: its lightest twentieth begins at {quantile} of 255");
            let action = "light the scene evenly, open the aperture, and record again";
            let reason = format!("the least is {LIGHT}; markers are detected by their contrast");
            return (None, vec![Finding::fix(defect, reason, action)]);
        }
        let is_outside =
            |position: &Point2| position[0] > info.width as f64 - 1.0 || position[1] > info.height as f64 - 1.0;
        let clicked = subject.card.marker.iter().filter(|_| subject.made_elsewhere().is_none());
        let hidden = clicked.filter_map(|m| Some((&m.name, m.clicked.filter(is_outside)?)));
        let unseen: Vec<Finding> =
            hidden.map(|(name, position)| out_of_view(&film_path, name, position, info)).collect();
        if !unseen.is_empty() {
            return (None, unseen);
        }
        match first_look(&Part::part_of(subject), settings.tracker(info.rate), frame, context) {
            Err(diagnostic) => (None, vec![diagnostic.into()]),
            Ok(positions) => {
                let displaced =
                    camera.and_then(|camera| rest::displaced_marker(&film_path, subject, &positions, camera));
                let findings = self.dark_neighbours(&positions, &frame.gray).into_iter().chain(displaced).collect();
                (Some(positions), findings)
            }
        }
    }

    /// Markers beside another dark region, which would bias their centroid when the body moves.
    fn dark_neighbours(&self, marks: &[Point2], picture: &Gray) -> Vec<Finding> {
        let (film_path, radius) = (self.context.display_path("video"), MARGIN * self.settings.radius());
        let clutter = self
            .subject
            .card
            .marker
            .iter()
            .zip(marks)
            .map(|(marker, position)| (marker, klt::clutter_share(picture, *position, radius)));
        let findings = clutter.filter(|(_, share)| *share > BESIDE).map(|(marker, share)| {
            let defect = format!(
                "{film_path}: {:.0} % of the pixels within {radius:.0} px of marker `{}` are dark and not its own",
                100.0 * share,
                marker.name
            );
            let reason = format!(
                "the limit is {:.0} %; as the body moves they enter the marker's window of {:.0} px",
                100.0 * BESIDE,
                radius / MARGIN
            );
            Finding::note(
                defect,
                reason,
                "put the marker farther from the body's edge, or lower radius under [track] in study.toml",
            )
        });
        findings.collect()
    }
}

fn out_of_view(film_path: &str, name: &str, [u, v]: Point2, info: &Info) -> Finding {
    let defect = format!("{film_path}: marker `{name}` at ({u}, {v}) px is out of the picture");
    let reason = format!("pictures are {} × {} px", info.width, info.height);
    Finding::fix(defect, reason, "click it in the first frame of this film, or film with every marker in view")
}

/// The 95 % quantile of the grey levels of a picture.
fn light_quantile(picture: &Gray) -> u8 {
    let mut counts = [0_usize; 256];
    picture.pixels.iter().for_each(|p| counts[usize::from(*p)] += 1);
    let mut remaining = picture.pixels.len() / 20;
    let mut level = 255;
    while level > 0 && counts[level] <= remaining {
        remaining -= counts[level];
        level -= 1;
    }
    level as u8
}
