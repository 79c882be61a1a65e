//! Marker tracking: dark crosses or discs on light ground, to a few hundredths of a pixel.
//!
//! Optical flow (pyramidal Lucas–Kanade) predicts where a marker is; the centroid of its darkness measures where it is. Flow alone
//! accumulates drift from frame to frame, a centroid has no memory. An observation must pass every gate (`gates`, `neighbours`), or
//! the marker counts as hidden. Where markers move by about as much as they lie apart, all are assigned to all dark spots at once
//! (`joint_matching`). A hidden marker is searched by correlation with its first view for at most `patience` frames; after
//! that it is an error that names the first hidden frame. A wrong position is never returned silently. Paper, section IV.

mod background;
pub(crate) mod blob;
mod covariance;
mod error;
mod find_blobs;
mod find_corners;
mod flow;
mod gaps;
mod gates;
mod joint_matching;
mod neighbours;
mod reacquisition;
mod settings;
mod spanning_tree;
mod template;

use crate::Gray;
pub use blob::clutter_share;
use error::Expected;
pub use error::{FailedGate, TrackingError};
pub use find_blobs::find_blobs;
pub use find_corners::find_corners;
use flow::SingleThread;
pub use gaps::fill_gaps;
use gates::matrix_sum;
pub use settings::Settings;
use si::{Point2, Radian};
use template::Template;

/// One marker in one frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observation {
    /// Its centre, px.
    pub at: Point2,
    /// Covariance of its centre, px².
    pub covariance: [[f64; 2]; 2],
    /// Mean difference from the marker of the first frame, grey levels a pixel.
    pub residual: f64,
    /// False while the marker is hidden: the other fields then hold its last observation, until [`fill_gaps`] replaces them.
    pub seen: bool,
}

/// Tracks markers from frame to frame.
pub struct Tracker {
    settings: Settings,
    before: Gray,
    frame: usize,
    tracks: Vec<Track>,
    observations: Vec<Observation>,
    single_thread: SingleThread,
}

/// State of one marker.
struct Track {
    template: Template,
    at: Point2,
    step: Point2,
    turn: Radian,
    /// Exponential mean of the covariance by sectors, px², from the second frame on.
    by_sectors: Option<[[f64; 2]; 2]>,
    /// Why and since which frame it is hidden.
    hidden: Option<TrackingError>,
}

/// One marker in the next frame, after all gates.
struct Accepted {
    observation: Observation,
    turn: Radian,
    by_sectors: [[f64; 2]; 2],
}

/// The least radius of a window, px.
pub const LEAST_RADIUS: f64 = 4.0;

impl Tracker {
    /// Begins with the first frame: each clicked position (px) is moved to the middle of the dark spot within reach.
    ///
    /// # Errors
    /// [`TrackingError`] at frame 0 when there is no dark spot within reach, the picture lacks grey levels, or the window's radius is
    /// under [`LEAST_RADIUS`]: no marker and its background fit into that.
    pub fn new(first: &Gray, clicked: &[Point2], settings: Settings) -> Result<Self, TrackingError> {
        let expected = Expected { marker: 0, frame: 0, near: clicked.first().copied().unwrap_or_default() };
        if !(settings.radius >= LEAST_RADIUS && settings.radius.is_finite()) {
            let why = FailedGate::SmallWindow { measured: settings.radius, limit: LEAST_RADIUS };
            return Err(TrackingError::with_crop(first, expected, why));
        }
        check_levels(first, expected)?;
        let (tracks, observations, single_thread) = (Vec::new(), Vec::new(), SingleThread::new());
        let mut new = Self { settings, before: first.clone(), frame: 0, tracks, observations, single_thread };
        for (marker, &near) in clicked.iter().enumerate() {
            let error = |why| TrackingError::with_crop(first, Expected { marker, frame: 0, near }, why);
            let blob = new.find_spot(first, near).map_err(error)?;
            let away = distance(blob.at, near);
            if away > settings.click_radius {
                return Err(error(FailedGate::FarFromClick { measured: away, limit: settings.click_radius }));
            }
            let template = Template::cut_window(first, &blob, settings.radius);
            let coded = covariance::at_least([[0.0; 2]; 2], covariance::of_codec(&blob, settings.quantiser));
            let covariance = matrix_sum(coded, covariance::of_pixels(&blob));
            let observation = Observation { at: blob.at, covariance, residual: 0.0, seen: true };
            let (at, step, hidden) = (blob.at, [0.0; 2], None);
            new.tracks.push(Track { template, at, step, turn: 0.0, by_sectors: None, hidden });
            new.observations.push(observation);
        }
        new.check_tracks_apart()?;
        Ok(new)
    }

