//! The outermost boxes of an MP4 file: whether it is one, whether it is complete, and where its index is.

use super::VideoError;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// Where the index (moov) lies in the file, its header left off.
pub(super) struct Place {
    pub(super) start: u64,
    pub(super) end: u64,
}

/// Finds the index of an MP4 by walking over its outermost boxes.
///
/// # Errors
/// [`VideoError::NotMp4`] when the file does not begin as one, [`VideoError::NoIndex`] when it ends before its index does.
pub(super) fn find_index(file: &mut File, path: &Path) -> Result<Place, VideoError> {
    let bytes = file.metadata().map_err(|e| VideoError::reading(path, e))?.len();
    let mut at = 0;
    while let Some((name, header, size)) = box_at(file, at, bytes).map_err(|e| VideoError::reading(path, e))? {
        if at == 0 && &name != b"ftyp" {
            let found = format!("it begins with {:?}, not with an ftyp box", String::from_utf8_lossy(&name));
            return Err(VideoError::NotMp4 { path: path.into(), found });
        }
        if &name == b"moov" && at + size <= bytes {
            return Ok(Place { start: at + header, end: at + size });
        }
        at += size;
    }
    match at {
        0 => Err(VideoError::NotMp4 { path: path.into(), found: format!("it has only {bytes} bytes") }),
        _ => Err(VideoError::NoIndex { path: path.into(), bytes }),
    }
}

/// Name, length of the header and whole length of the box at `at`; none where the file ends or no box can be.
fn box_at(file: &mut File, at: u64, bytes: u64) -> std::io::Result<Option<([u8; 4], u64, u64)>> {
    let mut head = [0; 16];
    if at + 8 > bytes {
        return Ok(None);
    }
    let known = (bytes - at).min(16) as usize;
    file.seek(SeekFrom::Start(at))?;
    file.read_exact(&mut head[..known])?;
    let [a, b, c, d, name @ ..] = [head[0], head[1], head[2], head[3], head[4], head[5], head[6], head[7]];
    let (header, size) = match u32::from_be_bytes([a, b, c, d]) {
        0 => (8, bytes - at),
        1 => (16, u64::from_be_bytes([8, 9, 10, 11, 12, 13, 14, 15].map(|i| head[i]))),
        size => (8, u64::from(size)),
    };
    Ok((size >= header).then_some((name, header, size)))
}
