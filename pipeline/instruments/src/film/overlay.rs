//! Overlay: tracks drawn over the film, as a strip of a few frames and, when requested, as a film.

use std::path::{Path, PathBuf};

use si::Point2;
use track::Gray;
use track::klt::Observation;
use track::video::{Info, Quality, Writer};

use crate::{cannot_write, write_result};
use diagnostics::Result;

/// Frames of the strip.
const STRIP: usize = 6;
/// Half the length of a cross and its gap, px.
const ARM: i64 = 14;
const GAP: i64 = 5;
/// Its film.
pub const FILM: &str = "overlay.mp4";
/// The film until it is complete.
const UNFINISHED: &str = "overlay.unfinished.mp4";
/// Of the film.
const QUALITY: Quality = Quality::Quantiser(24);

/// The overlay being drawn.
pub struct Overlay {
    folder: PathBuf,
    every: usize,
    frame: usize,
    strip: Vec<Gray>,
    film: Option<Writer>,
}

impl Overlay {
    /// Starts an overlay; with `film` also as a film.
    pub fn begin(folder: &Path, info: Info, film: bool) -> Result<Self> {
        let open = || Writer::create(&folder.join(UNFINISHED), (info.width, info.height), info.rate, QUALITY);
        let film = film.then(open).transpose()?;
        let every = info.frames.div_ceil(STRIP).max(1);
        Ok(Self { folder: folder.into(), every, frame: 0, strip: Vec::new(), film })
    }

    /// Draws one frame.
    pub(crate) fn draw_frame(&mut self, picture: &Gray, observations: &[Observation]) -> Result<()> {
        let in_strip = self.frame.is_multiple_of(self.every);
        self.frame += 1;
        if !in_strip && self.film.is_none() {
            return Ok(());
        }
        let mut drawn = picture.clone();
        observations.iter().filter(|o| o.seen).for_each(|o| draw_cross(&mut drawn, o.at));
        if let Some(film) = &mut self.film {
            film.push(&drawn)?;
        }
        if in_strip {
            self.strip.push(half_size(&drawn));
        }
        Ok(())
    }

    /// Writes the strip and ends the film.
    pub fn end(mut self) -> Result<()> {
        let width = self.strip.first().map_or(0, |p| p.width);
        let height = self.strip.iter().map(|p| p.height).sum();
        let pixels = std::mem::take(&mut self.strip).into_iter().flat_map(|p| p.pixels).collect();
        let png = Gray { width, height, pixels }.to_png()?;
        write_result(&self.folder, "strip.png", png)?;
        let Some(film) = self.film.take() else { return Ok(()) };
        film.finish()?;
        let (from, to) = (self.folder.join(UNFINISHED), self.folder.join(FILM));
        std::fs::rename(from, &to).map_err(|e| cannot_write(&to, &e))
    }
}

impl Drop for Overlay {
    /// A run that fails leaves no part of a film.
    fn drop(&mut self) {
        drop(std::fs::remove_file(self.folder.join(UNFINISHED)));
    }
}

/// A white cross with a dark rim, open in its middle.
fn draw_cross(picture: &mut Gray, centre: Point2) {
    let [x, y] = centre.map(|c| c.round() as i64);
    for (width, level) in [(1, 0), (0, 255)] {
        for offset in (GAP..=ARM).flat_map(|k| [k, -k]) {
            for breadth in -width..=width {
                for (column, row) in [(x + offset, y + breadth), (x + breadth, y + offset)] {
                    let (is_inside, pixel) = (column >= 0 && row >= 0, (column as usize, row as usize));
                    if is_inside && pixel.0 < picture.width && pixel.1 < picture.height {
                        picture.pixels[pixel.1 * picture.width + pixel.0] = level;
                    }
                }
            }
        }
    }
}

