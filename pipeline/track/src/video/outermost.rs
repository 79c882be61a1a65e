//! The outermost boxes of an MP4 file: whether it is one, whether it is complete, and its index (moov).

use super::VideoError;
use super::boxes::{Header, Mp4Box};
use crate::limits::{MAX_INDEX_BYTES, MAX_OUTER_BOXES};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::Path;

/// A file that is being read, and its length.
pub(super) struct Source<'a> {
    pub(super) path: &'a Path,
    pub(super) file: &'a mut File,
    pub(super) bytes: u64,
}

/// The index in memory.
pub(super) struct IndexBytes {
    header: Header,
    offset: u64,
    content: Vec<u8>,
}

impl IndexBytes {
    /// The index as a box.
    pub(super) fn moov_box<'a>(&'a self, path: &'a Path) -> Mp4Box<'a> {
        let Header { name, length: header, .. } = self.header;
        Mp4Box { path, name, offset: self.offset, header, content: &self.content }
    }
}

impl Source<'_> {
    /// Reads the index.
    ///
    /// # Errors
    /// [`VideoError::NotMp4`] when the file does not begin as one, [`VideoError::NoIndex`] when it ends before its index does,
    /// [`VideoError::DamagedBox`] and [`VideoError::TooLarge`].
    pub(super) fn find_index(&mut self) -> Result<IndexBytes, VideoError> {
        let (mut at, mut last) = (0, None);
        for _ in 0..MAX_OUTER_BOXES {
            let Some(header) = self.header_at(at)? else { return Err(self.without_index(last)) };
            if &header.name == b"moov" && header.size <= self.bytes - at {
                return self.load_index(header, at);
            }
            last = Some((header, at));
            // sizes are at least 8, so this advances; a box beyond the end of the file is the last one
            at = at.saturating_add(header.size);
        }
        let why = format!("its first {MAX_OUTER_BOXES} boxes hold no index (moov), and more are not read");
        Err(VideoError::TooLarge { path: self.path.into(), why, action: "rewrite it: ffmpeg -i FILM -c copy film.mp4" })
    }

    /// The header of the box at `at`; none where the file ends.
    fn header_at(&mut self, at: u64) -> Result<Option<Header>, VideoError> {
        let remaining_bytes = self.bytes.saturating_sub(at);
        // a size of 2^63 and more leads to where no disk can be read
        if remaining_bytes < Header::SHORT {
            return Ok(None);
        }
        let mut head = [0; Header::LONG as usize];
        let head = &mut head[..remaining_bytes.min(Header::LONG) as usize];
        self.read_at(at, head)?;
        let Some(header) = Header::read_header(head, remaining_bytes) else { return Ok(None) };
        if at == 0 && &header.name != b"ftyp" {
            let found = format!("it begins with \"{}\", not with a box `ftyp`", header.name.escape_ascii());
            return Err(VideoError::NotMp4 { path: self.path.into(), found });
        }
        match header.defect(remaining_bytes) {
            // a size beyond the end of the file is what a film cut short has, a wrapped one it has not
            Some(why) if header.size < header.length || at.checked_add(header.size).is_none() => {
                Err(VideoError::damaged_box(self.path, header.name, at, why))
            }
            _ => Ok(Some(header)),
        }
    }

    fn load_index(&mut self, header: Header, offset: u64) -> Result<IndexBytes, VideoError> {
        let length = header.size - header.length;
        if length > MAX_INDEX_BYTES {
            let why = format!("its index (moov, byte {offset}) has {length} bytes; the limit is {MAX_INDEX_BYTES}");
            return Err(VideoError::TooLarge { path: self.path.into(), why, action: "cut the film into shorter ones" });
        }
        let mut content = vec![0; length as usize];
        self.read_at(offset + header.length, &mut content)?;
        Ok(IndexBytes { header, offset, content })
    }

    fn read_at(&mut self, at: u64, into: &mut [u8]) -> Result<(), VideoError> {
        let read = self.file.seek(SeekFrom::Start(at)).and_then(|_| self.file.read_exact(into));
        read.map_err(|e| VideoError::reading_error(self.path, e))
    }

    fn without_index(&self, last: Option<(Header, u64)>) -> VideoError {
        let (path, bytes) = (self.path.into(), self.bytes);
        let Some((Header { name, size, .. }, offset)) = last else {
            return VideoError::NotMp4 { path, found: format!("it has only {bytes} bytes") };
        };
        let last = format!("`{}` at byte {offset}, states {size} bytes", name.escape_ascii());
        VideoError::NoIndex { path, bytes, last }
    }
}
