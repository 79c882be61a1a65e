//! Places in space as CSV: one line a frame and marker, the unit in the titles.

use std::borrow::Cow;
use std::path::Path;

use csv::StringRecord;
use si::Second;

use super::{EXPORT, Trajectories, Trajectory, in_metres, length_unit_of};
use crate::card::LengthUnit;
use crate::log::encoding::decode_text;
use crate::log::table::encoding_name;
use diagnostics::Diagnostic;

/// The places in a file's `bytes`.
///
/// # Errors
/// As [`super::read`].
pub(super) fn read_csv(bytes: &[u8], path: &Path) -> Result<Trajectories, Diagnostic> {
    let text = as_utf_8(bytes);
    let title_line = text.split(|byte| *byte == b'\n').next().unwrap_or_default();
    let separator = [b';', b'\t'].into_iter().find(|sign| title_line.contains(sign)).unwrap_or(b',');
    let mut reader =
        csv::ReaderBuilder::new().delimiter(separator).trim(csv::Trim::All).flexible(true).from_reader(&text[..]);
    let titles = reader.headers().map_err(|e| line_error(path, 1, e.to_string()))?.clone();
    let columns = Columns::of(&titles, path)?;
    let mut trajectories = Trajectories { time: Vec::new(), markers: Vec::new() };
    for (row, record) in reader.records().enumerate() {
        let record = record.map_err(|e| line_error(path, row + 2, e.to_string()))?;
        columns.take(&record, &mut trajectories).map_err(|reason| line_error(path, row + 2, reason))?;
    }
    match trajectories.markers.iter().find(|trajectory| trajectory.at.len() != trajectories.time.len()) {
        None => Ok(trajectories),
        Some(trajectory) => {
            let defect = format!(
                "marker `{}` has {} places in {} frames",
                trajectory.name,
                trajectory.at.len(),
                trajectories.time.len()
            );
            Err(Diagnostic::file(path, defect, "every marker has a line in every frame", EXPORT))
        }
    }
}

/// The bytes in UTF-8 without a byte-order mark; what is in no encoding is refused with its line.
fn as_utf_8(bytes: &[u8]) -> Cow<'_, [u8]> {
    match encoding_name(bytes) {
        "UTF-16" => decode_text(bytes.to_vec()).map_or(Cow::Borrowed(bytes), |text| Cow::Owned(text.into_bytes())),
        _ => Cow::Borrowed(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)),
    }
}

/// Where what stands in a line.
struct Columns {
    time: usize,
    marker: usize,
    /// x, y and, where it was measured, z.
    at: [Option<usize>; 3],
    unit: LengthUnit,
}

impl Columns {
    fn of(titles: &StringRecord, path: &Path) -> Result<Self, Diagnostic> {
        let column = |title: &str| titles.iter().position(|t| t == title);
        let axis = |axis: &str| titles.iter().position(|t| t.split_once('_').is_some_and(|(name, _)| name == axis));
        let (Some(time), Some(marker), Some(x), Some(y)) = (column("time_s"), column("marker"), axis("x"), axis("y"))
        else {
            return Err(line_error(path, 1, "the columns are frame,time_s,marker,x_mm,y_mm and perhaps z_mm".into()));
        };
        let axis_columns = [Some(x), Some(y), axis("z")];
        let word = |column: usize| titles[column].split_once('_').and_then(|(_, word)| length_unit_of(word));
        let units: Vec<Option<LengthUnit>> = axis_columns.iter().flatten().map(|column| word(*column)).collect();
        match units[0] {
            Some(unit) if units.iter().all(|other| *other == Some(unit)) => {
                Ok(Self { time, marker, at: axis_columns, unit })
            }
            _ => Err(line_error(path, 1, "x, y and z have one unit of m, cm, mm, inch each, as in x_mm".into())),
        }
    }

    /// Takes in a line.
    fn take(&self, record: &StringRecord, trajectories: &mut Trajectories) -> Result<(), String> {
        // between semicolons and tabs a comma is a decimal sign
        let number = |column: usize| {
            let word = record.get(column).unwrap_or_default();
            word.replacen(',', ".", 1).parse::<f64>().map_err(|_| format!("`{word}` is no number"))
        };
        let coordinate = |column: usize| match record.get(column) {
            Some("") => Ok(f64::NAN),
            _ => number(column),
        };
        let time: Second = number(self.time)?;
        let name = record.get(self.marker).unwrap_or_default();
        let mut coordinates = [0.0; 3];
        for (x, column) in coordinates.iter_mut().zip(self.at) {
            *x = column.map_or(Ok(0.0), coordinate)?;
        }
        let index = match trajectories.markers.iter().position(|trajectory| trajectory.name == name) {
            Some(index) => index,
            None => {
                trajectories.markers.push(Trajectory { name: name.to_owned(), at: Vec::new() });
                trajectories.markers.len() - 1
            }
        };
        let frame = trajectories.markers[index].at.len();
        match trajectories.time.get(frame) {
            None if trajectories.time.last().is_none_or(|last| time > *last) && time.is_finite() => {
                trajectories.time.push(time)
            }
            Some(frame_time) if *frame_time == time => {}
            _ => return Err(format!("marker `{name}` at {time} s does not fit the times of frame {frame}")),
        }
        trajectories.markers[index].at.push(in_metres(coordinates, self.unit));
        Ok(())
    }
}

fn line_error(path: &Path, line: usize, reason: String) -> Diagnostic {
    Diagnostic::file(path, "the places cannot be read", reason, EXPORT).at_line(line)
}
