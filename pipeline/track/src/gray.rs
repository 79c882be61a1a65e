//! Grey pictures of 8 bits.

use std::io::Cursor;

/// A grey picture of `width` × `height` pixels; pixel (x, y) is at `pixels[y * width + x]`, 0 is black, 255 is white.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Gray {
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Grey levels, `height` × `width`.
    pub pixels: Vec<u8>,
}

/// Why bytes are no picture, or a picture no bytes.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The bytes are not a PNG that can be read, or could not be made.
    #[error("a picture cannot be converted\n  why: {0}\n  do:  give an 8-bit grey PNG")]
    Png(#[from] image::ImageError),
}

impl Gray {
    /// A picture of one grey level.
    pub fn filled(width: usize, height: usize, level: u8) -> Self {
        Self { width, height, pixels: vec![level; width * height] }
    }

    /// A picture from a function of (x, y), in pixels, to a grey level; levels are rounded and held to 0 … 255.
    pub fn from_fn(width: usize, height: usize, mut level: impl FnMut(usize, usize) -> f64) -> Self {
        let mut pixels = Vec::with_capacity(width * height);
        for y in 0..height {
            pixels.extend((0..width).map(|x| level(x, y).round().clamp(0.0, 255.0) as u8));
        }
        Self { width, height, pixels }
    }

    /// The grey level of pixel (x, y), which must lie inside.
    pub fn at(&self, x: usize, y: usize) -> f64 {
        f64::from(self.pixels[y * self.width + x])
    }

    /// Whether (x, y) (px) lies at least `margin` pixels inside the outermost pixel centres.
    pub fn holds(&self, [x, y]: si::Point2, margin: f64) -> bool {
        let (right, bottom) = (self.width as f64 - 1.0, self.height as f64 - 1.0);
        x >= margin && y >= margin && x <= right - margin && y <= bottom - margin
    }

    /// The grey level at (x, y) (px), linear between pixel centres, the border's level outside.
    pub fn level(&self, [x, y]: si::Point2) -> f64 {
        let x = x.clamp(0.0, self.width as f64 - 1.0);
        let y = y.clamp(0.0, self.height as f64 - 1.0);
        let (left, top) = (x as usize, y as usize);
        let (right, bottom) = ((left + 1).min(self.width - 1), (top + 1).min(self.height - 1));
        let (u, v) = (x - left as f64, y - top as f64);
        let upper = self.at(left, top) * (1.0 - u) + self.at(right, top) * u;
        let lower = self.at(left, bottom) * (1.0 - u) + self.at(right, bottom) * u;
        upper * (1.0 - v) + lower * v
    }

    /// The part from (left, top) of at most `width` × `height` pixels, cut where the picture ends.
    pub fn crop(&self, left: usize, top: usize, width: usize, height: usize) -> Self {
        let right = (left + width).min(self.width);
        let bottom = (top + height).min(self.height);
        let (left, top) = (left.min(right), top.min(bottom));
        let mut pixels = Vec::with_capacity((right - left) * (bottom - top));
        (top..bottom).for_each(|y| pixels.extend_from_slice(&self.pixels[y * self.width..][left..right]));
        Self { width: right - left, height: bottom - top, pixels }
    }

    /// The picture as the bytes of an 8-bit grey PNG.
    ///
    /// # Errors
    /// [`PictureError`] when the picture is empty.
    pub fn to_png(&self) -> Result<Vec<u8>, PictureError> {
        let mut bytes = Vec::new();
        image::write_buffer_with_format(
            &mut Cursor::new(&mut bytes),
            &self.pixels,
            self.width as u32,
            self.height as u32,
            image::ExtendedColorType::L8,
            image::ImageFormat::Png,
        )?;
        Ok(bytes)
    }

    /// A picture from the bytes of a PNG; colours become their luma.
    ///
    /// # Errors
    /// [`PictureError`] when the bytes are not a PNG.
    pub fn from_png(bytes: &[u8]) -> Result<Self, PictureError> {
        let luma = image::load_from_memory_with_format(bytes, image::ImageFormat::Png)?.into_luma8();
        Ok(Self { width: luma.width() as usize, height: luma.height() as usize, pixels: luma.into_raw() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_survives_png() {
        let picture = Gray::from_fn(31, 17, |x, y| (x * 7 + y * 11) as f64 % 256.0);
        assert_eq!(Gray::from_png(&picture.to_png().unwrap()).unwrap(), picture);
    }

    #[test]
    fn a_slope_is_met_between_pixels() {
        let slope = Gray::from_fn(20, 10, |x, y| 3.0 * x as f64 + 5.0 * y as f64);
        assert!((slope.level([4.25, 3.5]) - (12.75 + 17.5)).abs() < 1e-12);
        assert_eq!(slope.crop(4, 3, 100, 2).at(1, 1), 35.0);
        assert_eq!(slope.crop(4, 3, 100, 2).width, 16);
    }
}
