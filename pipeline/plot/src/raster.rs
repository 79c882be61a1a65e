//! Pictures made of dots: their PNG bytes and the text that carries them inside of an SVG.
//!
//! Stands on: image. Never knows: what the picture shows.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use crate::PlotError;

/// A picture: rows from the top, four bytes a dot (red, green, blue, cover).
#[derive(Debug, Clone, PartialEq)]
pub struct Raster {
    /// Dots across.
    pub width: usize,
    /// Dots down.
    pub height: usize,
    /// height × width × 4.
    pub dots: Vec<u8>,
}

impl Raster {
    /// The picture as a PNG file.
    pub fn png(&self) -> Result<Vec<u8>, PlotError> {
        encode(&self.dots, self.width, self.height, ExtendedColorType::Rgba8)
    }
}

/// A grey picture (height × width, rows from the top) as a PNG file.
pub fn grey_png(dots: &[u8], width: usize, height: usize) -> Result<Vec<u8>, PlotError> {
    encode(dots, width, height, ExtendedColorType::L8)
}

fn encode(dots: &[u8], width: usize, height: usize, kind: ExtendedColorType) -> Result<Vec<u8>, PlotError> {
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive)
        .write_image(dots, width as u32, height as u32, kind)
        .map_err(|error| PlotError::Encoder { encoder: "png", reason: error.to_string() })?;
    Ok(bytes)
}

/// Bytes as text, six bits a letter, as RFC 4648 has it.
pub fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let at = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let bits = at(0) << 16 | at(1) << 8 | at(2);
        for place in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * place) & 63) as usize] as char;
            text.push(if place <= three.len() { letter } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_agrees_with_the_examples_of_its_standard() {
        let examples = [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")];
        for (bytes, text) in examples {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }

    #[test]
    fn a_png_reads_back_as_the_same_dots() {
        let raster = Raster { width: 3, height: 2, dots: (0..24).map(|i| i * 10).collect() };
        let read = image::load_from_memory(&raster.png().unwrap()).unwrap().to_rgba8();
        assert_eq!((read.width(), read.height(), read.into_raw()), (3, 2, raster.dots));
    }

    #[test]
    fn a_picture_of_no_dots_is_refused() {
        assert!(grey_png(&[], 0, 0).is_err());
    }
}
