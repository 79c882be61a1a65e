//! Programs that answer as the real ones do, and programs that are silent, endless, false or missing.

use super::*;
use std::os::unix::fs::PermissionsExt;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A limit for tests: a shell starts in some milliseconds, on a busy computer in some tenths of a second.
const SHORT: Duration = Duration::from_secs(1);
/// A program just written cannot be started while another thread starts one, which for a moment has the file open as well.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// Two programs as shell scripts in a folder of their own, which is removed at the end.
struct StandIns {
    folder: PathBuf,
    _alone: MutexGuard<'static, ()>,
}

impl Drop for StandIns {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

const THREE_TIMES: &str = "printf '0.500000\n0.540000\n0.520000\n'";
const HEAD: &str = "printf 'YUV4MPEG2 W4 H2 F60:1 Ip A1:1 Cmono\n'";
const FOREVER: &str = "while :; do sleep 0.1; done";

impl StandIns {
    fn new(name: &str, ffmpeg: &str, ffprobe: &str) -> Self {
        let alone = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
        let folder = std::env::temp_dir().join(format!("track-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        for (name, text) in [("ffmpeg", ffmpeg), ("ffprobe", ffprobe)] {
            let path = folder.join(name);
            std::fs::write(&path, format!("#!/bin/sh\n{text}\n")).unwrap();
            std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        }
        Self { folder, _alone: alone }
    }

    fn open(&self) -> Result<Pipe, VideoError> {
        let [ffmpeg, ffprobe] = ["ffmpeg", "ffprobe"].map(|name| self.folder.join(name));
        Pipe::open(Path::new("any.mov"), Programs { ffmpeg, ffprobe, limit: SHORT }, &[])
    }

    /// The error of opening, which comes in time.
    fn refused(&self) -> VideoError {
        let start = Instant::now();
        let error = self.open().err().unwrap();
        assert!(start.elapsed() < 5 * SHORT, "{error}");
        error
    }
}

/// A shell script that writes pictures of 4 × 2 px.
fn film(pictures: usize) -> String {
    let picture = |k| format!("printf 'FRAME\n{k}{k}{k}{k}{k}{k}{k}{k}'\n");
    [HEAD.to_owned(), "\n".into(), (0..pictures).map(picture).collect()].concat()
}

#[test]
fn pictures_come_through_the_pipe_with_their_own_times() {
    let stand_ins = StandIns::new("three", &film(3), THREE_TIMES);
    let mut pipe = stand_ins.open().unwrap();
    assert_eq!((pipe.info().width, pipe.info().height, pipe.info().frames), (4, 2, 3));
    for k in 0..3 {
        let frame = pipe.next().unwrap().unwrap();
        assert_eq!(frame.gray.pixels, vec![b'0' + k; 8]);
        assert!((frame.time - 0.02 * f64::from(k)).abs() < 1e-12);
    }
    assert!(pipe.next().is_none());
}

#[test]
fn a_pipe_that_ends_early_names_the_frame_and_the_words_on_stderr() {
    let stand_ins = StandIns::new("two", &format!("{}\necho 'oh no\nit broke' >&2", film(2)), THREE_TIMES);
    let mut pipe = stand_ins.open().unwrap();
    let _ = (pipe.next(), pipe.next());
    let error = pipe.next().unwrap().unwrap_err();
    assert!(matches!(error, VideoError::Damaged { frame: 2, expected: 3, .. }), "{error}");
    assert!(error.to_string().contains("stderr ends with: oh no; it broke"), "{error}");
    assert!(pipe.next().is_none());
}

#[test]
fn frames_that_an_edit_list_leaves_out_have_no_time() {
    assert_eq!(
        ["0.5,K__", "-0.1,_D_", "0.7,", "0.9", "N/A,__", "inf,K_"].map(parse_time),
        [Some(0.5), None, Some(0.7), Some(0.9), None, None]
    );
}

#[test]
fn a_silent_program_is_given_up() {
    for (name, ffmpeg, ffprobe, program) in [
        ("silent", FOREVER, THREE_TIMES, "ffmpeg"),
        ("silent-probe", HEAD, FOREVER, "ffprobe"),
        // the shell is ended, what it started is left and keeps the output open
        ("orphan", "sleep 3 & sleep 3", THREE_TIMES, "ffmpeg"),
    ] {
        let message = StandIns::new(name, ffmpeg, ffprobe).refused().to_string();
        assert!(message.contains("nothing whole came") && message.contains("cannot be decoded by"), "{message}");
        assert!(message.lines().next().unwrap().ends_with(program), "{message}");
    }
}

#[test]
fn a_program_that_stops_within_a_picture_is_given_up_with_the_frame() {
    let stand_ins = StandIns::new("stuck", &format!("{}\nprintf 'FRAME\n1234'\n{FOREVER}", film(1)), THREE_TIMES);
    let mut pipe = stand_ins.open().unwrap();
    assert!(pipe.next().unwrap().is_ok());
    let start = Instant::now();
    let error = pipe.next().unwrap().unwrap_err();
    assert!(start.elapsed() < 5 * SHORT);
    assert!(matches!(error, VideoError::Program { .. }) && error.to_string().contains("frame 1 of 3"), "{error}");
    assert!(pipe.next().is_none());
}

#[test]
fn output_without_end_is_bounded() {
    let zeros = "exec cat /dev/zero";
    let message = StandIns::new("endless", zeros, THREE_TIMES).refused().to_string();
    assert!(message.contains("a line of more than 4096 bytes"), "{message}");
    let message = StandIns::new("endless-probe", HEAD, zeros).refused().to_string();
    assert!(message.contains("a line of more than 4096 bytes"), "{message}");
    // more pictures than times: the film ends with the last time
    let stand_ins = StandIns::new("more", &format!("{HEAD}\nwhile printf 'FRAME\n12345678'; do :; done"), THREE_TIMES);
    assert_eq!(
        std::iter::from_fn({
            let mut pipe = stand_ins.open().unwrap();
            move || pipe.next()
        })
        .count(),
        3
    );
}

#[test]
fn much_text_on_stderr_neither_blocks_nor_fills_the_memory() {
    let noisy = format!("head -c 3000000 /dev/zero | tr '\\0' 'x' >&2\n{}", film(3));
    let stand_ins = StandIns::new("noisy", &noisy, THREE_TIMES);
    let mut pipe = stand_ins.open().unwrap();
    assert!((0..3).all(|_| pipe.next().unwrap().is_ok()));
    drop((pipe, stand_ins));
    let message = StandIns::new("shouting", "while :; do echo loud >&2; done", THREE_TIMES).refused().to_string();
    assert!(message.contains("nothing whole came") && message.contains("loud; loud"), "{message}");
}

#[test]
fn a_size_that_cannot_be_is_refused_before_memory_is_reserved() {
    for (k, size) in ["W4000000000 H4000000000", "W0 H2", "W70000 H2", "W20001 H10000"].into_iter().enumerate() {
        let head = format!("printf 'YUV4MPEG2 {size} F60:1\n'");
        let error = StandIns::new(&format!("size-{k}"), &head, THREE_TIMES).refused();
        assert!(matches!(error, VideoError::PictureSize { .. }), "{error}");
    }
    let error = StandIns::new("no-size", "echo nothing known >&2; echo YUV4MPEG2 W-3 Hx", THREE_TIMES).refused();
    assert!(error.to_string().contains("nothing known"), "{error}");
}

#[test]
fn a_missing_program_is_named() {
    let stand_ins = StandIns::new("missing", HEAD, THREE_TIMES);
    std::fs::remove_file(stand_ins.folder.join("ffprobe")).unwrap();
    let message = stand_ins.refused().to_string();
    assert!(message.contains("cannot be started") && message.contains("ffprobe"), "{message}");
    drop(stand_ins);
    let message = StandIns::new("no-frame", HEAD, "echo cannot open >&2; exit 1").refused().to_string();
    assert!(message.contains("lists no frame; its stderr ends with: cannot open"), "{message}");
}

#[test]
fn a_name_that_looks_like_an_option_is_passed_as_a_file() {
    let stand_ins = StandIns::new("name", "echo \"$@\" >&2", "echo \"$@\" >&2");
    let [ffmpeg, ffprobe] = ["ffmpeg", "ffprobe"].map(|name| stand_ins.folder.join(name));
    let programs = Programs { ffmpeg, ffprobe, limit: SHORT };
    let message = Pipe::open(Path::new("-version.mov"), programs, &[]).err().unwrap().to_string();
    assert!(message.contains("file:-version.mov"), "{message}");
}

#[test]
fn a_film_that_is_left_early_leaves_no_process() {
    let stand_ins = StandIns::new("left", &format!("echo $$ > \"$0.id\"\n{}\n{FOREVER}", film(1)), THREE_TIMES);
    let mut pipe = stand_ins.open().unwrap();
    assert!(pipe.next().unwrap().is_ok());
    let id = std::fs::read_to_string(stand_ins.folder.join("ffmpeg.id")).unwrap();
    let process = Path::new("/proc").join(id.trim());
    assert!(process.exists() || !Path::new("/proc/self").exists());
    drop(pipe);
    assert!(!process.exists(), "neither running nor waiting to be reaped");
}
