//! A folder of pictures as a film: PNG or JPEG files in the natural order of their names (2 before 10), and `times.csv` with the time of each.
//!
//! Times are those of `times.csv`, whatever the first is. Pictures are upright by the orientation in their EXIF, as films are by their matrix. Hidden
//! files are none of the pictures: macOS puts one (`._a.png`) beside each file on other systems' discs.

use super::{Frame, Info, VideoError, files};
use crate::Gray;
use crate::gray::Depth;
use crate::limits::MAX_TIMES_BYTES;
use si::Second;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};

/// The file of times: a line a picture, seconds; a first line that is no number is a title.
const TIMES: &str = "times.csv";

/// Pictures, one after another.
pub(super) struct Folder {
    files: Vec<PathBuf>,
    times: Vec<Second>,
    size: (usize, usize),
    depth: Depth,
    shown: usize,
}

impl Folder {
    /// Opens a folder.
    pub(super) fn open(path: &Path) -> Result<Self, VideoError> {
        let (files, times) = (list_pictures(path)?, read_times(&path.join(TIMES))?);
        Self::of_files(path, files, times)
    }

    /// Opens a folder of photographs, which have no times: picture k is that of second k.
    pub(super) fn open_photographs(path: &Path) -> Result<Self, VideoError> {
        let files = list_pictures(path)?;
        let times = (0..files.len()).map(|k| k as f64).collect();
        Self::of_files(path, files, times)
    }

    fn of_files(path: &Path, files: Vec<PathBuf>, times: Vec<Second>) -> Result<Self, VideoError> {
        let rising = times.windows(2).all(|pair| pair[0] < pair[1]);
        if files.is_empty() || times.len() != files.len() || !rising {
            let (pictures, times) = (files.len(), times.len());
            return Err(VideoError::NoTimes { path: path.into(), pictures, times });
        }
        let mut depth = Depth::default();
        let first = read_picture(&files[0], &mut depth)?;
        Ok(Self { files, times, size: (first.width, first.height), depth, shown: 0 })
    }

    pub(super) fn info(&self) -> Info {
        Info::of_times(self.size, &self.times)
    }

    pub(super) fn next(&mut self) -> Option<Result<Frame, VideoError>> {
        let index = self.shown;
        let file = self.files.get(index)?;
        self.shown += 1;
        let (expected, why) = (self.files.len(), "it has another size than the first".to_owned());
        Some(read_picture(file, &mut self.depth).and_then(|gray| match (gray.width, gray.height) == self.size {
            true => Ok(Frame { index, time: self.times[index], gray }),
            false => Err(VideoError::Damaged { path: file.clone(), frame: index, expected, why }),
        }))
    }
}

/// Whether a path is a folder of pictures without times.
pub(super) fn is_of_photographs(path: &Path) -> bool {
    path.is_dir() && !path.join(TIMES).exists()
}

/// The pictures of a folder in the order of their names.
pub(super) fn list_pictures(path: &Path) -> Result<Vec<PathBuf>, VideoError> {
    let entries = std::fs::read_dir(path).map_err(|e| VideoError::reading_error(path, e))?;
    let files: Result<Vec<PathBuf>, _> = entries.map(|entry| entry.map(|e| e.path())).collect();
    let mut files = files.map_err(|e| VideoError::reading_error(path, e))?;
    let is_picture = |ending: &std::ffi::OsStr| ENDINGS.iter().any(|known| ending.eq_ignore_ascii_case(known));
    let is_hidden = |file: &PathBuf| file.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
    files.retain(|file| file.extension().is_some_and(is_picture) && !is_hidden(file));
    files.sort_by_cached_key(|file| natural_order(&file.file_name().unwrap_or_default().to_string_lossy()));
    Ok(files)
}

