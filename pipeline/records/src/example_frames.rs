//! ExampleFrames: two frames of one film, the tail at rest and under constant pressure, with the markers in them; dent and bulge of its silhouette at
//! every held pressure.

use serde::{Deserialize, Serialize};
use si::{Pascal, Point2, Point3, Second};
use track::Gray;

use crate::subject::Trial;
use mesh::wall::{Walls, steepest_rise};
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// Two frames of a film.
#[derive(Debug, Clone, PartialEq)]
pub struct ExampleFrames {
    /// The first frame that is used: the tail at rest.
    pub rest: Gray,
    /// The tail under pressure.
    pub held: Gray,
    /// Measurements in both frames.
    pub seen: FrameData,
}

/// Measurements in the frames.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrameData {
    /// When the frame under pressure was taken, s on the video's clock.
    pub time_s: Second,
    /// Commanded pressure there, Pa.
    pub command_pa: Pascal,
    /// Measured pressures in the order of the card's chambers, Pa.
    pub pressures_pa: Vec<Pascal>,
    /// The markers at rest, px.
    pub rest_px: Vec<Point2>,
    /// The markers under pressure, px.
    pub held_px: Vec<Point2>,
    /// Pixels per metre at the markers' height.
    pub px_per_m: f64,
    /// The part of the picture in which the tail moves: left, top, right, bottom, px.
    pub window_px: [usize; 4],
    /// The camera's place, m.
    pub eye_m: Point3,
    /// The held pressures in the order of the film, Pa, each with dent and bulge of the silhouette against that at rest.
    pub walls: Vec<(Pascal, Walls)>,
}

impl FrameData {
    /// Walls of the silhouette in the frame under pressure.
    pub fn shown_walls(&self) -> Option<Walls> {
        let pressure = self.pressures_pa.iter().copied().fold(0.0, f64::max);
        self.walls.iter().find(|(level, _)| *level == pressure).map(|(_, walls)| *walls)
    }

    /// The held pressures between which the slack wall buckles, Pa; none where it hardly dents.
    pub fn buckling_pressures(&self) -> Option<[Pascal; 2]> {
        let (pressures, dents): (Vec<Pascal>, Vec<f64>) = self.walls.iter().map(|(p, w)| (*p, w.dent_m)).unzip();
        steepest_rise(&pressures, &dents).map(|i| [pressures[i], pressures[i + 1]])
    }
}

impl Record for ExampleFrames {
    type Of = Trial;
    const STAGE: &'static str = "example_frames";

    fn is_made_for(trial: &Trial) -> bool {
        trial.in_space().is_none()
            && trial.card.highest_staircase_in_air().is_some_and(|highest| highest.id == trial.trial.id)
    }

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        let png = |name: &str, picture: &Gray| {
            picture.to_png().map_err(|e| RecordError::Scalars { file: name.into(), cause: e.to_string() })
        };
        RecordFiles::default()
            .file(REST, png(REST, &self.rest)?)
            .file(HELD, png(HELD, &self.held)?)
            .scalars("frames.json", &self.seen)
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
        let picture = |name: &str| {
            Gray::from_png(files.bytes(name)?)
                .map_err(|e| RecordError::Scalars { file: name.into(), cause: e.to_string() })
        };
        Ok(Self { rest: picture(REST)?, held: picture(HELD)?, seen: files.read_scalars("frames.json")? })
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        let metric = |name: &str, value, unit| {
            Metric::new(format!("example_frames.{}.{name}", super::subject_id(subject)), value, unit)
        };
        let mm = |name, length| metric(name, length / si::MILLIMETRE, "mm");
        let walls = self.seen.shown_walls().into_iter();
        let mut metrics: Vec<Metric> =
            walls.flat_map(|w| [mm("dent_mm", w.dent_m), mm("bulge_mm", w.bulge_m)]).collect();
        if let Some(interval) = self.seen.buckling_pressures() {
            let [low, high] = interval.map(|p| p / si::MILLIBAR);
            metrics.push(metric("critical_mbar.low", low, "mbar"));
            metrics.push(metric("critical_mbar.high", high, "mbar"));
        }
        metrics
    }

    fn summary(&self) -> String {
        let highest = self.seen.pressures_pa.iter().copied().fold(0.0, f64::max);
        format!("{:.0} mbar at {:.2} s", highest / si::MILLIBAR, self.seen.time_s)
    }
}

const REST: &str = "rest.png";
const HELD: &str = "held.png";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_frames_survive_their_record() {
        let picture = |factor: usize| Gray::from_fn(5, 4, |x, y| (factor * (x + 5 * y)) as f64);
        let data = FrameData {
            time_s: 1.5,
            command_pa: 25e3,
            pressures_pa: vec![24.1e3, 0.0],
            rest_px: vec![[1.0, 2.0]],
            held_px: vec![[1.5, 2.5]],
            px_per_m: 5200.0,
            window_px: [0, 0, 5, 4],
            eye_m: [0.0, 0.0, 0.2],
            walls: vec![(24.1e3, Walls { dent_m: 1e-3, dent_at: [0.02, -0.01, 0.0], bulge_m: 2e-3 })],
        };
        let example = ExampleFrames { rest: picture(3), held: picture(7), seen: data };
        assert_eq!(ExampleFrames::from_files(&example.to_files().unwrap()).unwrap(), example);
    }
}
