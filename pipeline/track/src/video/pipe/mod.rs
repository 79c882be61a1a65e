//! Films of any codec through `ffmpeg` on the PATH: grey pictures come through a pipe, one after another, and their times from
//! `ffprobe`.
//!
//! The two programs are trusted no more than the film: they have a time limit, and the size and number of pictures that they state is
//! held against the limits of this crate.

use super::child::{Program, Stop};
use super::{Frame, Info, VideoError};
use crate::Gray;
use crate::limits::{MAX_FRAMES, is_picture_size};
use si::Second;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Time for one picture or one line of times: an 8K film takes 1 s a picture on a slow core, a disk that has to start 10 s.
const LIMIT: Duration = Duration::from_secs(20);
/// Time for all times, in such limits: `ffprobe` reads the whole file, at 100 MB/s 60 GB in this time.
const LIMITS_FOR_TIMES: u32 = 30;

/// The two programs, and the time that they have.
#[derive(Debug, Clone)]
pub(super) struct Programs {
    ffmpeg: PathBuf,
    ffprobe: PathBuf,
    limit: Duration,
}

impl Programs {
    /// Both programs, when they lie on the PATH.
    pub(super) fn on_path() -> Option<Self> {
        let folders: Vec<PathBuf> = std::env::split_paths(&std::env::var_os("PATH")?).collect();
        let find = |name: &str| {
            let name = format!("{name}{}", std::env::consts::EXE_SUFFIX);
            folders.iter().map(|folder| folder.join(&name)).find(|file| file.is_file())
        };
        Some(Self { ffmpeg: find("ffmpeg")?, ffprobe: find("ffprobe")?, limit: LIMIT })
    }
}

/// A film that another program decodes.
pub(super) struct Pipe {
    path: PathBuf,
    program: PathBuf,
    ffmpeg: Program,
    times: Vec<Second>,
    size: (usize, usize),
    shown: usize,
}

impl Pipe {
    /// Opens a film with the two programs; pictures are rotated as the film is displayed. `filter` are further options of `ffmpeg`.
    pub(super) fn open(path: &Path, programs: Programs, filter: &[&str]) -> Result<Self, VideoError> {
        let times = read_times(path, &programs)?;
        let mut command = Command::new(&programs.ffmpeg);
        command
            .args(["-v", "error", "-nostdin", "-i"])
            .arg(film_argument(path))
            .args(["-map", "0:v:0", "-an"])
            .args(filter);
        command.args(["-fps_mode", "passthrough", "-pix_fmt", "gray", "-strict", "-1", "-f", "yuv4mpegpipe", "-"]);
        let mut ffmpeg = start_program(command, path, (&programs.ffmpeg, programs.limit))?;
        let size = read_size(&mut ffmpeg, path, &programs.ffmpeg)?;
        Ok(Self { path: path.into(), program: programs.ffmpeg, ffmpeg, times, size, shown: 0 })
    }

    pub(super) fn info(&self) -> Info {
        Info::of_times(self.size, &self.times)
    }

    pub(super) fn next(&mut self) -> Option<Result<Frame, VideoError>> {
        let index = self.shown;
        if index == self.times.len() {
            return None;
        }
        let picture = self.read_picture();
        self.shown = if picture.is_ok() { index + 1 } else { self.times.len() };
        let frame = |gray| Frame { index, time: self.times[index] - self.times[0], gray };
        Some(picture.map(frame).map_err(|stop| self.refuse(index, stop)))
    }

    /// The next picture.
    fn read_picture(&mut self) -> Result<Gray, Stop> {
        self.ffmpeg.restart_clock();
        let head = self.ffmpeg.read_line()?;
        if !head.is_some_and(|head| head.starts_with("FRAME")) {
            return Err(Stop::Ended);
        }
        let (width, height) = self.size;
        let mut pixels = vec![0; width * height];
        self.ffmpeg.fill_buffer(&mut pixels)?;
        Ok(Gray { width, height, pixels })
    }

