//! Markers: the markers of one film in metres, in x and y of the CAD frame.

use super::paths::{self, Path};
use crate::columns::Columns;
use crate::record::{Parcel, Record, RecordError};
use crate::subject::Trial;

/// Where the markers were.
#[derive(Debug, Clone, PartialEq)]
pub struct Markers {
    /// Time of each frame on the video's clock, s: frames.
    pub time: Vec<f64>,
    /// The markers, m.
    pub markers: Vec<Path>,
}

impl Record for Markers {
    type Of = Trial;
    const STAGE: &'static str = "markers";

    fn pack(&self) -> Result<Parcel, RecordError> {
        let columns = Columns::default().numbers("time_s", self.time.clone());
        let names: Vec<&String> = self.markers.iter().map(|m| &m.name).collect();
        Parcel::default()
            .table("markers.parquet", &paths::pack(columns, &self.markers, "m"))?
            .scalars("markers.json", &names)
    }

    fn unpack(parcel: &Parcel) -> Result<Self, RecordError> {
        let names: Vec<String> = parcel.read_scalars("markers.json")?;
        let columns = parcel.read_table("markers.parquet")?;
        Ok(Self { time: columns.f64("time_s")?, markers: paths::unpack(&columns, &names, "m")? })
    }

    fn telling(&self) -> String {
        let reach = self
            .markers
            .iter()
            .filter_map(|m| Some((m, m.at.first()?)))
            .flat_map(|(m, first)| m.at.iter().map(|p| (p[0] - first[0]).hypot(p[1] - first[1])));
        format!("they move up to {:.1} mm", 1e3 * reach.fold(0.0, f64::max))
    }
}
