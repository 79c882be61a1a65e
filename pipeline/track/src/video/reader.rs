//! Decoding of a film to grey pictures, one after another; memory does not grow with its length.

use super::index::{self, Index};
use super::outermost::Source;
use super::{Frame, Info, Quarter, VideoError, avc, files};
use crate::Gray;
use openh264::OpenH264API;
use openh264::decoder::{DecodedYUV, Decoder, DecoderConfig, Flush};
use openh264::formats::YUVSource;
use std::collections::VecDeque;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// A film that is being read: an iterator of its frames in the order of showing.
pub struct Reader {
    path: PathBuf,
    file: File,
    index: Index,
    decoder: Decoder,
    /// Samples given to the decoder so far.
    fed: usize,
    /// Pictures made by the decoder so far, frames that are not displayed among them.
    made: usize,
    /// Pictures that the decoder held back until the end.
    delay: VecDeque<Gray>,
    ended: bool,
    packet: Vec<u8>,
}

impl Reader {
    /// Opens a film and checks that it is whole.
    ///
    /// # Errors
    /// [`VideoError`] when it is not there, not an MP4, cut short, or coded in another way than H.264.
    pub fn open(path: &Path) -> Result<Self, VideoError> {
        let (mut file, bytes) = files::open_file(path)?;
        let index = index::read_index(Source { path, file: &mut file, bytes })?;
        let config = DecoderConfig::new().flush_after_decode(Flush::NoFlush);
        let decoder = Decoder::with_api_config(OpenH264API::from_source(), config);
        let decoder = decoder.map_err(|e| damage_at(path, 0, &index, e.to_string()))?;
        let (delay, packet) = (VecDeque::new(), Vec::new());
        Ok(Self { path: path.into(), file, index, decoder, fed: 0, made: 0, delay, ended: false, packet })
    }

    /// Size, length and rate of the film.
    pub fn info(&self) -> Info {
        Info::of_times((self.index.width, self.index.height), &self.index.times)
    }

    /// Rotation with which its pictures are displayed; they are returned as coded.
    pub fn turn(&self) -> Quarter {
        self.index.turn
    }

    /// The next picture of the decoder, none when all have come.
    fn decode_picture(&mut self) -> Result<Option<Gray>, VideoError> {
        while self.fed < self.index.samples.len() {
            self.load_sample()?;
            let frame = self.fed;
            self.fed += 1;
            let decoded = self.decoder.decode(&self.packet);
            let decoded = decoded.map_err(|e| damage_at(&self.path, frame, &self.index, e.to_string()))?;
            if let Some(picture) = decoded {
                return Ok(Some(luma_picture(&picture)));
            }
        }
        if !self.ended {
            self.ended = true;
            let flushed = self.decoder.flush_remaining();
            let flushed = flushed.map_err(|e| damage_at(&self.path, self.made, &self.index, e.to_string()))?;
            self.delay = flushed.iter().map(luma_picture).collect();
        }
        Ok(self.delay.pop_front())
    }

    /// Puts sample `fed` into `packet` in the form of the decoder: start codes for lengths, parameter sets in front.
    fn load_sample(&mut self) -> Result<(), VideoError> {
        let sample = self.index.samples[self.fed];
        let mut coded = vec![0; sample.size as usize];
        let disk = |e| VideoError::reading_error(&self.path, e);
        self.file.seek(SeekFrom::Start(sample.offset)).map_err(disk)?;
        self.file.read_exact(&mut coded).map_err(disk)?;
        self.packet.clear();
        if self.fed == 0 {
            self.packet.extend_from_slice(&self.index.parameters);
        }
        let mut remaining = &coded[..];
        while !remaining.is_empty() {
            let refused = |why: String| damage_at(&self.path, self.fed, &self.index, why);
            let split = split_unit(remaining, self.index.length_bytes);
            let (unit, behind) =
                split.ok_or_else(|| refused(format!("its {} bytes do not fall into whole units", coded.len())))?;
            remaining = behind;
            avc::check_unit(&self.path, unit, || refused("its sequence parameter set is out of range".into()))?;
            self.packet.extend_from_slice(&super::writer::START_CODE);
            self.packet.extend_from_slice(unit);
        }
        Ok(())
    }

    /// The next picture as frame `index` of the film.
    fn next_frame(&mut self, index: usize) -> Result<Frame, VideoError> {
        let decoded_count = self.made;
        match self.decode_picture()? {
            Some(gray) if (gray.width, gray.height) != (self.index.width, self.index.height) => {
                let why = format!("it has {} × {} px, the film another size", gray.width, gray.height);
                Err(damage_at(&self.path, decoded_count, &self.index, why))
            }
            Some(gray) => Ok(Frame { index, time: self.index.times[index], gray }),
            None => Err(damage_at(
                &self.path,
                decoded_count,
                &self.index,
                format!("the decoder made {decoded_count} pictures in all"),
            )),
        }
    }
}

impl Iterator for Reader {
    type Item = Result<Frame, VideoError>;

    fn next(&mut self) -> Option<Self::Item> {
        let displayed = self.index.displayed.clone();
        while self.made < displayed.end {
            // frames in front of the edit are references of later ones: decoded, and then left out
            let index = self.made.saturating_sub(displayed.start);
            let item = self.next_frame(index);
            let is_displayed = displayed.contains(&self.made);
            self.made = if item.is_ok() { self.made + 1 } else { displayed.end };
            if is_displayed || item.is_err() {
                return Some(item);
            }
        }
        None
    }
}

/// The first NAL unit of a sample without the length in front of it, and the rest; none when the length reaches past the end.
fn split_unit(coded: &[u8], length_bytes: usize) -> Option<(&[u8], &[u8])> {
    let (length, rest) = coded.split_at_checked(length_bytes)?;
    let length = length.iter().fold(0, |sum, &b| sum << 8 | usize::from(b));
    rest.split_at_checked(length)
}

/// Damage at a picture, numbered among the frames of the film.
fn damage_at(path: &Path, picture: usize, index: &Index, why: String) -> VideoError {
    let frame = picture.saturating_sub(index.displayed.start);
    VideoError::Damaged { path: path.into(), frame, expected: index.displayed.len(), why }
}

/// The luma of a decoded picture without the decoder's padding.
fn luma_picture(picture: &DecodedYUV) -> Gray {
    let ((width, height), (stride, _, _)) = (picture.dimensions(), picture.strides());
    let mut pixels = Vec::with_capacity(width * height);
    for row in picture.y().chunks(stride).take(height) {
        pixels.extend_from_slice(&row[..width]);
    }
    Gray { width, height, pixels }
}
