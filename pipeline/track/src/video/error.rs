//! Errors of reading and writing films.

use super::Feature;
use crate::PictureError;
use crate::limits::{MAX_PIXELS, MAX_SIDE};
use std::path::{Path, PathBuf};

/// Why a film cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum VideoError {
    /// No file of that name.
    #[error("film {path} is not there\n  why: no file of that name\n  do:  check the name, or record the film again", path = .path.display())]
    NotFound {
        /// The file.
        path: PathBuf,
    },
    /// The disk refused.
    #[error("film {path} cannot be {doing}\n  why: {source}\n  do:  check the permissions and the free space of its folder", path = .path.display())]
    Disk {
        /// The file.
        path: PathBuf,
        /// "read" or "written".
        doing: &'static str,
        /// What the system said.
        source: std::io::Error,
    },
    /// No regular file.
    #[error("film {path} is {kind}\n  why: only regular files and folders of pictures are read\n  do:  copy the film to a file, and name that", path = .path.display())]
    NotAFile {
        /// What was named.
        path: PathBuf,
        /// What it is instead.
        kind: &'static str,
    },
    /// Not an MP4 at all.
    #[error("film {path} is not an MP4\n  why: {found}\n  do:  put ffmpeg and ffprobe on the PATH, or convert it: ffmpeg -i {path} -c:v libx264 -crf 16 -an film.mp4", path = .path.display())]
    NotMp4 {
        /// The file.
        path: PathBuf,
        /// What is there instead.
        found: String,
    },
    /// A folder whose pictures and times do not belong together.
    #[error("folder {path} is no film\n  why: it has {pictures} pictures (PNG, JPEG) and {times} rising times in times.csv\n  do:  put a line a picture into times.csv: the second at which it was taken", path = .path.display())]
    NoTimes {
        /// The folder.
        path: PathBuf,
        /// Its pictures.
        pictures: usize,
        /// Its times.
        times: usize,
    },
    /// The recording was cut off before its index was written.
    #[error(
        "film {path} is cut short\n  why: it ends after {bytes} bytes without an index of its frames (no complete box `moov`); its last box, {last}\n  do:  copy it from the camera again, or record the film again",
        path = .path.display()
    )]
    NoIndex {
        /// The file.
        path: PathBuf,
        /// Its length.
        bytes: u64,
        /// Name, offset and size of the last box that it begins.
        last: String,
    },
    /// A box that cannot be right.
    #[error(
        "film {path} is damaged in its index: box `{name}` at byte {offset}\n  why: {why}\n  do:  copy it from the camera again, or let ffmpeg write a new index: ffmpeg -i {path} -c copy film.mp4",
        path = .path.display()
    )]
    DamagedBox {
        /// The file.
        path: PathBuf,
        /// The box, bytes that are no letters as `\x00`.
        name: String,
        /// Where the box begins in the file.
        offset: u64,
        /// What was found against what can be.
        why: String,
    },
    /// More than is read.
    #[error("film {path} is too large to be read\n  why: {why}\n  do:  {action}", path = .path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// What was found against its limit.
        why: String,
        /// The next move.
        action: &'static str,
    },
    /// Pictures without pixels, or with too many.
    #[error(
        "film {path} has pictures of {width} × {height} px\n  why: the limits are 1 … {MAX_SIDE} px a side and {} Mpx a picture\n  do:  scale it: ffmpeg -i {path} -vf scale=3840:-2 film.mp4; if it is smaller in truth, copy it from the camera again",
        MAX_PIXELS / 1_000_000,
        path = .path.display()
    )]
    PictureSize {
        /// The file.
        path: PathBuf,
        /// Columns.
        width: u64,
        /// Rows.
        height: u64,
    },
    /// A picture of a folder that cannot be decoded.
    #[error("picture {path} cannot be read\n  why: {}\n  do:  {}", .source.why(), .source.action(), path = .path.display())]
    Picture {
        /// The file.
        path: PathBuf,
        /// What the decoder said.
        source: PictureError,
    },
    /// An edit list that is more than one part of the film.
    #[error(
        "film {path} has an edit list that is not read\n  why: {why}\n  do:  write its displayed frames to a new film: ffmpeg -i {path} -c:v libx264 -crf 16 -an film.mp4",
        path = .path.display()
    )]
    Edits {
        /// The file.
        path: PathBuf,
        /// What the list holds.
        why: String,
    },
    /// The index promises more frames than the file holds.
    #[error(
        "film {path} is cut short at frame {frame} of {expected}\n  why: that frame needs {needed} bytes of file, there are {bytes}\n  do:  copy it from the camera again, or record the film again",
        path = .path.display()
    )]
    Truncated {
        /// The file.
        path: PathBuf,
        /// First frame that is not whole.
        frame: usize,
        /// Frames that the index promises.
        expected: usize,
        /// Where that frame would end, bytes.
        needed: u64,
        /// The file's length, bytes.
        bytes: u64,
    },
    /// A codec that is not H.264.
    #[error("film {path} is coded as {codec}\n  why: only H.264 (avc1) is read without ffmpeg, and no ffmpeg and ffprobe are on the PATH\n  do:  install ffmpeg, or convert it elsewhere: ffmpeg -i {path} -c:v libx264 -crf 16 -an film.mp4", path = .path.display())]
    UnknownCodec {
        /// The file.
        path: PathBuf,
        /// The four letters of its codec.
        codec: String,
    },
    /// H.264 or an MP4 of a kind that is left to ffmpeg.
    #[error(
        "film {path} is {feature}\n  why: {}, and no ffmpeg and ffprobe are on the PATH\n  do:  convert it with `ffmpeg -i {path} {} film.mp4`, or put ffmpeg and ffprobe on the PATH",
        .feature.supported_range(),
        .feature.conversion_options(),
        path = .path.display()
    )]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// What it uses.
        feature: Feature,
    },
    /// An ffmpeg or ffprobe that cannot be started, stays silent, or does not make pictures.
    #[error(
        "film {path} cannot be decoded by {program}\n  why: {why}\n  do:  try `{program} -i {path}`; if that fails too, install ffmpeg again or convert the film elsewhere: ffmpeg -i {path} -c:v libx264 -crf 16 -an film.mp4",
        path = .path.display(),
        program = .program.display()
    )]
    Program {
        /// The film.
        path: PathBuf,
        /// The program.
        program: PathBuf,
        /// What it did, and its last words on stderr.
        why: String,
    },
    /// Bytes that the decoder refuses.
    #[error("film {path} is damaged at frame {frame} of {expected}\n  why: {why}\n  do:  copy it from the camera again, or end the trial at frame {frame}", path = .path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Where.
        frame: usize,
        /// Frames that the index promises.
        expected: usize,
        /// What the decoder said.
        why: String,
    },
    /// A film that cannot be made as asked.
    #[error("film {path} cannot be made\n  why: {why}\n  do:  {action}", path = .path.display())]
    Unfit {
        /// The file.
        path: PathBuf,
        /// What does not fit.
        why: String,
        /// The next move.
        action: &'static str,
    },
}

impl VideoError {
    pub(super) fn damaged_box(path: &Path, name: [u8; 4], offset: u64, why: String) -> Self {
        Self::DamagedBox { path: path.into(), name: name.escape_ascii().to_string(), offset, why }
    }

    pub(super) fn reading_error(path: &Path, source: std::io::Error) -> Self {
        match source.kind() {
            std::io::ErrorKind::NotFound => Self::NotFound { path: path.into() },
            _ => Self::Disk { path: path.into(), doing: "read", source },
        }
    }
}
