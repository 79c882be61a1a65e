//! Trajectories of markers in space, measured by another instrument: motion capture's `.c3d`, or a CSV in metres or millimetres.
//!
//! ```text
//! frame,time_s,marker,x_mm,y_mm,z_mm
//! 0,0.000000,m1,55.01,0.02,15.48
//! ```
//! The titles hold the unit (`m`, `cm`, `mm`, `inch`); z may be missing where all was seen in a plane. Times count from the
//! file's first frame. A marker may be lost in a frame: that is refused where the marker is asked for, not where it is read.

mod c3d;
mod csv;

use std::path::Path;

use si::{Point3, Second};

use crate::card::LengthUnit;
use crate::table::nearest;
use diagnostics::Diagnostic;

/// Largest plausible coordinate, m.
const LARGEST_COORDINATE: f64 = 20.0;

/// The markers of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectories {
    /// Time of each frame since the first, s: frames.
    pub time: Vec<Second>,
    /// The markers in the file's order.
    pub markers: Vec<Trajectory>,
}

/// One marker of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// Its name there.
    pub name: String,
    /// Where it was, m, in the file's axes, z = 0 where the file has none; none while it was lost: frames.
    pub at: Vec<Option<Point3>>,
}

/// Reads a file's `bytes` by the ending of `path`, which otherwise appears only in diagnostics.
///
/// # Errors
/// [`Diagnostic`] when the file is cut, holds no points, has no unit, or a place no instrument measures.
pub fn read(bytes: &[u8], path: &Path) -> Result<Trajectories, Diagnostic> {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let trajectories = if ending == "c3d" { c3d::read_c3d(bytes, path)? } else { csv::read_csv(bytes, path)? };
    if trajectories.time.is_empty() || trajectories.markers.is_empty() {
        let (markers, frames) = (trajectories.markers.len(), trajectories.time.len());
        let defect = format!("no point data: {markers} markers × {frames} frames");
        return Err(Diagnostic::file(path, defect, "tracks are places of markers in every frame", EXPORT));
    }
    for (trajectory, frame, position) in trajectories.present_places() {
        if position.iter().any(|x| x.abs() > LARGEST_COORDINATE) {
            let defect = format!("marker `{}` is at {position:?} m in frame {frame}", trajectory.name);
            let reason = format!("no instrument measures beyond {LARGEST_COORDINATE} m; the unit is the file's own");
            return Err(Diagnostic::file(path, defect, reason, "export again with the right unit"));
        }
    }
    Ok(trajectories)
}

/// What to do with a file that cannot be used.
const EXPORT: &str = "export the trajectories of every marker on the card, gaps filled, as .c3d or CSV";

impl Trajectories {
    /// Every place that was seen, with its marker and frame.
    fn present_places(&self) -> impl Iterator<Item = (&Trajectory, usize, Point3)> {
        let position_in =
            |trajectory| move |(frame, at): (usize, &Option<Point3>)| at.map(|point| (trajectory, frame, point));
        self.markers
            .iter()
            .flat_map(move |trajectory| trajectory.at.iter().enumerate().filter_map(position_in(trajectory)))
    }

    /// The marker of this name, which may have its subject's before it (`fish:m1`).
    fn find_marker(&self, name: &str, path: &Path) -> Result<Option<&Trajectory>, Diagnostic> {
        if let Some(trajectory) = self.markers.iter().find(|trajectory| trajectory.name == name) {
            return Ok(Some(trajectory));
        }
        let has_suffix =
            |trajectory: &&Trajectory| trajectory.name.rsplit_once(':').is_some_and(|(_, suffix)| suffix == name);
        let matches: Vec<&Trajectory> = self.markers.iter().filter(has_suffix).collect();
        let [first, second, ..] = matches[..] else { return Ok(matches.first().copied()) };
        let defect = format!("marker `{name}` is `{}` or `{}`", first.name, second.name);
        Err(Diagnostic::file(path, defect, "the file has several subjects", "export the subject of the card alone"))
    }

    /// The marker `name` in every frame, m, in the file's axes; `path` appears only in diagnostics.
    ///
    /// # Errors
    /// [`Diagnostic`] when there is no such marker, or it was lost in a frame.
    pub fn complete(&self, name: &str, path: &Path) -> Result<Vec<Point3>, Diagnostic> {
        let Some(trajectory) = self.find_marker(name, path)? else {
            let names: Vec<&str> = self.markers.iter().map(|trajectory| trajectory.name.as_str()).collect();
            let action = match nearest(name, &names) {
                Some(similar) => format!("call the marker `{similar}` on the card, or rename it in the file"),
                None => "name the markers alike in the file and on the card".to_owned(),
            };
            let reason = format!("the file has {}", names.join(", "));
            return Err(Diagnostic::file(path, format!("no marker `{name}`"), reason, action));
        };
        let position_or_loss = |(frame, position): (usize, &Option<Point3>)| {
            position.ok_or_else(|| {
                let lost = trajectory.at.iter().filter(|position| position.is_none()).count();
                let defect = format!("marker `{name}` is lost in frame {frame} ({:.3} s)", self.time[frame]);
                let reason = format!("it is in {lost} of {} frames, and no place is guessed here", trajectory.at.len());
                Diagnostic::file(path, defect, reason, EXPORT)
            })
        };
        trajectory.at.iter().enumerate().map(position_or_loss).collect()
    }
}

/// The unit of a word as files have it.
fn length_unit_of(word: &str) -> Option<LengthUnit> {
    match word.trim().to_ascii_lowercase().as_str() {
        "m" | "mete" | "metr" => Some(LengthUnit::M),
        "cm" => Some(LengthUnit::Cm),
        "mm" => Some(LengthUnit::Mm),
        "in" | "inch" => Some(LengthUnit::Inch),
        _ => None,
    }
}

/// Whether a program wrote the coordinates where a marker was lost: one number of nines alone, or one beyond all lengths, in each.
fn is_placeholder([x, y, z]: Point3) -> bool {
    let digits = x.abs().to_string();
    let is_nines = digits.len() >= 3 && digits.bytes().all(|digit| digit == b'9');
    // a file of a plane has no z
    (is_nines || x.abs() > 1e20) && x == y && (z == x || z == 0.0)
}

/// A place of the file in metres; none when one of its numbers is none, or stands for a marker that was lost.
fn in_metres(coordinates: Point3, unit: LengthUnit) -> Option<Point3> {
    let is_place = coordinates.iter().all(|x| x.is_finite()) && !is_placeholder(coordinates);
    is_place.then(|| coordinates.map(|x| x * unit.metres()))
}
