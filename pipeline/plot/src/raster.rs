//! Raster pictures: their PNG bytes, and base64 for the SVG.

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use crate::PlotError;

/// A picture: rows from the top, four bytes for each pixel (red, green, blue, alpha).
#[derive(Debug, Clone, PartialEq)]
pub struct Raster {
    /// Pixels in a row.
    pub width: usize,
    /// Pixels in a column.
    pub height: usize,
    /// height × width × 4.
    pub pixels: Vec<u8>,
}

impl Raster {
    /// The picture as a PNG file.
    pub fn to_png(&self) -> Result<Vec<u8>, PlotError> {
        encode_png(&self.pixels, self.width, self.height, ExtendedColorType::Rgba8)
    }
}

/// A grey picture (height × width, rows from the top) as a PNG file.
pub(crate) fn grey_png(pixels: &[u8], width: usize, height: usize) -> Result<Vec<u8>, PlotError> {
    encode_png(pixels, width, height, ExtendedColorType::L8)
}

fn encode_png(pixels: &[u8], width: usize, height: usize, kind: ExtendedColorType) -> Result<Vec<u8>, PlotError> {
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive)
        .write_image(pixels, width as u32, height as u32, kind)
        .map_err(|error| PlotError::Encoder { encoder: "png", source: error.into() })?;
    Ok(bytes)
}

/// Base64 of RFC 4648.
pub fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let byte_at = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let bits = byte_at(0) << 16 | byte_at(1) << 8 | byte_at(2);
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
    fn base64_agrees_with_the_examples_of_rfc_4648() {
        let examples = [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")];
        for (bytes, text) in examples {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }

    #[test]
    fn a_png_is_decoded_to_the_same_pixels() {
        let raster = Raster { width: 3, height: 2, pixels: (0..24).map(|i| i * 10).collect() };
        let read = image::load_from_memory(&raster.to_png().unwrap()).unwrap().to_rgba8();
        assert_eq!((read.width(), read.height(), read.into_raw()), (3, 2, raster.pixels));
    }

    #[test]
    fn a_picture_without_pixels_is_refused() {
        assert!(grey_png(&[], 0, 0).is_err());
    }
}
