//! `.c3d` of motion capture: the points of its data section, by header and parameters, with real numbers or integers of any processor.
//!
//! A point is lost where its fourth word is negative, which the format asks for, or where its three coordinates are zero, as several programs
//! write it.

mod frames;
mod parameters;
mod words;

use std::path::Path;

use si::Point3;

use super::{EXPORT, Trajectories, Trajectory, in_metres, length_unit_of};
use crate::card::LengthUnit;
use diagnostics::Diagnostic;
use frames::Announced;
use parameters::Parameters;
use words::Words;

/// Bytes of a block.
const BLOCK: usize = 512;
/// The second byte of every such file.
const KEY: u8 = 80;

/// The points in a file's `bytes`.
///
/// # Errors
/// As [`super::read`].
pub(super) fn read_c3d(bytes: &[u8], path: &Path) -> Result<Trajectories, Diagnostic> {
    if bytes.len() < 2 * BLOCK || bytes[1] != KEY || usize::from(bytes[0]) < 2 {
        let defect = format!("{} bytes are no .c3d", bytes.len());
        return Err(Diagnostic::file(path, defect, "such a file begins with a block of 512 bytes, marked 80", EXPORT));
    }
    let begin = BLOCK * (usize::from(bytes[0]) - 1);
    let words = Words::new(bytes, begin);
    let parameters = Parameters::new(words, begin);
    let points = Points::new(words);
    let frames = points.frame_count(&parameters, path)?;
    let (unit, rate) = (length_unit(&parameters, path)?, frame_rate(&parameters, words, path)?);
    let trajectory = |(column, name): (usize, String)| Trajectory {
        name,
        at: (0..frames).map(|frame| in_metres(points.point_position(frame, column)?, unit)).collect(),
    };
    // more names than a list can hold go on in others
    let names = (1..).map(|list| if list == 1 { "LABELS".to_owned() } else { format!("LABELS{list}") });
    let names = names.map(|list| parameters.text_list("POINT", &list)).take_while(|names| !names.is_empty()).flatten();
    let markers = names.take(points.count).enumerate().map(trajectory).collect();
    Ok(Trajectories { time: (0..frames).map(|frame| frame as f64 / rate).collect(), markers })
}

fn length_unit(parameters: &Parameters, path: &Path) -> Result<LengthUnit, Diagnostic> {
    let word = parameters.text_list("POINT", "UNITS").concat();
    length_unit_of(&word).ok_or_else(|| {
        let defect = format!("POINT:UNITS is `{word}`");
        Diagnostic::file(path, defect, "places are read in m, cm, mm or inch", "export again with a unit of length")
    })
}

fn frame_rate(parameters: &Parameters, words: Words, path: &Path) -> Result<f64, Diagnostic> {
    let rate = parameters.number_list("POINT", "RATE").first().copied().unwrap_or_else(|| f64::from(words.real(20)));
    if !(0.1..=1e5).contains(&rate) {
        let defect = format!("POINT:RATE is {rate} frames/s");
        return Err(Diagnostic::file(path, defect, "the rate lies in 0.1 to 100000 frames/s", EXPORT));
    }
    Ok(rate)
}

/// The points of the data section: three coordinates and a fourth word each, the analogue words of a frame after all its points.
struct Points<'a> {
    words: Words<'a>,
    /// Points in a frame.
    count: usize,
    /// Byte of the first frame.
    start: usize,
    /// Bytes of a word: 4 of a real number, 2 of an integer.
    width: usize,
    /// Bytes of a frame.
    frame: usize,
    /// One of the integers, in the file's unit.
    scale: f32,
}

impl<'a> Points<'a> {
    fn new(words: Words<'a>) -> Self {
        let word = |at: usize| usize::from(words.count(at));
        // A negative scale, the real number at byte 12, says that the points are real numbers.
        let scale = words.real(12);
        let width = if scale < 0.0 { 4 } else { 2 };
        let frame = width * (4 * word(2) + word(4));
        Self { words, count: word(2), start: BLOCK * word(16).saturating_sub(1), width, frame, scale }
    }