    fn refuse(&mut self, frame: usize, stop: Stop) -> VideoError {
        let (expected, said) = (self.times.len(), self.ffmpeg.end_program());
        match stop {
            Stop::Ended => {
                let why = with_words("ffmpeg ends before it".into(), &said);
                VideoError::Damaged { path: self.path.clone(), frame, expected, why }
            }
            other => program_error(
                &self.path,
                &self.program,
                with_words(format!("frame {frame} of {expected}: {other}"), &said),
            ),
        }
    }
}

/// Times of the frames in the order of display, s. Frames that an edit list leaves out are marked by a D and left out here.
fn read_times(path: &Path, programs: &Programs) -> Result<Vec<Second>, VideoError> {
    let mut command = Command::new(&programs.ffprobe);
    command.args(["-v", "error", "-select_streams", "v:0", "-show_entries", "packet=pts_time,flags", "-of", "csv=p=0"]);
    command.arg(film_argument(path));
    let mut ffprobe = start_program(command, path, (&programs.ffprobe, programs.limit))?;
    let listed = list_times(&mut ffprobe, LIMITS_FOR_TIMES * programs.limit);
    let refuse = |why: String, said: String| program_error(path, &programs.ffprobe, with_words(why, &said));
    let mut times = listed.map_err(|why| refuse(why, ffprobe.end_program()))?;
    if times.is_empty() {
        return Err(refuse("it lists no frame".into(), ffprobe.end_program()));
    }
    times.sort_by(f64::total_cmp);
    Ok(times)
}

/// The times that a program lists within `limit`, or why it was given up.
fn list_times(ffprobe: &mut Program, limit: Duration) -> Result<Vec<Second>, String> {
    let (end, mut times, mut lines) = (Instant::now() + limit, Vec::new(), 0);
    while let Some(line) = ffprobe.read_line().map_err(|stop| stop.to_string())? {
        times.extend(parse_time(&line));
        lines += 1;
        if lines > MAX_FRAMES {
            return Err(format!("it lists more than {MAX_FRAMES} frames, the limit"));
        }
        if Instant::now() > end {
            return Err(format!("it lists frames for more than {:.0} s, the limit", limit.as_secs_f64()));
        }
        ffprobe.restart_clock();
    }
    Ok(times)
}

/// The time of a line "0.500000,K__", none for a frame that is not displayed or has no time.
fn parse_time(line: &str) -> Option<Second> {
    let (time, flags) = line.trim().split_once(',').unwrap_or((line.trim(), ""));
    time.parse().ok().filter(|time: &Second| time.is_finite() && !flags.contains('D'))
}

/// Width and height in the header of the pictures.
fn read_size(ffmpeg: &mut Program, path: &Path, program: &Path) -> Result<(usize, usize), VideoError> {
    let head = match ffmpeg.read_line() {
        Ok(head) => head.unwrap_or_default(),
        Err(stop) => return Err(program_error(path, program, with_words(stop.to_string(), &ffmpeg.end_program()))),
    };
    let number = |letter: char| head.split(' ').find_map(|word| word.strip_prefix(letter)?.parse::<u64>().ok());
    let (Some(width), Some(height)) = (number('W'), number('H')) else {
        return Err(program_error(
            path,
            program,
            with_words("it makes no pictures of the film".into(), &ffmpeg.end_program()),
        ));
    };
    match is_picture_size(width, height) {
        true => Ok((width as usize, height as usize)),
        false => Err(VideoError::PictureSize { path: path.into(), width, height }),
    }
}

fn start_program(
    mut command: Command,
    path: &Path,
    (program, limit): (&Path, Duration),
) -> Result<Program, VideoError> {
    command.stdin(Stdio::null());
    Program::start(command, limit).map_err(|e| program_error(path, program, format!("it cannot be started: {e}")))
}

/// The film as a name that is neither an option, whatever it begins with, nor an address of another protocol.
fn film_argument(path: &Path) -> OsString {
    let mut name = OsString::from("file:");
    name.push(path);
    name
}

fn with_words(why: String, said: &str) -> String {
    if said.is_empty() { why } else { format!("{why}; its stderr ends with: {said}") }
}

fn program_error(path: &Path, program: &Path, why: String) -> VideoError {
    VideoError::Program { path: path.into(), program: program.into(), why }
}

#[cfg(test)]
#[cfg(unix)]
mod tests;
