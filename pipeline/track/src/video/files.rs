//! Opening of films and pictures: regular files only.

use super::VideoError;
use std::fs::File;
use std::path::Path;

/// A regular file and its length.
///
/// # Errors
/// [`VideoError::NotAFile`] for a folder, pipe, socket or device: opening a pipe waits for its writer, and a device may never end.
pub(super) fn open_file(path: &Path) -> Result<(File, u64), VideoError> {
    let about = std::fs::metadata(path).map_err(|e| VideoError::reading_error(path, e))?;
    if !about.is_file() {
        let kind = if about.is_dir() { "a folder" } else { "a pipe, a socket or a device" };
        return Err(VideoError::NotAFile { path: path.into(), kind });
    }
    let file = File::open(path).map_err(|e| VideoError::reading_error(path, e))?;
    Ok((file, about.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_refused_and_what_is_missing_is_named() {
        assert!(matches!(open_file(&std::env::temp_dir()), Err(VideoError::NotAFile { kind: "a folder", .. })));
        assert!(matches!(open_file(Path::new("no/such/film.mp4")), Err(VideoError::NotFound { .. })));
    }

    #[test]
    #[cfg(unix)]
    fn a_device_is_refused_without_being_read() {
        let error = open_file(Path::new("/dev/zero")).unwrap_err();
        assert!(error.to_string().contains("film /dev/zero is a pipe, a socket or a device"), "{error}");
    }
}