/// Half as wide and high: the mean of four pixels each.
fn half_size(picture: &Gray) -> Gray {
    Gray::from_fn(picture.width / 2, picture.height / 2, |x, y| {
        [(0, 0), (1, 0), (0, 1), (1, 1)].iter().map(|(i, j)| picture.pixel_level(2 * x + i, 2 * y + j)).sum::<f64>()
            / 4.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of the picture of a cross at a point: `#` is white, `.` dark, and a space as it was.
    fn drawn([width, height]: [usize; 2], at: Point2) -> Vec<String> {
        let mut picture = Gray { width, height, pixels: vec![100; width * height] };
        draw_cross(&mut picture, at);
        let letter = |level: &u8| match level {
            255 => '#',
            0 => '.',
            _ => ' ',
        };
        picture.pixels.chunks(width).map(|row| row.iter().map(letter).collect()).collect()
    }

    #[test]
    fn a_cross_has_four_arms_with_a_rim_and_an_open_middle() {
        let rows = drawn([31, 31], [15.2, 14.8]);
        // an arm of ten pixels from the fifth to the fourteenth on either side
        let along = format!(" {}{}{} ", "#".repeat(10), " ".repeat(9), "#".repeat(10));
        let rim = format!(" {}{}{} ", ".".repeat(10), " ".repeat(9), ".".repeat(10));
        assert_eq!([&rows[14], &rows[15], &rows[16]], [&rim, &along, &rim]);
        let column = |x: usize| rows.iter().map(|row| row.chars().nth(x).unwrap()).collect::<String>();
        assert_eq!([column(14), column(15), column(16)], [rim.clone(), along, rim]);
        assert_eq!(rows.concat().chars().filter(|letter| *letter != ' ').count(), 4 * 3 * 10);
    }

    #[test]
    fn a_cross_at_the_border_is_cut_there() {
        // at the first pixel: two arms, whose rims outside are missing
        let first = drawn([20, 20], [0.0, 0.0]);
        assert_eq!(first[0], format!("{}{}{}", " ".repeat(5), "#".repeat(10), " ".repeat(5)));
        assert_eq!(first[1], format!("{}{}{}", " ".repeat(5), ".".repeat(10), " ".repeat(5)));
        assert_eq!(first.concat().chars().filter(|letter| *letter != ' ').count(), 2 * 2 * 10);
        // at the last one the same, the other way
        let last = drawn([20, 20], [19.0, 19.0]);
        let turned: Vec<String> = first.iter().rev().map(|row| row.chars().rev().collect()).collect();
        assert_eq!(last, turned);
    }

    #[test]
    fn the_strip_holds_six_frames_at_even_distances_half_as_large_with_what_was_seen() {
        let folder = std::env::temp_dir().join(format!("strip-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let mut overlay =
            Overlay::begin(&folder, Info { width: 40, height: 32, frames: 18, rate: 60.0 }, false).unwrap();
        for frame in 0..18 {
            // columns of 0 and 4 grey levels more than ten a frame: half as large, 2 more
            let picture = Gray::from_fn(40, 32, |x, _| f64::from(10 * frame + 4 * (x as i32 % 2)));
            let observation = |at, seen| Observation { at, covariance: [[0.0; 2]; 2], residual: 0.0, seen };
            overlay
                .draw_frame(&picture, &[observation([20.0, 16.0], frame == 6), observation([0.0, 0.0], false)])
                .unwrap();
        }
        overlay.end().unwrap();
        let strip = Gray::from_png(&std::fs::read(folder.join("strip.png")).unwrap()).unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!((strip.width, strip.height), (20, 6 * 16));
        for (place, frame) in [0, 3, 6, 9, 12, 15].into_iter().enumerate() {
            assert_eq!(strip.pixel_level(0, 16 * place), f64::from(10 * frame + 2), "frame {frame}");
            // a white arm and the half of its dark rim
            let marked = strip.pixel_level(14, 16 * place + 8) != f64::from(10 * frame + 2);
            assert_eq!(marked, frame == 6, "frame {frame}");
        }
    }
}
