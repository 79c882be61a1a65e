//! Check of the side to which a body bends: a film that is mirrored about the body's own axis shows its markers at rest where they belong, and
//! their motion on the other side; so do channels that were exchanged.

use lab::card::Experiment;
use si::{Metre, Point2};
use track::Gray;
use track::klt::{Settings, Tracker};

use super::board::RoughCamera;
use super::finding::Finding;
use super::rest::marker_positions;
use records::subject::Trial;

/// Motion of a marker that shows the side, as a share of the specimen's length: far above what a tail sways when a valve opens.
const SHOWN: f64 = 0.03;

/// The motion of the markers of a staircase up to the frame in which it shows the side.
pub(crate) struct FirstMotion<'a> {
    subject: &'a Trial,
    camera: &'a RoughCamera,
    /// In the plane, from the mean of the chambers that are not filled to that of the filled, of length 1.
    towards_filled: Point2,
    rest: Vec<Point2>,
    tracker: Option<Tracker>,
    /// By how much the marker that moves most goes towards the filled chamber, m; none while it is too little.
    displacement: Option<(usize, Metre)>,
}

impl<'a> FirstMotion<'a> {
    /// From the first frame of a trial, in which the markers are at `pixels`; none of a trial that is no staircase, of a body without opposed
    /// chambers, and where there is no camera.
    pub(crate) fn begin(
        subject: &'a Trial,
        camera: Option<&'a RoughCamera>,
        (picture, pixels): (&Gray, &[Point2]),
        settings: Settings,
    ) -> Option<Self> {
        let (camera, towards_filled) = (camera?, direction_of_filled(subject)?);
        let rest = marker_positions(subject, pixels, camera).filter(|rest| !rest.is_empty())?;
        let tracker = Tracker::new(picture, pixels, settings).ok()?;
        Some(Self { subject, camera, towards_filled, rest, tracker: Some(tracker), displacement: None })
    }

    /// Follows the markers into the next frame; a marker that is lost ends it, and is the tracker's to report.
    pub(crate) fn follow(&mut self, picture: &Gray) {
        let Some(tracker) = &mut self.tracker else { return };
        let seen = tracker.step(picture).ok().filter(|seen| seen.iter().all(|observation| observation.seen));
        let pixels: Option<Vec<Point2>> = seen.map(|seen| seen.iter().map(|observation| observation.at).collect());
        let positions = pixels.and_then(|pixels| marker_positions(self.subject, &pixels, self.camera));
        self.displacement = positions.and_then(|positions| self.largest_displacement(&positions));
        if self.displacement.is_some() {
            self.tracker = None;
        }
    }

    /// The marker that moved most along the line of the chambers, where that is enough, and its displacement towards the filled one, m.
    fn largest_displacement(&self, positions: &[Point2]) -> Option<(usize, Metre)> {
        let [u, v] = self.towards_filled;
        // length: a place at rest for each marker
        let displacements =
            positions.iter().zip(&self.rest).map(|(now, rest)| u * (now[0] - rest[0]) + v * (now[1] - rest[1]));
        let largest = displacements.enumerate().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        largest.filter(|(_, displacement)| displacement.abs() > SHOWN * self.subject.card.length)
    }

    /// A body that bends towards the chamber that is filled. It is a note: a chamber may be made to contract.
    pub(crate) fn finding(&self, film_path: &str) -> Option<Finding> {
        let (marker, displacement) = self.displacement.filter(|(_, displacement)| *displacement > 0.0)?;
        let name = &self.subject.card.marker.get(marker)?.name;
        let channels = self.subject.trial.experiment.first_channels().join(" and ");
        let defect = format!(
            "{film_path}: marker `{name}` moves by {:.1} mm towards the side of {channels}",
            1e3 * displacement
        );
        let reason = format!("{channels} is filled, and a chamber that is filled lengthens its side of the body");
        let action = "check that the film is not mirrored against the calibration, and which chamber each channel fills on the card; else leave it";
        Some(Finding::note(defect, reason, action))
    }
}

/// The direction in the plane from the chambers that are not filled first to those that are; none where either is missing, or both are at one place.
fn direction_of_filled(subject: &Trial) -> Option<Point2> {
    let Experiment::Staircase { .. } = subject.trial.experiment else { return None };
    let filled_channels = subject.trial.experiment.first_channels();
    let (filled, others): (Vec<_>, Vec<_>) =
        subject.card.chamber.iter().partition(|chamber| filled_channels.contains(&chamber.channel));
    let mean = |chambers: &[&lab::card::Chamber], k: usize| {
        chambers.iter().map(|chamber| chamber.at[k]).sum::<Metre>() / chambers.len() as f64
    };
    let difference = [0, 1].map(|k| mean(&filled, k) - mean(&others, k));
    let distance = difference[0].hypot(difference[1]);
    (distance > 1e-6).then(|| difference.map(|d| d / distance))
}