    /// Where the markers are in the frame that was looked at last.
    pub fn observations(&self) -> &[Observation] {
        &self.observations
    }

    /// Looks at the next frame; one observation a marker, in the order of the clicks.
    ///
    /// # Errors
    /// [`TrackingError`] when the picture lacks grey levels, or a marker fails a gate for longer than the settings are patient, with the first frame in which it did.
    pub fn step(&mut self, picture: &Gray) -> Result<Vec<Observation>, TrackingError> {
        let frame = self.frame + 1;
        check_levels(
            picture,
            Expected { marker: 0, frame, near: self.tracks.first().map_or([0.0; 2], Track::expected_place) },
        )?;
        let mut results = self.single_thread.run(|| self.measure_markers(picture, frame));
        self.check_separation(picture, frame, &mut results);
        self.check_neighbours(picture, frame, &mut results);
        self.relocate(picture, &mut results);
        self.match_jointly(picture, frame, &mut results);
        self.reacquire_hidden(picture, frame, &mut results);
        for (track, results) in self.tracks.iter().zip(&results) {
            let Err(error) = results else { continue };
            let since = track.hidden.as_ref().unwrap_or(error);
            if frame - since.frame >= self.settings.patience {
                return Err(since.clone());
            }
        }
        self.frame = frame;
        let pairs = self.tracks.iter_mut().zip(&mut self.observations);
        pairs
            .zip(results)
            .for_each(|((track, observation), results)| track.take_observation(frame, results, observation));
        self.before.clone_from(picture);
        self.check_tracks_apart()?;
        Ok(self.observations.clone())
    }

    /// Every marker by itself, past its own gates; the error of one that is hidden already.
    fn measure_markers(&self, picture: &Gray, frame: usize) -> Vec<Result<Accepted, TrackingError>> {
        let look = |(marker, track): (usize, &Track)| {
            let near = track.expected_place();
            let error = |why| TrackingError::with_crop(picture, Expected { marker, frame, near }, why);
            track.hidden.clone().map_or_else(|| self.locate_marker(picture, track, near).map_err(error), Err)
        };
        self.tracks.iter().enumerate().map(look).collect()
    }

    /// Ends the film.
    ///
    /// # Errors
    /// [`TrackingError`] when a marker is hidden to its end.
    pub fn finish(self) -> Result<(), TrackingError> {
        self.tracks.into_iter().find_map(|track| track.hidden).map_or(Ok(()), Err)
    }
}

impl Track {
    /// Where it is expected in the next frame, px.
    fn expected_place(&self) -> Point2 {
        [self.at[0] + self.step[0], self.at[1] + self.step[1]]
    }

    /// Takes in what a frame showed of it.
    fn take_observation(
        &mut self,
        frame: usize,
        found: Result<Accepted, TrackingError>,
        observation: &mut Observation,
    ) {
        match found {
            Ok(seen) => {
                let point = seen.observation.at;
                let frames = self.hidden.take().map_or(1, |since| frame - since.frame + 1) as f64;
                self.step = [0, 1].map(|k| (point[k] - self.at[k]) / frames);
                (self.at, self.turn, self.by_sectors) = (point, seen.turn, Some(seen.by_sectors));
                *observation = seen.observation;
            }
            Err(error) => {
                self.hidden.get_or_insert(error);
                observation.seen = false;
            }
        }
    }
}

/// # Errors
/// [`TrackingError`] when a picture lacks grey levels.
fn check_levels(picture: &Gray, expected: Expected) -> Result<(), TrackingError> {
    let (width, height, levels) = (picture.width, picture.height, picture.pixels.len());
    let error = |_| TrackingError::with_crop(picture, expected, FailedGate::Levels { levels, width, height });
    picture.check().map_err(error)
}

fn distance(a: Point2, b: Point2) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
