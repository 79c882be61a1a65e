//! STL: triangles of a file become a welded surface in metres, and back.
//!
//! The format has no unit, so the caller gives it, and the size is checked against the plausible lengths of an actuator.

mod triangles;

use crate::Surface;
use si::{Metre, Point3};
use std::collections::{HashMap, HashSet};
pub use triangles::StlSyntax;

/// Plausible lengths of an actuator, m.
const PLAUSIBLE_LENGTH: [Metre; 2] = [5e-3, 5.0];
/// Corners closer than this fraction of the bounding box are welded; STL has single precision, 6e-8.
const WELD: f64 = 1e-6;

/// A file that does not hold the surface of a solid.
#[derive(Debug, thiserror::Error)]
pub enum StlError {
    /// Not an STL file.
    #[error("the file is not an STL\n  why: {0}\n  do:  export it again as binary or ASCII STL")]
    Format(#[from] StlSyntax),
    /// No triangles, or a coordinate that is not a number.
    #[error(
        "the STL holds {faces} faces and {bad} coordinates that are no numbers\n  why: a solid needs at least 4 faces, all finite\n  do:  export the part again"
    )]
    Nothing {
        /// Faces in the file.
        faces: usize,
        /// Coordinates that are NaN or infinite.
        bad: usize,
    },
    /// Implausible size.
    #[error(
        "the solid is {length} m long; {guess}\n  why: the length must lie between {} m and {} m; the file was read with 1 unit = {unit} m\n  do:  correct unit: mm, cm, m or inch", PLAUSIBLE_LENGTH[0], PLAUSIBLE_LENGTH[1]
    )]
    Size {
        /// Longest side of the bounding box, m.
        length: Metre,
        /// Length of the file's unit, m.
        unit: Metre,
        /// The probable cause.
        guess: &'static str,
    },
}

/// Reads a binary or ASCII STL and welds its corners.
///
/// | name    | unit | meaning                                        |
/// |---------|------|------------------------------------------------|
/// | `bytes` |      | the file                                       |
/// | `unit`  | m    | length of the file's unit, 1e-3 for millimetres |
///
/// Faces that the welding leaves without area (two equal corners) are dropped, and all but the first of those that lie twice.
///
/// # Errors
/// [`StlError`] when the bytes are no STL, hold no solid, or the solid's size is implausible.
pub fn read(bytes: &[u8], unit: Metre) -> Result<Surface, StlError> {
    let (places, faces) = triangles::index_places(&triangles::read_triangles(bytes)?);
    let points: Vec<Point3> = places.into_iter().map(|place| place.map(|c| f64::from(c) * unit)).collect();
    let bad = points.iter().flatten().filter(|c| !c.is_finite()).count();
    if faces.len() < 4 || bad > 0 {
        return Err(StlError::Nothing { faces: faces.len(), bad });
    }
    let raw = Surface { points, faces };
    check_length(raw.length(), unit)?;
    Ok(weld_points(&raw))
}

fn check_length(length: Metre, unit: Metre) -> Result<(), StlError> {
    let guess = match length {
        l if l < PLAUSIBLE_LENGTH[0] => "an STL in metres or inches read as millimetres?",
        l if l > PLAUSIBLE_LENGTH[1] => "an STL in millimetres read as metres or inches?",
        _ => return Ok(()),
    };
    Err(StlError::Size { length, unit, guess })
}

/// Joins corners that lie within [`WELD`] of each other; the first one stays.
fn weld_points(raw: &Surface) -> Surface {
    let tolerance = WELD * raw.length();
    let mut cells: HashMap<[i64; 3], u32> = HashMap::new();
    let mut points = Vec::new();
    let mut merged = Vec::with_capacity(raw.points.len());
    for p in &raw.points {
        // a cell is two radii wide, and a point also claims the cells that its radius reaches
        let reach = |sx: f64, sy: f64, sz: f64| {
            [p[0] + sx * tolerance, p[1] + sy * tolerance, p[2] + sz * tolerance]
                .map(|c| (c / (2.0 * tolerance)).floor() as i64)
        };
        let signs = (0..8).map(|i| [0, 1, 2].map(|k| if i >> k & 1 == 1 { 0.5 } else { -0.5 }));
        let claims: Vec<_> = signs.map(|[x, y, z]| reach(x, y, z)).collect();
        let existing = claims.iter().find_map(|c| cells.get(c).copied());
        let index = existing.unwrap_or(points.len() as u32);
        if existing.is_none() {
            points.push(*p);
        }
        claims.into_iter().for_each(|c| {
            cells.entry(c).or_insert(index);
        });
        merged.push(index);
    }
    let faces = raw.faces.iter().map(|f| f.map(|p| merged[p as usize]));
    let mut present = HashSet::new();
    let is_new = |face: &[u32; 3]| present.insert(from_lowest(*face));
    // The sense is part of the key: a face that lies twice in opposite senses bounds two parts and stays.
    Surface { points, faces: faces.filter(|[a, b, c]| a != b && b != c && c != a).filter(is_new).collect() }
}

