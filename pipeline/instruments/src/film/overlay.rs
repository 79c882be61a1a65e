//! Overlay: tracks drawn over the film, as a strip of a few frames and, when requested, as a film.

use std::path::{Path, PathBuf};

use si::Point2;
use track::Gray;
use track::klt::Observation;
use track::video::{Info, Quality, Writer};

use crate::{cannot_write, write};
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
    pub fn frame(&mut self, picture: &Gray, observations: &[Observation]) -> Result<()> {
        let wanted = self.frame.is_multiple_of(self.every);
        self.frame += 1;
        if !wanted && self.film.is_none() {
            return Ok(());
        }
        let mut drawn = picture.clone();
        observations.iter().filter(|o| o.seen).for_each(|o| cross(&mut drawn, o.at));
        if let Some(film) = &mut self.film {
            film.push(&drawn)?;
        }
        if wanted {
            self.strip.push(halved(&drawn));
        }
        Ok(())
    }

    /// Writes the strip and ends the film.
    pub fn end(mut self) -> Result<()> {
        let width = self.strip.first().map_or(0, |p| p.width);
        let height = self.strip.iter().map(|p| p.height).sum();
        let pixels = std::mem::take(&mut self.strip).into_iter().flat_map(|p| p.pixels).collect();
        let png = Gray { width, height, pixels }.to_png()?;
        write(&self.folder, "strip.png", png)?;
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
fn cross(picture: &mut Gray, at: Point2) {
    let [x, y] = at.map(|c| c.round() as i64);
    for (width, level) in [(1, 0), (0, 255)] {
        for along in (GAP..=ARM).flat_map(|k| [k, -k]) {
            for aside in -width..=width {
                for (column, row) in [(x + along, y + aside), (x + aside, y + along)] {
                    let (inside, place) = (column >= 0 && row >= 0, (column as usize, row as usize));
                    if inside && place.0 < picture.width && place.1 < picture.height {
                        picture.pixels[place.1 * picture.width + place.0] = level;
                    }
                }
            }
        }
    }
}

/// Half as wide and high: the mean of four pixels each.
fn halved(picture: &Gray) -> Gray {
    Gray::from_fn(picture.width / 2, picture.height / 2, |x, y| {
        [(0, 0), (1, 0), (0, 1), (1, 1)].iter().map(|(i, j)| picture.at(2 * x + i, 2 * y + j)).sum::<f64>() / 4.0
    })
}
