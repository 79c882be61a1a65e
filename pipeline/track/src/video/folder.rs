//! A folder of pictures as a film: PNG files in the order of their names, and `times.csv` with the time of each.

use super::{Frame, Info, VideoError};
use crate::Gray;
use si::Second;
use std::path::{Path, PathBuf};

/// The file of times: a line a picture, seconds; a first line that is no number is a title.
const TIMES: &str = "times.csv";

/// Pictures, one after another.
pub(super) struct Folder {
    files: Vec<PathBuf>,
    times: Vec<Second>,
    size: (usize, usize),
    shown: usize,
}

impl Folder {
    /// Opens a folder.
    pub(super) fn open(path: &Path) -> Result<Self, VideoError> {
        let listed = std::fs::read_dir(path).map_err(|e| VideoError::reading(path, e))?;
        let listed: Result<Vec<PathBuf>, _> = listed.map(|entry| entry.map(|e| e.path())).collect();
        let mut files = listed.map_err(|e| VideoError::reading(path, e))?;
        files.retain(|f| f.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")));
        files.sort();
        let text = std::fs::read_to_string(path.join(TIMES)).unwrap_or_default();
        let times: Vec<Second> = text.lines().filter_map(|line| line.trim().parse().ok()).collect();
        let rising = times.windows(2).all(|pair| pair[0] < pair[1]);
        if files.is_empty() || times.len() != files.len() || !rising {
            let (pictures, times) = (files.len(), times.len());
            return Err(VideoError::NoTimes { path: path.into(), pictures, times });
        }
        let first = picture(&files[0])?;
        Ok(Self { files, times, size: (first.width, first.height), shown: 0 })
    }

    pub(super) fn info(&self) -> Info {
        Info::of(self.size, &self.times)
    }

    pub(super) fn next(&mut self) -> Option<Result<Frame, VideoError>> {
        let index = self.shown;
        let file = self.files.get(index)?;
        self.shown += 1;
        let (expected, why) = (self.files.len(), "it has another size than the first".to_owned());
        Some(picture(file).and_then(|gray| match (gray.width, gray.height) == self.size {
            true => Ok(Frame { index, time: self.times[index] - self.times[0], gray }),
            false => Err(VideoError::Damaged { path: file.clone(), frame: index, expected, why }),
        }))
    }
}

fn picture(file: &Path) -> Result<Gray, VideoError> {
    let bytes = std::fs::read(file).map_err(|e| VideoError::reading(file, e))?;
    let damaged = |e: crate::PictureError| VideoError::Damaged {
        path: file.into(),
        frame: 0,
        expected: 1,
        why: e.to_string().replace('\n', " "),
    };
    Gray::from_png(&bytes).map_err(damaged)
}
