//! Markers: the markers of one film in metres, in x and y of the CAD frame, and the size of each correction.

use serde::{Deserialize, Serialize};

use super::paths::{self, Path};
use crate::subject::Trial;
use sysid::Covariance2;
use workflow::columns::Columns;
use workflow::metric::Metric;
use workflow::record::{Record, RecordError, RecordFiles};

/// Marker positions.
#[derive(Debug, Clone, PartialEq)]
pub struct Markers {
    /// Time of each frame on the video's clock, s: frames.
    pub time: Vec<f64>,
    /// The markers, m, each with the full covariance of its position.
    pub markers: Vec<Path>,
    /// Contributions to the covariance: markers.
    pub parts: Vec<CovarianceParts>,
    /// The error without each correction.
    pub left_out: Vec<OmittedCorrection>,
    /// Camera pose in this film from the grid's lines; none where no grid is on the card or detected.
    pub stand: Option<FilmPose>,
}

/// Camera pose in a film.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FilmPose {
    /// Rotation of the pose, CAD frame → camera frame, rows.
    pub rotation: [[f64; 3]; 3],
    /// Its translation, m.
    pub translation_m: [f64; 3],
    /// Line segments that it is estimated from.
    pub pieces: usize,
    /// Root mean square distance of their midpoints from their lines, m.
    pub off_m: f64,
    /// Distance of the camera from its calibrated position, m.
    pub moved_m: f64,
}

/// The covariance of a marker in two parts, m².
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CovarianceParts {
    /// Of the position, independent in every frame: pixels and ripples.
    pub noise: Vec<Covariance2>,
    /// Of the displacement since the first frame, from errors that are constant in a film: camera, heights, water.
    pub shared: Vec<Covariance2>,
}

/// The error without one correction: root mean square over markers and frames.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OmittedCorrection {
    /// Which one.
    pub correction: String,
    /// Of places, m.
    pub place_m: f64,
    /// Of displacements since the first frame, m.
    pub motion_m: f64,
}

#[derive(Serialize, Deserialize)]
struct Scalars {
    markers: Vec<String>,
    left_out: Vec<OmittedCorrection>,
    stand: Option<FilmPose>,
}

impl Record for Markers {
    type Of = Trial;
    const STAGE: &'static str = "markers";

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        let columns = Columns::default().numbers("time_s", self.time.clone());
        let mut columns = paths::pack_paths(columns, &self.markers, "m");
        for (path, parts) in self.markers.iter().zip(&self.parts) {
            columns = paths::pack_spread(columns, &format!("{}_noise", path.name), &parts.noise, "m");
            columns = paths::pack_spread(columns, &format!("{}_shared", path.name), &parts.shared, "m");
        }
        let markers = self.markers.iter().map(|m| m.name.clone()).collect();
        RecordFiles::default()
            .table("markers.parquet", &columns)?
            .scalars("markers.json", &Scalars { markers, left_out: self.left_out.clone(), stand: self.stand.clone() })
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
        let Scalars { markers, left_out, stand } = files.read_scalars("markers.json")?;
        let columns = files.read_table("markers.parquet")?;
        let part = |name: &String, word: &str| paths::unpack_spread(&columns, &format!("{name}_{word}"), "m");
        let parts = |name: &String| Ok(CovarianceParts { noise: part(name, "noise")?, shared: part(name, "shared")? });
        let parts = markers.iter().map(parts).collect::<Result<_, RecordError>>()?;
        let paths = paths::unpack_paths(&columns, &markers, "m")?;
        Ok(Self { time: columns.f64("time_s")?, markers: paths, parts, left_out, stand })
    }

    fn metrics(&self, subject: &str) -> Vec<Metric> {
        let id = |l: &OmittedCorrection| format!("markers.{}.without_{}_mm", super::subject_id(subject), l.correction);
        let camera_displacement = |s: &FilmPose| {
            Metric::new(format!("markers.{}.camera_displacement_mm", super::subject_id(subject)), 1e3 * s.moved_m, "mm")
        };
        let left_out = self.left_out.iter().map(|l| Metric::new(id(l), 1e3 * l.motion_m, "mm"));
        left_out.chain(self.stand.iter().map(camera_displacement)).collect()
    }

    fn summary(&self) -> String {
        let reach = self
            .markers
            .iter()
            .filter_map(|m| Some((m, m.at.first()?)))
            .flat_map(|(m, first)| m.at.iter().map(|p| (p[0] - first[0]).hypot(p[1] - first[1])));
        let stood = self.stand.as_ref().map(|s| {
            format!("; camera {:.2} mm from its calibrated position, {} line segments", 1e3 * s.moved_m, s.pieces)
        });
        format!("displacement up to {:.1} mm{}", 1e3 * reach.fold(0.0, f64::max), stood.unwrap_or_default())
    }
}
