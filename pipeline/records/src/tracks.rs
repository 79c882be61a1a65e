//! Tracks: the markers of one film in pixels, and the brightness of the lamp.

use serde::{Deserialize, Serialize};

use super::paths::{self, Path};
use crate::subject::Trial;
use workflow::columns::Columns;
use workflow::record::{Record, RecordError, RecordFiles};

/// Tracks of one film.
#[derive(Debug, Clone, PartialEq)]
pub struct Tracks {
    /// Time of each frame on the video's clock, s: frames.
    pub time: Vec<f64>,
    /// Mean grey level of the lamp: frames.
    pub led: Vec<f64>,
    /// Mean difference of each marker from its first view, grey levels a pixel: the largest of the film.
    pub worst_residual: f64,
    /// The markers, px.
    pub markers: Vec<Path>,
}

#[derive(Serialize, Deserialize)]
struct Scalars {
    markers: Vec<String>,
    worst_residual: f64,
}

impl Record for Tracks {
    type Of = Trial;
    const STAGE: &'static str = "track";

    fn is_made_for(trial: &Trial) -> bool {
        trial.trial.video.is_some()
    }

    fn to_files(&self) -> Result<RecordFiles, RecordError> {
        let columns = Columns::default().numbers("time_s", self.time.clone()).numbers("led", self.led.clone());
        let markers = self.markers.iter().map(|m| m.name.clone()).collect();
        RecordFiles::default()
            .table("tracks.parquet", &paths::pack_paths(columns, &self.markers, "px"))?
            .scalars("tracks.json", &Scalars { markers, worst_residual: self.worst_residual })
    }

    fn from_files(files: &RecordFiles) -> Result<Self, RecordError> {
        let scalars: Scalars = files.read_scalars("tracks.json")?;
        let columns = files.read_table("tracks.parquet")?;
        Ok(Self {
            time: columns.f64("time_s")?,
            led: columns.f64("led")?,
            worst_residual: scalars.worst_residual,
            markers: paths::unpack_paths(&columns, &scalars.markers, "px")?,
        })
    }

    fn summary(&self) -> String {
        let (markers, frames) = (self.markers.len(), self.time.len());
        format!("{markers} markers × {frames} frames, worst residual {:.1}", self.worst_residual)
    }
}
