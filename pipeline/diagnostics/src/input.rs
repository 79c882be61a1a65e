//! Files from outside: only regular files are read, and only up to a limit.
//!
//! A FIFO or a device may never end, and a file of a wrong kind may be larger than the memory. Both are refused before a byte is read.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// Limit of a text that a person writes (a card, a case, a page), bytes.
pub const PAGE: u64 = 4 << 20;
/// Limit of a log, bytes: a hundred hours at 200 Hz.
pub const LOG: u64 = 256 << 20;
/// Limit of a mesh, a surface or a file of tracks, bytes: ten times the largest mesh that fits into 24 GiB when it is solved.
pub const MESH: u64 = 512 << 20;

/// The bytes of a regular file of at most `limit` bytes.
///
/// # Errors
/// When it cannot be read, is no regular file, is larger, or is packed.
pub fn read(path: &Path, limit: u64) -> io::Result<Vec<u8>> {
    let length = regular(path)?;
    if length > limit {
        return Err(too_large(length, limit));
    }
    let mut bytes = Vec::with_capacity(length as usize);
    // A file may grow while it is read.
    File::open(path)?.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(too_large(bytes.len() as u64, limit));
    }
    match packing_of(&bytes) {
        Some((name, command)) => Err(io::Error::new(
            ErrorKind::InvalidData,
            format!("it is packed by {name}; unpack it first with {command}"),
        )),
        None => Ok(bytes),
    }
}

/// The first bytes of packed files, which no reader unpacks: a reader of text would find "no text", one of triangles a wrong count. Their
/// programs, and what unpacks them. Zip is left out: workbooks are zip archives too, and the readers of logs know better what to do with those.
const PACKINGS: [(&[u8], &str, &str); 4] = [
    (b"\x1f\x8b", "gzip", "gunzip"),
    (b"BZh", "bzip2", "bunzip2"),
    (b"\xfd7zXZ\0", "xz", "unxz"),
    (b"\x28\xb5\x2f\xfd", "zstd", "unzstd"),
];

/// The program that packed these bytes and the command that unpacks them.
fn packing_of(bytes: &[u8]) -> Option<(&'static str, &'static str)> {
    let (_, name, command) = PACKINGS.iter().find(|(magic, ..)| bytes.starts_with(magic))?;
    Some((name, command))
}

/// The text of a regular file of at most `limit` bytes.
///
/// # Errors
/// As [`read`], and when it is not UTF-8.
pub fn read_text(path: &Path, limit: u64) -> io::Result<String> {
    let no_text = |_| io::Error::new(ErrorKind::InvalidData, "it is no text in UTF-8");
    String::from_utf8(read(path, limit)?).map_err(no_text)
}

/// The length of a regular file, bytes.
///
/// # Errors
/// When there is none, or something else is there.
pub fn regular(path: &Path) -> io::Result<u64> {
    regular_file(&fs::metadata(path)?)
}

/// The same of what is known of it already.
///
/// # Errors
/// When it is something else.
pub fn regular_file(metadata: &fs::Metadata) -> io::Result<u64> {
    match metadata.is_file() {
        true => Ok(metadata.len()),
        false => Err(io::Error::new(ErrorKind::InvalidInput, format!("it is {}, not a file", kind_of_file(metadata)))),
    }
}

fn too_large(length: u64, limit: u64) -> io::Error {
    let mebibytes = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    let text = format!("it has {:.1} MiB; the limit is {} MiB", mebibytes(length), mebibytes(limit));
    io::Error::new(ErrorKind::FileTooLarge, text)
}

#[cfg(unix)]
fn kind_of_file(metadata: &fs::Metadata) -> &'static str {
    use std::os::unix::fs::FileTypeExt;
    let kind = metadata.file_type();
    match () {
        () if kind.is_dir() => "a folder",
        () if kind.is_fifo() => "a FIFO",
        () if kind.is_socket() => "a socket",
        () => "a device",
    }
}

#[cfg(not(unix))]
fn kind_of_file(metadata: &fs::Metadata) -> &'static str {
    if metadata.is_dir() { "a folder" } else { "a device" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_and_a_device_are_refused_by_name() {
        assert!(read(&std::env::temp_dir(), PAGE).unwrap_err().to_string().contains("a folder, not a file"));
        if cfg!(unix) {
            assert!(read(Path::new("/dev/zero"), PAGE).unwrap_err().to_string().contains("a device, not a file"));
        }
    }

    #[test]
    fn a_packed_file_is_refused_with_the_command_that_unpacks_it() {
        let path = std::env::temp_dir().join(format!("input-packed-{}", std::process::id()));
        for (magic, _, command) in PACKINGS {
            fs::write(&path, [magic, b"\x08 and more"].concat()).unwrap();
            assert!(read(&path, PAGE).unwrap_err().to_string().ends_with(command), "{command}");
        }
        fs::remove_file(&path).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn a_socket_is_known_as_one() {
        let path = std::env::temp_dir().join(format!("input-socket-{}", std::process::id()));
        let listener = std::os::unix::net::UnixListener::bind(&path).unwrap();
        let refused = regular_file(&fs::metadata(&path).unwrap()).unwrap_err().to_string();
        drop(listener);
        fs::remove_file(&path).unwrap();
        assert_eq!(refused, "it is a socket, not a file");
    }

    #[test]
    fn a_long_page_log_and_mesh_are_within_their_limits() {
        let path = std::env::temp_dir().join(format!("input-long-{}", std::process::id()));
        for (length, limit) in [(2 << 20, PAGE), (32 << 20, LOG), (32 << 20, MESH)] {
            File::create(&path).unwrap().set_len(length).unwrap();
            assert_eq!(read(&path, limit).unwrap().len() as u64, length);
        }
        fs::remove_file(&path).unwrap();
    }

    #[test]
    fn a_file_above_the_limit_is_refused_with_both_sizes() {
        let path = std::env::temp_dir().join(format!("input-{}", std::process::id()));
        fs::write(&path, vec![b'1'; 3 << 20]).unwrap();
        let refused = read(&path, 1 << 20).unwrap_err().to_string();
        assert_eq!(refused, "it has 3.0 MiB; the limit is 1 MiB");
        assert_eq!(read(&path, 3 << 20).unwrap().len(), 3 << 20);
        fs::write(&path, [0xff, 0xfe]).unwrap();
        assert!(read_text(&path, PAGE).unwrap_err().to_string().contains("no text"));
        fs::remove_file(&path).unwrap();
    }
}
