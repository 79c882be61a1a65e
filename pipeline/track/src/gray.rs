//! Grey pictures of 8 bits.

use crate::limits::{MAX_DECODED_BYTES, MAX_PIXELS, MAX_SIDE, is_picture_size};
use image::codecs::jpeg::JpegDecoder;
use image::codecs::png::PngDecoder;
use image::metadata::Orientation;
use image::{ColorType, DynamicImage, ImageDecoder, Limits};
use std::io::{BufRead, Cursor, Read, Seek};

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

/// The first bytes of a JPEG.
const JPEG: [u8; 3] = [0xff, 0xd8, 0xff];

/// Why bytes are no picture, or a picture no bytes.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The bytes are no PNG or JPEG that can be read, or could not be made.
    #[error("a picture cannot be converted\n  why: {}\n  do:  {}", self.why(), self.action())]
    Png(#[from] image::ImageError),
    /// A picture without pixels, or with too many.
    #[error("a picture of {width} × {height} px cannot be read\n  why: {}\n  do:  {}", self.why(), self.action())]
    Size {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// A picture with another number of grey levels than pixels.
    #[error("a picture of {width} × {height} px cannot be used\n  why: {}\n  do:  {}", self.why(), self.action())]
    Levels {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// Grey levels.
        levels: usize,
    },
    /// A picture with brighter pixels than the depth of the film's first.
    #[error("a picture of more than {bits} bits cannot be read\n  why: {}\n  do:  {}", self.why(), self.action())]
    Depth {
        /// Bits of the first.
        bits: u32,
        /// Its brightest level.
        brightest: u16,
    },
    /// A picture that takes too much memory while it is decoded.
    #[error("a picture of {bytes} bytes cannot be read\n  why: {}\n  do:  {}", self.why(), self.action())]
    Memory {
        /// Its bytes before it is converted to grey levels.
        bytes: u64,
    },
}

impl PictureError {
    /// What was found against what can be.
    pub(crate) fn why(&self) -> String {
        match self {
            Self::Png(source) => source.to_string(),
            Self::Size { width, height } => {
                let megapixels = MAX_PIXELS / 1_000_000;
                format!("it has {width} × {height} px; the limits are 1 … {MAX_SIDE} px a side and {megapixels} Mpx")
            }
            Self::Levels { levels, .. } => format!("it has {levels} grey levels; each pixel has one"),
            Self::Depth { bits, brightest } => {
                format!("its brightest pixel is {brightest}, and all of the first picture lie within {bits} bits")
            }
            Self::Memory { bytes } => format!("it takes {bytes} bytes when decoded; the limit is {MAX_DECODED_BYTES}"),
        }
    }

    /// The next move.
    pub(crate) fn action(&self) -> &'static str {
        match self {
            Self::Png(_) => "give an 8-bit PNG or JPEG",
            Self::Size { .. } => "scale the picture, or cut out the part with the markers",
            Self::Levels { .. } => "give width × height grey levels",
            Self::Depth { .. } => "convert all pictures to 8 bits with one factor",
            Self::Memory { .. } => "convert it to an 8-bit grey PNG",
        }
    }
}

impl Gray {
    /// A picture of these grey levels, row after row.
    ///
    /// # Errors
    /// [`PictureError::Levels`] when there are not `width` × `height`, or none.
    pub fn new(width: usize, height: usize, pixels: Vec<u8>) -> Result<Self, PictureError> {
        let picture = Self { width, height, pixels };
        picture.check()?;
        Ok(picture)
    }

    /// Whether each pixel has its grey level: the fields can be set one by one.
    ///
    /// # Errors
    /// [`PictureError::Levels`] when there are not `width` × `height`, or none.
    pub fn check(&self) -> Result<(), PictureError> {
        let Self { width, height, ref pixels } = *self;
        match !pixels.is_empty() && width.checked_mul(height) == Some(pixels.len()) {
            true => Ok(()),
            false => Err(PictureError::Levels { width, height, levels: pixels.len() }),
        }
    }

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
    pub fn pixel_level(&self, x: usize, y: usize) -> f64 {
        f64::from(self.pixels[y * self.width + x])
    }

