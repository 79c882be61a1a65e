//! Films of any codec through `ffmpeg` on the PATH: grey pictures come through a pipe, one after another, and their times from
//! `ffprobe`.

use super::{Frame, Info, VideoError};
use crate::Gray;
use si::Second;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};

/// A film that another program decodes.
pub(super) struct Pipe {
    path: PathBuf,
    child: Child,
    pictures: BufReader<ChildStdout>,
    times: Vec<Second>,
    size: (usize, usize),
    shown: usize,
}

/// Both programs, when they lie on the PATH.
pub(super) fn programs() -> Option<[PathBuf; 2]> {
    let folders: Vec<PathBuf> = std::env::split_paths(&std::env::var_os("PATH")?).collect();
    let find = |name: &str| {
        let name = format!("{name}{}", std::env::consts::EXE_SUFFIX);
        folders.iter().map(|folder| folder.join(&name)).find(|file| file.is_file())
    };
    Some([find("ffmpeg")?, find("ffprobe")?])
}

impl Pipe {
    /// Opens a film with the two programs; pictures are rotated as the film is displayed.
    pub(super) fn open(path: &Path, [ffmpeg, ffprobe]: [PathBuf; 2]) -> Result<Self, VideoError> {
        let times = times(path, &ffprobe)?;
        let mut command = Command::new(&ffmpeg);
        command.args(["-v", "error", "-nostdin", "-i"]).arg(path);
        command.args(["-map", "0:v:0", "-an", "-fps_mode", "passthrough", "-pix_fmt", "gray", "-strict", "-1"]);
        command.args(["-f", "yuv4mpegpipe", "-"]).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().map_err(|e| VideoError::reading(&ffmpeg, e))?;
        let pictures = child.stdout.take().map(BufReader::new);
        let mut pictures = pictures.ok_or_else(|| piped(path, 0, times.len(), "ffmpeg has no output"))?;
        let head = line(&mut pictures).map_err(|e| VideoError::reading(path, e))?;
        let number = |letter: char| head.split(' ').find_map(|word| word.strip_prefix(letter)?.parse::<usize>().ok());
        let (Some(width), Some(height)) = (number('W'), number('H')) else {
            let _ = child.kill();
            let _ = child.wait();
            return Err(piped(path, 0, times.len(), "ffmpeg makes no pictures of it; ask ffmpeg why"));
        };
        Ok(Self { path: path.into(), child, pictures, times, size: (width, height), shown: 0 })
    }

    pub(super) fn info(&self) -> Info {
        Info::of(self.size, &self.times)
    }

    pub(super) fn next(&mut self) -> Option<Result<Frame, VideoError>> {
        let index = self.shown;
        if index == self.times.len() {
            return None;
        }
        let (width, height) = self.size;
        let mut pixels = vec![0; width * height];
        let head = line(&mut self.pictures).ok().filter(|head| head.starts_with("FRAME"));
        let read = head.and_then(|_| self.pictures.read_exact(&mut pixels).ok());
        self.shown = if read.is_some() { index + 1 } else { self.times.len() };
        Some(match read {
            Some(()) => {
                let time = self.times[index] - self.times[0];
                Ok(Frame { index, time, gray: Gray { width, height, pixels } })
            }
            None => Err(piped(&self.path, index, self.times.len(), "ffmpeg ends before it")),
        })
    }
}

impl Drop for Pipe {
    /// A film that is left before its end leaves no process behind.
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Times of the frames in the order of showing, s.
fn times(path: &Path, ffprobe: &Path) -> Result<Vec<Second>, VideoError> {
    let mut command = Command::new(ffprobe);
    command.args(["-v", "error", "-select_streams", "v:0", "-show_entries", "packet=pts_time", "-of", "csv=p=0"]);
    let output = command.arg(path).stdin(Stdio::null()).output().map_err(|e| VideoError::reading(ffprobe, e))?;
    let text = String::from_utf8_lossy(&output.stdout);
    let mut times: Vec<Second> = text.lines().filter_map(|l| l.trim().trim_end_matches(',').parse().ok()).collect();
    times.sort_by(f64::total_cmp);
    match times.is_empty() {
        true => Err(piped(path, 0, 0, String::from_utf8_lossy(&output.stderr).trim())),
        false => Ok(times),
    }
}

fn line(from: &mut impl BufRead) -> std::io::Result<String> {
    let mut bytes = Vec::new();
    from.read_until(b'\n', &mut bytes)?;
    Ok(String::from_utf8_lossy(&bytes).trim_end().to_owned())
}

fn piped(path: &Path, frame: usize, expected: usize, why: &str) -> VideoError {
    VideoError::Damaged { path: path.into(), frame, expected, why: why.into() }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    /// Two programs that say what the real ones would of a film of three pictures of 4 × 2 px.
    fn stand_ins(name: &str, pictures: usize) -> [PathBuf; 2] {
        let folder = std::env::temp_dir().join(format!("track-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let frames: String = (0..pictures).map(|k| format!("printf 'FRAME\\n{0}{0}{0}{0}{0}{0}{0}{0}'\n", k)).collect();
        let film = format!("#!/bin/sh\nprintf 'YUV4MPEG2 W4 H2 F60:1 Ip A1:1 Cmono\\n'\n{frames}");
        let probe = "#!/bin/sh\nprintf '0.500000\\n0.540000\\n0.520000\\n'\n".to_owned();
        [("ffmpeg", film), ("ffprobe", probe)].map(|(name, text)| {
            let path = folder.join(name);
            std::fs::write(&path, text).unwrap();
            std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
            path
        })
    }

    #[test]
    fn pictures_come_through_the_pipe_with_their_own_times() {
        let mut pipe = Pipe::open(Path::new("any.mov"), stand_ins("three", 3)).unwrap();
        assert_eq!((pipe.info().width, pipe.info().height, pipe.info().frames), (4, 2, 3));
        for k in 0..3 {
            let frame = pipe.next().unwrap().unwrap();
            assert_eq!(frame.gray.pixels, vec![b'0' + k; 8]);
            assert!((frame.time - 0.02 * f64::from(k)).abs() < 1e-12);
        }
        assert!(pipe.next().is_none());
    }

    #[test]
    fn a_pipe_that_ends_early_names_the_frame() {
        let mut pipe = Pipe::open(Path::new("any.mov"), stand_ins("two", 2)).unwrap();
        let _ = (pipe.next(), pipe.next());
        let error = pipe.next().unwrap().unwrap_err();
        assert!(matches!(error, VideoError::Damaged { frame: 2, expected: 3, .. }), "{error}");
        assert!(pipe.next().is_none());
    }
}
