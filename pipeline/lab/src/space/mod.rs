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
    let space = if ending == "c3d" { c3d::read(bytes, path)? } else { csv::read(bytes, path)? };
    if space.time.is_empty() || space.markers.is_empty() {
        let (markers, frames) = (space.markers.len(), space.time.len());
        let what = format!("no point data: {markers} markers × {frames} frames");
        return Err(Diagnostic::file(path, what, "tracks are places of markers in every frame", EXPORT));
    }
    for (seen, frame, place) in space.places() {
        if place.iter().any(|x| x.abs() > LARGEST_COORDINATE) {
            let what = format!("marker `{}` is at {place:?} m in frame {frame}", seen.name);
            let why = format!("no instrument measures beyond {LARGEST_COORDINATE} m; the unit is the file's own");
            return Err(Diagnostic::file(path, what, why, "export again with the right unit"));
        }
    }
    Ok(space)
}

/// What to do with a file that cannot be used.
const EXPORT: &str = "export the trajectories of every marker on the card, gaps filled, as .c3d or CSV";

impl Trajectories {
    /// Every place that was seen, with its marker and frame.
    fn places(&self) -> impl Iterator<Item = (&Trajectory, usize, Point3)> {
        let of = |seen| move |(frame, at): (usize, &Option<Point3>)| at.map(|place| (seen, frame, place));
        self.markers.iter().flat_map(move |seen| seen.at.iter().enumerate().filter_map(of(seen)))
    }

    /// The marker of this name, which may have its subject's before it (`fish:m1`).
    fn marker(&self, name: &str, path: &Path) -> Result<Option<&Trajectory>, Diagnostic> {
        if let Some(seen) = self.markers.iter().find(|seen| seen.name == name) {
            return Ok(Some(seen));
        }
        let is = |seen: &&Trajectory| seen.name.rsplit_once(':').is_some_and(|(_, own)| own == name);
        let all: Vec<&Trajectory> = self.markers.iter().filter(is).collect();
        let [first, second, ..] = all[..] else { return Ok(all.first().copied()) };
        let what = format!("marker `{name}` is `{}` or `{}`", first.name, second.name);
        Err(Diagnostic::file(path, what, "the file has several subjects", "export the subject of the card alone"))
    }

    /// The marker `name` in every frame, m, in the file's axes; `path` appears only in diagnostics.
    ///
    /// # Errors
    /// [`Diagnostic`] when there is no such marker, or it was lost in a frame.
    pub fn complete(&self, name: &str, path: &Path) -> Result<Vec<Point3>, Diagnostic> {
        let Some(seen) = self.marker(name, path)? else {
            let names: Vec<&str> = self.markers.iter().map(|seen| seen.name.as_str()).collect();
            let action = match nearest(name, &names) {
                Some(near) => format!("call the marker `{near}` on the card, or rename it in the file"),
                None => "name the markers alike in the file and on the card".to_owned(),
            };
            let why = format!("the file has {}", names.join(", "));
            return Err(Diagnostic::file(path, format!("no marker `{name}`"), why, action));
        };
        let place = |(frame, at): (usize, &Option<Point3>)| {
            at.ok_or_else(|| {
                let lost = seen.at.iter().filter(|at| at.is_none()).count();
                let what = format!("marker `{name}` is lost in frame {frame} ({:.3} s)", self.time[frame]);
                let why = format!("it is in {lost} of {} frames, and no place is guessed here", seen.at.len());
                Diagnostic::file(path, what, why, EXPORT)
            })
        };
        seen.at.iter().enumerate().map(place).collect()
    }
}

/// The unit of a word as files have it.
fn unit(word: &str) -> Option<LengthUnit> {
    match word.trim().to_ascii_lowercase().as_str() {
        "m" | "mete" | "metr" => Some(LengthUnit::M),
        "cm" => Some(LengthUnit::Cm),
        "mm" => Some(LengthUnit::Mm),
        "in" | "inch" => Some(LengthUnit::Inch),
        _ => None,
    }
}

/// A place of the file in metres; none when one of its numbers is none.
fn in_metres(at: Point3, unit: LengthUnit) -> Option<Point3> {
    at.iter().all(|x| x.is_finite()).then(|| at.map(|x| x * unit.metres()))
}
