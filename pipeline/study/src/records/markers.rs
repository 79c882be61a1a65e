//! Markers: the markers of one film in metres, in x and y of the CAD frame, and what each correction on the way was worth.

use serde::{Deserialize, Serialize};

use super::paths::{self, Path, Spread};
use crate::columns::Columns;
use crate::metric::Metric;
use crate::record::{Parcel, Record, RecordError};
use crate::subject::Trial;

/// Where the markers were.
#[derive(Debug, Clone, PartialEq)]
pub struct Markers {
    /// Time of each frame on the video's clock, s: frames.
    pub time: Vec<f64>,
    /// The markers, m, each with the whole covariance of its place.
    pub markers: Vec<Path>,
    /// What the covariance is made of: markers.
    pub parts: Vec<Parts>,
    /// What would have been wrong without one correction.
    pub left_out: Vec<LeftOut>,
    /// Where the camera stood in this film, by the grid's lines; none where no grid is named or seen.
    pub stand: Option<Stand>,
}

/// Where the camera stood in a film.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stand {
    /// Rotation of the pose, CAD frame → camera frame, rows.
    pub rotation: [[f64; 3]; 3],
    /// Its shift, m.
    pub translation_m: [f64; 3],
    /// Pieces of lines that told it.
    pub pieces: usize,
    /// Root of the mean squared distance of their middles from their lines, m.
    pub off_m: f64,
    /// How far the camera stood from where it was calibrated, m.
    pub moved_m: f64,
}

/// The covariance of a marker in two parts, m².
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Parts {
    /// Of the place, new in every frame: pixels and ripples.
    pub noise: Vec<Spread>,
    /// Of the displacement since the first frame, from causes that stay through the film: camera, heights, water.
    pub shared: Vec<Spread>,
}

/// The error that leaving out one correction would have made: root of the mean square over markers and frames.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LeftOut {
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
    left_out: Vec<LeftOut>,
    stand: Option<Stand>,
}

impl Record for Markers {
    type Of = Trial;
    const STAGE: &'static str = "markers";

    fn pack(&self) -> Result<Parcel, RecordError> {
        let columns = Columns::default().numbers("time_s", self.time.clone());
        let mut columns = paths::pack(columns, &self.markers, "m");
        for (path, parts) in self.markers.iter().zip(&self.parts) {
            columns = paths::pack_spread(columns, &format!("{}_noise", path.name), &parts.noise, "m");
            columns = paths::pack_spread(columns, &format!("{}_shared", path.name), &parts.shared, "m");
        }
        let markers = self.markers.iter().map(|m| m.name.clone()).collect();
        Parcel::default()
            .table("markers.parquet", &columns)?
            .scalars("markers.json", &Scalars { markers, left_out: self.left_out.clone(), stand: self.stand.clone() })
    }

    fn unpack(parcel: &Parcel) -> Result<Self, RecordError> {
        let Scalars { markers, left_out, stand } = parcel.read_scalars("markers.json")?;
        let columns = parcel.read_table("markers.parquet")?;
        let part = |name: &String, word: &str| paths::unpack_spread(&columns, &format!("{name}_{word}"), "m");
        let parts = |name: &String| Ok(Parts { noise: part(name, "noise")?, shared: part(name, "shared")? });
        let parts = markers.iter().map(parts).collect::<Result<_, RecordError>>()?;
        let paths = paths::unpack(&columns, &markers, "m")?;
        Ok(Self { time: columns.f64("time_s")?, markers: paths, parts, left_out, stand })
    }

    fn metrics(&self, of: &Trial) -> Vec<Metric> {
        let id = |l: &LeftOut| format!("markers.{}_{}.without_{}_mm", of.card.name, of.trial.id, l.correction);
        let moved = |s: &Stand| {
            Metric::new(format!("markers.{}_{}.camera_moved_mm", of.card.name, of.trial.id), 1e3 * s.moved_m, "mm")
        };
        let left_out = self.left_out.iter().map(|l| Metric::new(id(l), 1e3 * l.motion_m, "mm"));
        left_out.chain(self.stand.iter().map(moved)).collect()
    }

    fn telling(&self) -> String {
        let reach = self
            .markers
            .iter()
            .filter_map(|m| Some((m, m.at.first()?)))
            .flat_map(|(m, first)| m.at.iter().map(|p| (p[0] - first[0]).hypot(p[1] - first[1])));
        let stood = self
            .stand
            .as_ref()
            .map(|s| format!("; camera {:.2} mm off its place, {} pieces of lines", 1e3 * s.moved_m, s.pieces));
        format!("they move up to {:.1} mm{}", 1e3 * reach.fold(0.0, f64::max), stood.unwrap_or_default())
    }
}
