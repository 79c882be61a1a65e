//! `.c3d` of motion capture: c3dio reads its sections; a truncated file, which it accepts, is refused here by the header.
//!
//! A point is lost where its fourth word is negative. c3dio keeps that word's two bytes without the sign, so that a residual of 255 units
//! seen by every camera (0x7FFF) looks like −1 (0xFFFF): the sign is read from the bytes.

use std::path::Path;

use c3dio::prelude::C3d;
use si::Point3;

use super::{EXPORT, Trajectories, Trajectory, in_metres, unit};
use diagnostics::Diagnostic;
use diagnostics::panics::quietly;

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
    // a damaged section leads c3dio out of its bytes, which it answers with a panic, whose text would stand before the refusal
    let parsed = quietly(|| C3d::from_bytes(bytes).map(|c3d| c3d.points).map_err(|e| format!("{e:?}")));
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
    let words = FourthWords::of(bytes);
    let place = |frame: usize, column: usize| {
        let at: Point3 = points[frame][column].point.map(f64::from);
        if words.is_negative(bytes, frame, column) { None } else { in_metres(at, unit) }
    };
    let seen = |(column, name): (usize, &String)| Trajectory {
        name: name.trim().to_owned(),
        at: (0..frames).map(|frame| place(frame, column)).collect(),
    };
    let markers = points.labels.iter().take(points.cols()).enumerate().map(seen).collect();
    Ok(Trajectories { time: (0..frames).map(|frame| frame as f64 / rate).collect(), markers })
}

/// Refuses a header that counts more points than the file can hold, since c3dio makes room for all of them at once.
///
/// A point takes 8 or 16 bytes; a file that was cut to a sixteenth still passes, and is refused later with the frame at which it ends.
fn bounded(bytes: &[u8], path: &Path) -> Result<(), Diagnostic> {
    // The fourth byte of the parameters is 86 where the numbers are big-endian.
    let big = bytes.get(BLOCK * (usize::from(bytes[0]) - 1) + 3) == Some(&BIG_ENDIAN);
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

/// Where the fourth word of each point stands: after the three coordinates, the analogue words of a frame after all its points.
struct FourthWords {
    /// Byte of the first point.
    start: usize,
    /// Bytes of a word: 4 of a real number, 2 of an integer.
    width: usize,
    /// Bytes of a frame.
    frame: usize,
    /// The byte of a word that holds its sign.
    sign: usize,
}

impl FourthWords {
    fn of(bytes: &[u8]) -> Self {
        let processor = bytes.get(BLOCK * (usize::from(bytes[0]) - 1) + 3).copied().unwrap_or_default();
        let big = processor == BIG_ENDIAN;
        let word = |at: usize| {
            let pair = [bytes[at], bytes[at + 1]];
            usize::from(if big { u16::from_be_bytes(pair) } else { u16::from_le_bytes(pair) })
        };
        // A negative scale, the real number at byte 12, says that the points are real numbers too.
        let sign = |width: usize| match processor {
            BIG_ENDIAN => 0,
            DEC => 1,
            _ => width - 1,
        };
        let width = if bytes[12 + sign(4)] & SIGN == 0 { 2 } else { 4 };
        let frame = width * (4 * word(2) + word(4));
        Self { start: BLOCK * word(16).saturating_sub(1), width, frame, sign: sign(width) }
    }

    fn is_negative(&self, bytes: &[u8], frame: usize, point: usize) -> bool {
        let at = self.start + frame * self.frame + self.width * (4 * point + 3) + self.sign;
        bytes.get(at).is_some_and(|byte| byte & SIGN != 0)
    }
}

/// The processor whose words begin with their highest byte.
const BIG_ENDIAN: u8 = 86;
/// The processor whose real numbers have their sign in the second byte.
const DEC: u8 = 85;
const SIGN: u8 = 0x80;

#[cfg(test)]
mod tests {
    use super::*;

    /// The header of two points and `analogue` words in frames 1 to 4, with its parameters in the third block and its data in the
    /// fourth, as a `processor` writes it; the bytes of its `scale` begin at byte 12.
    fn header(processor: u8, analogue: u16, scale: [u8; 4]) -> Vec<u8> {
        let mut bytes = vec![0; 4 * BLOCK];
        (bytes[0], bytes[1], bytes[2 * BLOCK + 3]) = (3, KEY, processor);
        for (at, word) in [(2, 2_u16), (4, analogue), (6, 1), (8, 4), (16, 4)] {
            let pair = if processor == BIG_ENDIAN { word.to_be_bytes() } else { word.to_le_bytes() };
            bytes[at..at + 2].copy_from_slice(&pair);
        }
        bytes[12..16].copy_from_slice(&scale);
        bytes
    }

    const INTEL: u8 = 84;

    #[test]
    fn points_are_counted_in_the_order_of_bytes_of_the_processor() {
        for processor in [INTEL, DEC, BIG_ENDIAN] {
            assert!(bounded(&header(processor, 0, [0; 4]), Path::new("a.c3d")).is_ok(), "{processor}");
        }
        let mut many = header(BIG_ENDIAN, 0, [0; 4]);
        many[2..4].copy_from_slice(&600_u16.to_be_bytes());
        let said = bounded(&many, Path::new("a.c3d")).unwrap_err().to_string();
        assert!(said.contains("600 points in 4 frames"), "{said}");
    }

    #[test]
    fn a_negative_scale_says_real_numbers_and_a_positive_one_integers() {
        for (processor, [real, integer], [of_real, of_integer]) in [
            (INTEL, [(-0.01_f32).to_le_bytes(), 0.1_f32.to_le_bytes()], [3, 1]),
            (BIG_ENDIAN, [(-0.01_f32).to_be_bytes(), 0.1_f32.to_be_bytes()], [0, 0]),
        ] {
            // four words a point and three analogue ones a frame
            let words = FourthWords::of(&header(processor, 3, real));
            assert_eq!([words.start, words.width, words.frame, words.sign], [3 * BLOCK, 4, 44, of_real]);
            let words = FourthWords::of(&header(processor, 3, integer));
            assert_eq!([words.start, words.width, words.frame, words.sign], [3 * BLOCK, 2, 22, of_integer]);
        }
    }

    #[test]
    fn the_sign_of_the_fourth_word_is_that_of_its_point_and_frame() {
        let mut bytes = header(INTEL, 3, 0.1_f32.to_le_bytes());
        // the second point of the third frame
        let at = 3 * BLOCK + 2 * 22 + 2 * 7;
        bytes[at..at + 2].copy_from_slice(&(-1_i16).to_le_bytes());
        let words = FourthWords::of(&bytes);
        let lost = (0..4).flat_map(|frame| [0, 1].map(|point| (frame, point)));
        assert_eq!(
            lost.filter(|(frame, point)| words.is_negative(&bytes, *frame, *point)).collect::<Vec<_>>(),
            [(2, 1)]
        );
    }
}