    /// The number of frames.
    fn frame_count(&self, parameters: &Parameters, path: &Path) -> Result<usize, Diagnostic> {
        let bytes = self.words.bytes.len();
        // The header counts from the first to the last frame; both wrap.
        let header = self.words.count(8).wrapping_sub(self.words.count(6)).wrapping_add(1);
        let header = if self.words.count(8) == u16::MAX { u16::MAX } else { header };
        if self.count * usize::from(header) > bytes {
            let defect = format!("the header counts {} points in {header} frames", self.count);
            let reason = format!("the file has {bytes} bytes, and a point takes 8 at least");
            return Err(Diagnostic::file(path, defect, reason, EXPORT));
        }
        let counts = Announced::counts(parameters, header.into());
        let zeros = self.words.bytes.iter().rev().take_while(|byte| **byte == 0).count();
        let announced = Announced { counts, frame: self.frame, bytes: bytes.saturating_sub(self.start), zeros };
        if self.count == 0 {
            return Ok(0);
        }
        announced.frame_count().map_err(|(announced, capacity)| match capacity < announced {
            true => {
                let defect = format!("the file ends in frame {capacity}, and its header has {announced}");
                Diagnostic::file(path, defect, "the file was cut", "copy it again")
            }
            false => {
                let defect = format!("the file holds {capacity} frames, and its header has {announced}");
                Diagnostic::file(path, defect, "which of them were recorded cannot be known", EXPORT)
            }
        })
    }

    /// A point, in the file's unit; none where it was lost.
    fn point_position(&self, frame: usize, point: usize) -> Option<Point3> {
        let offset = self.start + frame * self.frame + 4 * self.width * point;
        let word = |k: usize| match self.width {
            4 => self.words.real(offset + 4 * k),
            _ => f32::from(self.words.integer(offset + 2 * k)),
        };
        let coordinates = [0, 1, 2].map(word);
        if word(3) < 0.0 || coordinates == [0.0; 3] {
            return None;
        }
        Some(coordinates.map(|x| f64::from(if self.width == 4 { x } else { x * self.scale })))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use words::Processor;

    /// The header of two points and `analogue` words in frames 1 to 4, with its parameters in the third block and its data in the
    /// fourth, as a `processor` writes it; the bytes of its `scale` begin at byte 12.
    fn header(processor: u8, analogue: u16, scale: [u8; 4]) -> Vec<u8> {
        let mut bytes = vec![0; 4 * BLOCK];
        (bytes[0], bytes[1], bytes[2 * BLOCK + 3]) = (3, KEY, processor);
        for (at, word) in [(2, 2_u16), (4, analogue), (6, 1), (8, 4), (16, 4)] {
            let pair = if processor == 86 { word.to_be_bytes() } else { word.to_le_bytes() };
            bytes[at..at + 2].copy_from_slice(&pair);
        }
        bytes[12..16].copy_from_slice(&scale);
        bytes
    }

    #[test]
    fn a_negative_scale_says_real_numbers_and_a_positive_one_integers() {
        for (processor, kind, [real, integer]) in [
            (84, Processor::Intel, [(-0.01_f32).to_le_bytes(), 0.1_f32.to_le_bytes()]),
            (86, Processor::Mips, [(-0.01_f32).to_be_bytes(), 0.1_f32.to_be_bytes()]),
        ] {
            // four words a point and three analogue ones a frame
            for (scale, width, frame) in [(real, 4, 44), (integer, 2, 22)] {
                let bytes = header(processor, 3, scale);
                let points = Points::new(Words::new(&bytes, 2 * BLOCK));
                assert_eq!([points.start, points.width, points.frame, points.count], [3 * BLOCK, width, frame, 2]);
                assert_eq!(points.words.processor, kind);
            }
        }
    }

    #[test]
    fn integers_are_scaled_and_lost_where_the_fourth_is_negative_or_all_are_zero() {
        let mut bytes = header(84, 3, 0.5_f32.to_le_bytes());
        for (frame, point, words) in [(0, 0, [20_i16, -6, 2, 0]), (1, 0, [0, 0, 0, 0]), (2, 1, [20, 1, 1, -1])] {
            let at = 3 * BLOCK + 22 * frame + 8 * point;
            let written: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
            bytes[at..at + 8].copy_from_slice(&written);
        }
        let points = Points::new(Words::new(&bytes, 2 * BLOCK));
        assert_eq!(points.point_position(0, 0), Some([10.0, -3.0, 1.0]));
        assert_eq!([points.point_position(1, 0), points.point_position(2, 1)], [None, None]);
    }
}