/// Parts of a name in the order by which they are compared: numbers by their value, then everything letter by letter.
fn natural_order(name: &str) -> (Vec<(u128, String)>, String) {
    let mut parts = Vec::new();
    let mut remaining = name;
    while !remaining.is_empty() {
        let letters = remaining.find(|c: char| c.is_ascii_digit()).unwrap_or(remaining.len());
        let (word, after) = remaining.split_at(letters);
        let digits = after.find(|c: char| !c.is_ascii_digit()).unwrap_or(after.len());
        let (number, after) = after.split_at(digits);
        parts.push((word.to_owned(), number.parse().unwrap_or(u128::MAX)));
        remaining = after;
    }
    // the word stands before the number within a part
    (parts.into_iter().flat_map(|(word, number)| [(0, word), (number, String::new())]).collect(), name.to_owned())
}

/// Endings of the pictures that are read.
const ENDINGS: [&str; 3] = ["png", "jpg", "jpeg"];

/// The times that are numbers, a line each; none when there is no such file.
fn read_times(file: &Path) -> Result<Vec<Second>, VideoError> {
    let (opened, length) = match files::open_file(file) {
        Err(VideoError::NotFound { .. }) => return Ok(Vec::new()),
        other => other?,
    };
    if length > MAX_TIMES_BYTES {
        let why = format!("it has {length} bytes; the limit is {MAX_TIMES_BYTES}");
        return Err(VideoError::TooLarge {
            path: file.into(),
            why,
            action: "put a line a picture into it: its second",
        });
    }
    let mut bytes = Vec::new();
    // the file may grow while it is read
    opened.take(MAX_TIMES_BYTES).read_to_end(&mut bytes).map_err(|e| VideoError::reading_error(file, e))?;
    let text = String::from_utf8_lossy(&bytes);
    let times = text.lines().filter_map(line_time);
    Ok(times.filter(|time: &Second| time.is_finite()).collect())
}

/// The time of a line: its last field, where a name or an index may stand before it. Between semicolons or tabs a comma is a decimal sign; of
/// 3,120 nobody knows what it is.
fn line_time(line: &str) -> Option<Second> {
    let line = line.trim();
    if let Some((_, field)) = line.rsplit_once([';', '\t']) {
        return field.trim().replacen(',', ".", 1).parse().ok();
    }
    let (before, field) = line.rsplit_once(',').unwrap_or(("", line));
    let is_open = before.parse::<i64>().is_ok() && !field.contains('.');
    field.trim().parse().ok().filter(|_| !is_open)
}

