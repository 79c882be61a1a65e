//! A film of any source: H.264 in an MP4, a folder of pictures, or what `ffmpeg` reads.

use super::folder::{self, Folder};
use super::pipe::{Pipe, Programs};
use super::reader::Reader;
use super::turn::Quarter;
use super::{Frame, Info, VideoError};
use crate::Gray;
use std::path::Path;

/// A film that is being read: an iterator of its frames in the order of showing, turned upright.
pub struct Film {
    source: Source,
    turn: Quarter,
}

enum Source {
    Mp4(Box<Reader>),
    Folder(Folder),
    Pipe(Pipe),
}

impl Film {
    /// Opens a film.
    ///
    /// # Errors
    /// [`VideoError`] when it is not there, damaged, cut short, or needs an `ffmpeg` that is not on the PATH.
    pub fn open(path: &Path) -> Result<Self, VideoError> {
        if path.is_dir() {
            return Ok(Self { source: Source::Folder(Folder::open(path)?), turn: Quarter::None });
        }
        let refused = match Reader::open(path) {
            Ok(reader) => return Ok(Self { turn: reader.turn(), source: Source::Mp4(Box::new(reader)) }),
            Err(refused) => refused,
        };
        match ffmpeg_options(&refused).zip(Programs::on_path()) {
            Some((options, both)) => {
                Ok(Self { source: Source::Pipe(Pipe::open(path, both, options)?), turn: Quarter::None })
            }
            None => Err(refused),
        }
    }

    /// Opens the recording of a board: a film, of which one frame in `every` is worth looking at, or a folder of photographs, of
    /// which each is. A photograph has no time; picture k of a folder without `times.csv` is that of second k. The second value is
    /// the number of frames from one that is worth looking at to the next.
    ///
    /// # Errors
    /// As [`Film::open`].
    pub fn open_board(path: &Path, every: usize) -> Result<(Self, usize), VideoError> {
        if folder::is_of_photographs(path) {
            let source = Source::Folder(Folder::open_photographs(path)?);
            return Ok((Self { source, turn: Quarter::None }, 1));
        }
        Ok((Self::open(path)?, every.max(1)))
    }

    /// The pictures of the frames with these numbers, in their order; none where the film ends before. `progress` receives the fraction done.
    ///
    /// # Errors
    /// [`VideoError`] when a frame up to the last of them is damaged.
    pub fn pictures(self, numbers: &[usize], progress: impl Fn(f64)) -> Result<Option<Vec<Gray>>, VideoError> {
        let last = numbers.iter().copied().max().unwrap_or(0);
        let mut pictures: Vec<Option<Gray>> = vec![None; numbers.len()];
        for frame in self.take(last + 1) {
            let frame = frame?;
            let wanted = pictures.iter_mut().zip(numbers).filter(|(_, number)| **number == frame.index);
            wanted.for_each(|(place, _)| *place = Some(frame.gray.clone()));
            progress(frame.index as f64 / last.max(1) as f64);
        }
        Ok(pictures.into_iter().collect())
    }

    /// Size, length and rate of the film, as it is shown.
    pub fn info(&self) -> Info {
        let info = match &self.source {
            Source::Mp4(reader) => reader.info(),
            Source::Folder(folder) => folder.info(),
            Source::Pipe(pipe) => pipe.info(),
        };
        let (width, height) = self.turn.size((info.width, info.height));
        Info { width, height, ..info }
    }
}

/// Options with which `ffmpeg` reads a film that was refused; none where the film itself is wrong, which `ffmpeg` may pass over.
fn ffmpeg_options(refused: &VideoError) -> Option<&'static [&'static str]> {
    match refused {
        VideoError::UnknownCodec { .. } | VideoError::NotMp4 { .. } => Some(&[]),
        VideoError::Unsupported { feature, .. } => Some(feature.filter_options()),
        _ => None,
    }
}

impl Iterator for Film {
    type Item = Result<Frame, VideoError>;

    fn next(&mut self) -> Option<Self::Item> {
        let frame = match &mut self.source {
            Source::Mp4(reader) => reader.next(),
            Source::Folder(folder) => folder.next(),
            Source::Pipe(pipe) => pipe.next(),
        };
        Some(frame?.map(|f| Frame { gray: self.turn.turn_picture(f.gray), ..f }))
    }
}
