//! `.c3d` of motion capture: c3dio reads its sections; a truncated file, which it accepts, is refused here by the header.
//!
//! A point is lost where its fourth word is −1. c3dio reads that word's low byte as signed, so that a residual over 127 units
//! looks negative: only −1 with every camera's bit set counts as lost.

use std::panic::catch_unwind;
use std::path::Path;

use c3dio::prelude::{C3d, MarkerPoint};
use si::Point3;

use super::{EXPORT, Trajectories, Trajectory, in_metres, unit};
use diagnostics::Diagnostic;

/// Bytes of a block.
const BLOCK: usize = 512;
/// The second byte of every such file.
const KEY: u8 = 80;
/// The last frame of a header that could not count further.
const COUNTLESS: u16 = u16::MAX;

/// The points in a file's `bytes`.
///
/// # Errors
/// As [`super::read`].
pub(super) fn read(bytes: &[u8], path: &Path) -> Result<Trajectories, Diagnostic> {
    if bytes.len() < 2 * BLOCK || bytes[1] != KEY || usize::from(bytes[0]) < 2 {
        let what = format!("{} bytes are no .c3d", bytes.len());
        return Err(Diagnostic::file(path, what, "such a file begins with a block of 512 bytes, marked 80", EXPORT));
    }
    bounded(bytes, path)?;
    let unreadable = |why: String| Diagnostic::file(path, "the .c3d cannot be read", why, EXPORT);
    // a damaged section leads c3dio out of its bytes, which it answers with a panic
    let parsed = catch_unwind(|| C3d::from_bytes(bytes).map(|c3d| c3d.points).map_err(|e| format!("{e:?}")));
    let parsed = parsed.map_err(|_| unreadable("a section leads out of the file".into()))?;
    let points = parsed.map_err(unreadable)?;
    let frames = points.rows();
    let announced = (usize::from(points.last_frame) + 1).saturating_sub(usize::from(points.first_frame));
    if points.cols() > 0 && frames < announced && points.last_frame != COUNTLESS {
        let what = format!("the file ends in frame {frames}, and its header has {announced}");
        return Err(Diagnostic::file(path, what, "the file was cut", "copy it again"));
    }
    let word: String = points.units.iter().collect();
    let unit = unit(&word).ok_or_else(|| {
        let what = format!("POINT:UNITS is `{}`", word.trim());
        Diagnostic::file(path, what, "places are read in m, cm, mm or inch", "export again with a unit of length")
    })?;
    let rate = f64::from(points.frame_rate);
    if !(0.1..=1e5).contains(&rate) {
        let what = format!("POINT:RATE is {rate} frames/s");
        return Err(Diagnostic::file(path, what, "the rate lies in 0.1 to 100000 frames/s", EXPORT));
    }
    let lost = |point: &MarkerPoint| point.residual == -points.scale_factor && point.cameras.iter().all(|seen| *seen);
    let place = |point: &MarkerPoint| {
        let at: Point3 = point.point.map(f64::from);
        if lost(point) { None } else { in_metres(at, unit) }
    };
    let seen = |(column, name): (usize, &String)| Trajectory {
        name: name.trim().to_owned(),
        at: (0..frames).map(|frame| place(&points[frame][column])).collect(),
    };
    let markers = points.labels.iter().take(points.cols()).enumerate().map(seen).collect();
    Ok(Trajectories { time: (0..frames).map(|frame| frame as f64 / rate).collect(), markers })
}

/// Refuses a header that counts more points than the file can hold, since c3dio makes room for all of them at once.
///
/// A point takes 8 or 16 bytes; a file that was cut to a sixteenth still passes, and is refused later with the frame at which it ends.
fn bounded(bytes: &[u8], path: &Path) -> Result<(), Diagnostic> {
    // The fourth byte of the parameters is 86 where the numbers are big-endian.
    let big = bytes.get(BLOCK * (usize::from(bytes[0]) - 1) + 3) == Some(&86);
    let word = |at: usize| {
        let pair = [bytes[at], bytes[at + 1]];
        if big { u16::from_be_bytes(pair) } else { u16::from_le_bytes(pair) }
    };
    // c3dio counts the frames in the words of the header, which wrap.
    let (points, frames) = (usize::from(word(2)), usize::from(word(8).wrapping_sub(word(6)).wrapping_add(1)));
    if points * frames <= bytes.len() {
        return Ok(());
    }
    let what = format!("the header counts {points} points in {frames} frames");
    let why = format!("the file has {} bytes, and a point takes 8 at least", bytes.len());
    Err(Diagnostic::file(path, what, why, EXPORT))
}