/// A PNG or JPEG, by its first bytes; all pictures of a film have one depth, that of the first.
pub(super) fn read_picture(file: &Path, depth: &mut Depth) -> Result<Gray, VideoError> {
    let (opened, _) = files::open_file(file)?;
    let damaged = |source| VideoError::Picture { path: file.into(), source };
    Gray::read_image(BufReader::new(opened), depth).map_err(damaged)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder with one picture and a table of times.
    fn folder(name: &str, picture: &[u8], times: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("track-folder-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("000.png"), picture).unwrap();
        std::fs::write(folder.join(TIMES), times).unwrap();
        folder
    }

    fn refused(name: &str, picture: &[u8], times: &str) -> VideoError {
        let folder = folder(name, picture, times);
        let error = Folder::open(&folder).err().unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        error
    }

    #[test]
    fn a_picture_that_cannot_be_decoded_is_named_with_its_reason() {
        let error = refused("text", b"no picture", "0.0\n");
        assert!(matches!(&error, VideoError::Picture { path, .. } if path.ends_with("000.png")), "{error}");
        assert_eq!(error.to_string().matches("why:").count(), 1, "{error}");
    }

    #[test]
    fn pictures_stand_in_the_natural_order_of_their_names_and_hidden_files_are_none() {
        let folder = folder("natural", &Gray::filled(4, 4, 9).to_png().unwrap(), "");
        std::fs::remove_file(folder.join("000.png")).unwrap();
        let names =
            ["img_1.png", "img_2.PNG", "img_10.png", "img_010.png", "img_11_b2.jpg", "img_11_b10.jpg", "x.jpeg"];
        for name in names.iter().rev().chain(&["._img_1.png", ".hidden.jpg", "notes.txt"]) {
            std::fs::write(folder.join(name), "").unwrap();
        }
        let listed = list_pictures(&folder).unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        let found: Vec<_> = listed.iter().map(|file| file.file_name().unwrap().to_str().unwrap()).collect();
        assert_eq!(
            found,
            ["img_1.png", "img_2.PNG", "img_010.png", "img_10.png", "img_11_b2.jpg", "img_11_b10.jpg", "x.jpeg"]
        );
    }

    #[test]
    fn the_times_of_a_folder_are_those_of_its_table() {
        let folder = folder("rebased", &Gray::filled(4, 4, 9).to_png().unwrap(), "time_s\n2.5\n");
        let mut film = Folder::open(&folder).unwrap();
        assert_eq!(film.next().unwrap().unwrap().time, 2.5);
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn a_time_may_stand_behind_the_name_of_its_picture_and_have_a_decimal_comma() {
        for (line, time) in [
            ("0.04", Some(0.04)),
            ("0,04", None),
            ("3,120", None),
            ("3,0.120", Some(0.12)),
            ("img_1.png,0.04", Some(0.04)),
            ("img_1.png;0,04", Some(0.04)),
            ("1.5,0.04", Some(0.04)),
            ("file,time_s", None),
            ("", None),
        ] {
            assert_eq!(line_time(line), time, "{line}");
        }
    }

    #[test]
    fn a_folder_of_jpeg_pictures_is_read_and_counted() {
        let gray = Gray::from_fn(16, 16, |u, _| if u < 8 { 40.0 } else { 200.0 });
        let mut jpeg = Vec::new();
        let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut jpeg, 95);
        image::ImageEncoder::write_image(encoder, &gray.pixels, 16, 16, image::ExtendedColorType::L8).unwrap();
        let folder = folder("jpeg", &jpeg, "0.0\n");
        std::fs::rename(folder.join("000.png"), folder.join("000.JPG")).unwrap();
        let frame = Folder::open(&folder).unwrap().next().unwrap().unwrap();
        assert!(
            (frame.gray.pixel_level(2, 8) - 40.0).abs() < 6.0 && (frame.gray.pixel_level(13, 8) - 200.0).abs() < 6.0
        );
        std::fs::remove_file(folder.join(TIMES)).unwrap();
        let said = Folder::open(&folder).err().unwrap().to_string();
        assert!(said.contains("it has 1 pictures (PNG, JPEG) and 0 rising times"), "{said}");
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn photographs_need_no_times_and_count_as_seconds() {
        let picture = Gray::filled(4, 4, 9).to_png().unwrap();
        let folder = folder("photographs", &picture, "");
        std::fs::write(folder.join("001.png"), &picture).unwrap();
        assert!(!is_of_photographs(&folder));
        std::fs::remove_file(folder.join(TIMES)).unwrap();
        assert!(is_of_photographs(&folder) && !is_of_photographs(&folder.join("000.png")));
        let mut film = Folder::open_photographs(&folder).unwrap();
        let times: Vec<Second> = std::iter::from_fn(|| film.next()).map(|frame| frame.unwrap().time).collect();
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(times, [0.0, 1.0]);
    }

    #[test]
    fn times_that_are_no_finite_numbers_are_no_times() {
        let picture = Gray::filled(4, 4, 9).to_png().unwrap();
        for times in ["inf\n", "nan\n", "0.0\n1.0\n", ""] {
            let error = refused("times", &picture, times);
            assert!(matches!(error, VideoError::NoTimes { pictures: 1, .. }), "{error}");
        }
    }

    #[test]
    #[cfg(unix)]
    fn a_table_of_times_or_a_picture_that_is_a_device_is_refused() {
        let picture = Gray::filled(4, 4, 9).to_png().unwrap();
        for name in [TIMES, "000.png"] {
            let folder = folder("device", &picture, "0.0\n");
            std::fs::remove_file(folder.join(name)).unwrap();
            std::os::unix::fs::symlink("/dev/zero", folder.join(name)).unwrap();
            let error = Folder::open(&folder).err().unwrap();
            std::fs::remove_dir_all(&folder).unwrap();
            assert!(matches!(&error, VideoError::NotAFile { path, .. } if path.ends_with(name)), "{error}");
        }
    }
}