/// The corners of a face in their order, the lowest first.
fn from_lowest(mut face: [u32; 3]) -> [u32; 3] {
    let lowest = (0..3).min_by_key(|k| face[*k]).unwrap_or_default();
    face.rotate_left(lowest);
    face
}

/// Writes a binary STL with `title` in its header (first 80 bytes), 1 unit = `unit` m.
pub fn write(surface: &Surface, unit: Metre, title: &str) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(84 + 50 * surface.faces.len());
    bytes.extend(title.bytes().chain(std::iter::repeat(b' ')).take(80));
    bytes.extend((surface.faces.len() as u32).to_le_bytes());
    for face in 0..surface.faces.len() {
        let n = surface.normal(face);
        let length = si::vec3::norm(n).max(f64::MIN_POSITIVE);
        let rows = [n.map(|c| c / length)].into_iter().chain(surface.corners(face).map(|p| p.map(|c| c / unit)));
        // Adding zero makes 0 of −0, so that one surface has one file whichever way its zeros were computed.
        rows.flatten().for_each(|c| bytes.extend((c as f32 + 0.0).to_le_bytes()));
        bytes.extend([0, 0]);
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::tests::block;

    #[test]
    fn a_written_surface_is_read_back() {
        let solid = block([-0.02, 0.0, -0.01], [0.02, 0.01, 0.01]);
        let again = read(&write(&solid, 1e-3, "a box"), 1e-3).unwrap();
        assert_eq!((again.points.len(), again.faces.len()), (8, 12));
        assert!((again.volume() - solid.volume()).abs() < 1e-6 * solid.volume());
    }

    #[test]
    fn an_ascii_file_is_read_too() {
        let solid = block([0.0; 3], [20.0; 3]);
        let mut text = String::from("solid box\n");
        for f in 0..solid.faces.len() {
            text += "facet normal 0 0 0\nouter loop\n";
            solid.corners(f).iter().for_each(|p| text += &format!("vertex {} {} {}\n", p[0], p[1], p[2]));
            text += "endloop\nendfacet\n";
        }
        let read = read((text + "endsolid box\n").as_bytes(), 1e-3).unwrap();
        assert!((read.volume() - 8e-6).abs() < 1e-12);
    }

    #[test]
    fn a_file_in_metres_read_as_millimetres_is_refused() {
        let bytes = write(&block([0.0; 3], [0.1; 3]), 1.0, "a box");
        let error = read(&bytes, 1e-3).unwrap_err().to_string();
        assert!(error.contains("an STL in metres or inches read as millimetres?"), "{error}");
    }

    #[test]
    fn a_face_that_lies_twice_is_read_once_and_its_other_side_is_another_face() {
        let solid = block([0.0; 3], [0.02; 3]);
        let mut doubled = solid.clone();
        doubled.faces.extend(solid.faces[..3].iter().map(|[a, b, c]| [*b, *c, *a]));
        let faces = |surface: &Surface| read(&write(surface, 1e-3, "a box"), 1e-3).unwrap().faces.len();
        assert_eq!(faces(&doubled), 12);
        doubled.faces.push([solid.faces[0][0], solid.faces[0][2], solid.faces[0][1]]);
        assert_eq!(faces(&doubled), 13);
    }

    #[test]
    fn text_that_is_no_stl_is_refused() {
        assert!(read(b"nothing of the kind", 1e-3).is_err());
    }
}
