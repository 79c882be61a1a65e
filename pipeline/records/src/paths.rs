//! Paths of markers in a plane, frame by frame, with a covariance each; shared by tracks (px), markers and motion (m).

use si::Point2;

use sysid::Covariance2;
use track::imported::ImportedTrack;
use workflow::columns::Columns;
use workflow::record::RecordError;

/// One marker through a film.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Path {
    /// The marker's name on the card.
    pub name: String,
    /// Positions: frames × 2.
    pub at: Vec<Point2>,
    /// Covariances of the positions: frames × 3.
    pub spread: Vec<Covariance2>,
}

impl Path {
    /// Of a track of another program.
    pub fn from_import(track: &ImportedTrack) -> Self {
        let (positions, spread) = track.places_with_covariances();
        Self { name: track.name.clone(), at: positions, spread }
    }

    /// The mean position over a range of frames.
    pub fn mean(&self, frames: std::ops::Range<usize>) -> Point2 {
        let count = frames.len().max(1) as f64;
        let sum = self.at[frames].iter().fold([0.0; 2], |s, p| [s[0] + p[0], s[1] + p[1]]);
        [sum[0] / count, sum[1] / count]
    }
}

/// Adds five columns a path, named `<marker>_x_<unit>` … `<marker>_yy_<unit>2`.
pub(crate) fn pack_paths(columns: Columns, paths: &[Path], unit: &str) -> Columns {
    paths.iter().fold(columns, |columns, path| {
        let name = |axis: &str| format!("{}_{axis}", path.name);
        let coordinate = |k: usize| path.at.iter().map(|p| p[k]).collect();
        let columns = columns
            .numbers(&name(&format!("x_{unit}")), coordinate(0))
            .numbers(&name(&format!("y_{unit}")), coordinate(1));
        pack_spread(columns, &path.name, &path.spread, unit)
    })
}

/// Adds three columns of a covariance, named `<name>_xx_<unit>2` and so on.
pub(crate) fn pack_spread(columns: Columns, name: &str, spread: &[Covariance2], unit: &str) -> Columns {
    ["xx", "xy", "yy"].iter().enumerate().fold(columns, |columns, (k, part)| {
        columns.numbers(&format!("{name}_{part}_{unit}2"), spread.iter().map(|s| s[k]).collect())
    })
}

/// Reads what [`pack_spread`] wrote.
pub(crate) fn unpack_spread(columns: &Columns, name: &str, unit: &str) -> Result<Vec<Covariance2>, RecordError> {
    let column = |part: &str| columns.f64(&format!("{name}_{part}_{unit}2"));
    let (xx, xy, yy) = (column("xx")?, column("xy")?, column("yy")?);
    // length: columns of one table are equally long
    Ok(xx.into_iter().zip(xy).zip(yy).map(|((a, b), c)| [a, b, c]).collect())
}

/// Reads what [`pack_paths`] wrote, for the markers of these names.
pub(crate) fn unpack_paths(columns: &Columns, names: &[String], unit: &str) -> Result<Vec<Path>, RecordError> {
    names
        .iter()
        .map(|name| {
            let column = |axis: &str| columns.f64(&format!("{name}_{axis}"));
            let (x, y) = (column(&format!("x_{unit}"))?, column(&format!("y_{unit}"))?);
            // length: as above
            let positions = x.into_iter().zip(y).map(|(x, y)| [x, y]).collect();
            Ok(Path { name: name.clone(), at: positions, spread: unpack_spread(columns, name, unit)? })
        })
        .collect()
}