    /// Whether (x, y) (px) lies at least `margin` pixels inside the outermost pixel centres.
    pub(crate) fn holds_with_margin(&self, [x, y]: si::Point2, margin: f64) -> bool {
        let (right, bottom) = (self.width as f64 - 1.0, self.height as f64 - 1.0);
        x >= margin && y >= margin && x <= right - margin && y <= bottom - margin
    }

    /// The grey level at (x, y) (px), linear between pixel centres, the border's level outside.
    pub fn interpolated_level(&self, [x, y]: si::Point2) -> f64 {
        let x = x.clamp(0.0, self.width as f64 - 1.0);
        let y = y.clamp(0.0, self.height as f64 - 1.0);
        let (left, top) = (x as usize, y as usize);
        let (right, bottom) = ((left + 1).min(self.width - 1), (top + 1).min(self.height - 1));
        let (u, v) = (x - left as f64, y - top as f64);
        let upper = self.pixel_level(left, top) * (1.0 - u) + self.pixel_level(right, top) * u;
        let lower = self.pixel_level(left, bottom) * (1.0 - u) + self.pixel_level(right, bottom) * u;
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
    /// [`PictureError`] when the picture is empty, or lacks grey levels.
    pub fn to_png(&self) -> Result<Vec<u8>, PictureError> {
        self.check()?;
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
    /// [`PictureError`] when the bytes are not a PNG, or one of too many pixels.
    pub fn from_png(bytes: &[u8]) -> Result<Self, PictureError> {
        Self::read_png(Cursor::new(bytes), &mut Depth::default())
    }

    /// A picture from a PNG or a JPEG that is being read, by its first bytes.
    pub(crate) fn read_image(mut from: impl BufRead + Seek, depth: &mut Depth) -> Result<Self, PictureError> {
        let is_jpeg = from.fill_buf().map_err(image::ImageError::from)?.starts_with(&JPEG);
        if is_jpeg { Self::read_jpeg(from) } else { Self::read_png(from, depth) }
    }

    fn read_jpeg(from: impl BufRead + Seek) -> Result<Self, PictureError> {
        let decoder = JpegDecoder::new(from)?;
        let (width, height) = decoder.dimensions();
        if !is_picture_size(width.into(), height.into()) {
            return Err(PictureError::Size { width, height });
        }
        Self::decode_luma(decoder, &mut Depth::default())
    }

    /// A picture from a PNG that is being read; its size is held against the limits before a pixel is decoded.
    pub(crate) fn read_png(mut from: impl BufRead + Seek, depth: &mut Depth) -> Result<Self, PictureError> {
        // before the decoder sees it: its own limits name no number
        if let Some([width, height]) = png_size(&mut from).map_err(image::ImageError::from)?
            && !is_picture_size(width.into(), height.into())
        {
            return Err(PictureError::Size { width, height });
        }
        let mut limits = Limits::no_limits();
        limits.max_alloc = Some(MAX_DECODED_BYTES);
        Self::decode_luma(PngDecoder::with_limits(from, limits)?, depth)
    }

    /// The luma of a picture, upright by its EXIF.
    fn decode_luma(mut decoder: impl ImageDecoder, depth: &mut Depth) -> Result<Self, PictureError> {
        let bytes = decoder.total_bytes();
        if bytes > MAX_DECODED_BYTES {
            return Err(PictureError::Memory { bytes });
        }
        // an EXIF that cannot be read says nothing
        let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
        let mut picture = depth.spread_levels(DynamicImage::from_decoder(decoder)?)?;
        picture.apply_orientation(orientation);
        let luma = picture.into_luma8();
        let (width, height) = (luma.width() as usize, luma.height() as usize);
        Ok(Self { width, height, pixels: luma.into_raw() })
    }
}

/// Bits of the levels of a film's pictures: cameras of 10, 12 and 14 bits save them in files of 16.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Depth(Option<u32>);

/// Bits of cameras.
const DEPTHS: [u32; 4] = [10, 12, 14, 16];

impl Depth {
    /// A picture of 16 bits with its levels spread over all of them; the first picture says how many bits it has.
    fn spread_levels(&mut self, picture: DynamicImage) -> Result<DynamicImage, PictureError> {
        if !matches!(picture.color(), ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16) {
            return Ok(picture);
        }
        let mut luma = picture.into_luma16();
        let brightest = luma.iter().copied().max().unwrap_or(0);
        let holds = |bits: &u32| u32::from(brightest) < 1 << bits;
        // By the first picture and not by each: a dark picture would be spread by more bits, and grey levels would jump
        // from frame to frame.
        let bits = *self.0.get_or_insert_with(|| DEPTHS.into_iter().find(holds).unwrap_or(16));
        if !holds(&bits) {
            return Err(PictureError::Depth { bits, brightest });
        }
        luma.iter_mut().for_each(|level| *level <<= 16 - bits);
        Ok(DynamicImage::ImageLuma16(luma))
    }
}

/// Width and height in the header of a PNG (IHDR, its first chunk), none where there is no such header; the reader is set back.
fn png_size(from: &mut (impl BufRead + Seek)) -> std::io::Result<Option<[u32; 2]>> {
    let mut head = Vec::with_capacity(24);
    from.by_ref().take(24).read_to_end(&mut head)?;
    from.rewind()?;
    let number = |bytes: &[u8]| bytes.iter().fold(0, |sum, &byte| sum << 8 | u32::from(byte));
    Ok((head.len() == 24 && &head[12..16] == b"IHDR").then(|| [number(&head[16..20]), number(&head[20..])]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_with_another_number_of_levels_than_pixels_is_refused() {
        for (width, height, levels) in [(4, 3, 11), (4, 3, 13), (0, 0, 0), (usize::MAX, 2, 6)] {
            let error = Gray::new(width, height, vec![0; levels]).unwrap_err();
            assert!(matches!(error, PictureError::Levels { .. }), "{error}");
            assert!(error.to_string().contains(&format!("why: it has {levels} grey levels")), "{error}");
            assert!(Gray { width, height, pixels: vec![0; levels] }.to_png().is_err());
        }
        assert_eq!(Gray::new(4, 3, vec![7; 12]).unwrap(), Gray::filled(4, 3, 7));
    }

    #[test]
    fn a_picture_survives_png() {
        let picture = Gray::from_fn(31, 17, |x, y| (x * 7 + y * 11) as f64 % 256.0);
        assert_eq!(Gray::from_png(&picture.to_png().unwrap()).unwrap(), picture);
    }

    /// A chunk of a PNG with its check sum.
    fn chunk(name: &[u8; 4], content: &[u8]) -> Vec<u8> {
        let body = [&name[..], content].concat();
        let step = |crc: u32, _| if crc & 1 == 1 { 0xedb8_8320 ^ crc >> 1 } else { crc >> 1 };
        let crc = body.iter().fold(u32::MAX, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), step));
        [&(content.len() as u32).to_be_bytes(), &body[..], &(!crc).to_be_bytes()].concat()
    }

    /// A PNG of 8 bits with a header and no pixels; the kind of colour is 0 for grey and 2 for red, green and blue.
    fn without_pixels(width: u32, height: u32, colour: u8) -> Vec<u8> {
        let size = [width, height].map(u32::to_be_bytes).concat();
        let header = chunk(b"IHDR", &[&size[..], &[8, colour, 0, 0, 0]].concat());
        [b"\x89PNG\r\n\x1a\n".to_vec(), header, chunk(b"IDAT", &[])].concat()
    }

    #[test]
    fn a_picture_of_too_many_pixels_is_refused_from_its_header() {
        for (width, height) in [(22_000, 22_000), (1, 100_000_000), (0, 7), (u32::MAX, u32::MAX)] {
            let error = Gray::from_png(&without_pixels(width, height, 0)).unwrap_err();
            assert!(matches!(error, PictureError::Size { .. }), "{error}");
            assert!(error.to_string().contains("200 Mpx"), "{error}");
        }
    }

    #[test]
    fn a_picture_of_too_many_bytes_is_refused_before_it_is_decoded() {
        let error = Gray::from_png(&without_pixels(15_000, 13_000, 2)).unwrap_err();
        assert!(matches!(error, PictureError::Memory { bytes: 585_000_000 }), "{error}");
        // with few enough, what is missing is the pixels
        assert!(matches!(Gray::from_png(&without_pixels(150, 130, 2)), Err(PictureError::Png(_))));
    }

    /// A grey PNG of 16 bits.
    fn deep(levels: &[u16]) -> Vec<u8> {
        let (mut bytes, raw) = (Vec::new(), levels.iter().flat_map(|level| level.to_ne_bytes()).collect::<Vec<u8>>());
        let size = (levels.len() as u32, 1);
        let form = (image::ExtendedColorType::L16, image::ImageFormat::Png);
        image::write_buffer_with_format(&mut Cursor::new(&mut bytes), &raw, size.0, size.1, form.0, form.1).unwrap();
        bytes
    }

    #[test]
    fn cameras_of_fewer_bits_than_their_files_fill_all_grey_levels() {
        for (top, bits) in [(1023_u16, 10), (4095, 12), (16_383, 14), (65_535, 16)] {
            let levels = [0, 1, 2, 4].map(|quarter| (u32::from(top) * quarter / 4) as u16);
            let read = Gray::from_png(&deep(&levels)).unwrap();
            let off = read.pixels.iter().zip([0_u8, 64, 128, 255]).map(|(a, b)| a.abs_diff(b)).max().unwrap();
            assert!(off <= 1, "{bits}: {:?}", read.pixels);
        }
    }

    #[test]
    fn a_film_keeps_the_depth_of_its_first_picture() {
        let mut depth = Depth::default();
        let mut read = |levels: &[u16]| Gray::read_png(Cursor::new(deep(levels)), &mut depth);
        assert_eq!(read(&[0, 4095]).unwrap().pixels, [0, 255]);
        assert_eq!(read(&[0, 511]).unwrap().pixels, [0, 32], "a darker picture of the same camera");
        let said = read(&[0, 5000]).unwrap_err().to_string();
        assert!(said.contains("more than 12 bits") && said.contains("brightest pixel is 5000"), "{said}");
    }

    /// A JPEG of a dark left and a bright right half, 24 × 16 px, that its EXIF says is to be shown otherwise.
    fn oriented(orientation: u8) -> Gray {
        let gray = Gray::from_fn(24, 16, |u, _| if u < 12 { 40.0 } else { 200.0 });
        let mut jpeg = Vec::new();
        let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut jpeg, 95);
        image::ImageEncoder::write_image(encoder, &gray.pixels, 24, 16, image::ExtendedColorType::L8).unwrap();
        let tiff =
            [&b"Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0"[..], &[orientation, 0, 0, 0, 0, 0, 0]]
                .concat();
        let segment = [&[0xff, 0xe1][..], &(tiff.len() as u16 + 2).to_be_bytes(), &tiff].concat();
        let bytes = [&jpeg[..2], &segment, &jpeg[2..]].concat();
        Gray::read_image(Cursor::new(bytes), &mut Depth::default()).unwrap()
    }

    #[test]
    fn a_photograph_is_upright_by_its_exif() {
        let at = |orientation, x, y| oriented(orientation).pixel_level(x, y) > 120.0;
        assert_eq!([at(1, 2, 8), at(1, 21, 8), at(3, 2, 8), at(3, 21, 8)], [false, true, true, false]);
        // 6 is a quarter clockwise: what was left is up
        let turned = oriented(6);
        assert_eq!((turned.width, turned.height), (16, 24));
        assert_eq!([at(6, 8, 2), at(6, 8, 21), at(8, 8, 2), at(8, 8, 21)], [false, true, true, false]);
        assert_eq!([at(2, 2, 8), at(2, 21, 8)], [true, false], "a mirror");
    }

    #[test]
    fn a_slope_is_met_between_pixels() {
        let slope = Gray::from_fn(20, 10, |x, y| 3.0 * x as f64 + 5.0 * y as f64);
        assert!((slope.interpolated_level([4.25, 3.5]) - (12.75 + 17.5)).abs() < 1e-12);
        assert_eq!(slope.crop(4, 3, 100, 2).pixel_level(1, 1), 35.0);
        assert_eq!(slope.crop(4, 3, 100, 2).width, 16);
    }
}
