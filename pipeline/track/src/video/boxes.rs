//! Boxes of an MP4 (ISO/IEC 14496-12, section 4.2) on bytes in memory.
//!
//! The bytes are untrusted. Every size is held against the end of the parent, and iteration always advances, because a box takes at
//! least the 8 bytes of its header. Errors name the box and its offset in the file.

use super::VideoError;
use std::path::Path;

/// The four characters that name a kind of box.
pub(super) type Name = [u8; 4];

/// Name and size that the header of a box states; the size is held against nothing yet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Header {
    pub(super) name: Name,
    /// Bytes of the header itself.
    pub(super) length: u64,
    /// Bytes of header and content.
    pub(super) size: u64,
}

impl Header {
    /// Bytes of the shortest and the longest header.
    pub(super) const SHORT: u64 = 8;
    pub(super) const LONG: u64 = 16;

    /// From the first bytes of a box with `remaining` bytes to the end of its parent; none when they end within the header.
    pub(super) fn read_header(head: &[u8], remaining: u64) -> Option<Self> {
        let (size, rest) = head.split_first_chunk::<4>()?;
        let (name, rest) = rest.split_first_chunk::<4>()?;
        let (length, size) = match u32::from_be_bytes(*size) {
            0 => (Self::SHORT, remaining),
            1 => (Self::LONG, u64::from_be_bytes(*rest.first_chunk()?)),
            size => (Self::SHORT, size.into()),
        };
        Some(Self { name: *name, length, size })
    }

    /// Why there can be no such box, none where there can.
    pub(super) fn defect(&self, remaining: u64) -> Option<String> {
        let Self { length, size, .. } = *self;
        match size {
            _ if size < length => Some(format!("it states a size of {size} bytes; its header alone takes {length}")),
            _ if size > remaining => {
                Some(format!("it states a size of {size} bytes; {remaining} are left to the end of its parent"))
            }
            _ => None,
        }
    }
}

/// A box whose bytes are all there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mp4Box<'a> {
    pub(super) path: &'a Path,
    pub(super) name: Name,
    /// Of its header in the file.
    pub(super) offset: u64,
    /// Bytes of its header.
    pub(super) header: u64,
    pub(super) content: &'a [u8],
}

impl<'a> Mp4Box<'a> {
    /// The boxes inside.
    pub(super) fn children(&self) -> Boxes<'a> {
        Boxes { parent: *self, at: 0 }
    }

    /// The boxes behind the first `skipped` bytes of the content.
    pub(super) fn children_behind(&self, skipped: usize) -> Result<Boxes<'a>, VideoError> {
        match skipped <= self.content.len() {
            true => Ok(Boxes { parent: *self, at: skipped }),
            false => Err(self.refuse(self.ends_early(skipped))),
        }
    }

    /// The first child of a name.
    pub(super) fn find_child(&self, name: &Name) -> Result<Option<Self>, VideoError> {
        self.children().find(|found| found.as_ref().map_or(true, |child| &child.name == name)).transpose()
    }

    /// The first child of a name, which must be there.
    pub(super) fn required_child(&self, name: &Name) -> Result<Self, VideoError> {
        let missing = || self.refuse(format!("it holds no box `{}`", name.escape_ascii()));
        self.find_child(name)?.ok_or_else(missing)
    }

    /// `N` bytes of the content from `offset`.
    pub(super) fn bytes_at<const N: usize>(&self, offset: usize) -> Result<[u8; N], VideoError> {
        let chunk = self.content.get(offset..).and_then(|rest| rest.first_chunk());
        chunk.copied().ok_or_else(|| self.refuse(self.ends_early(offset.saturating_add(N))))
    }

    /// The 32-bit number at `at`.
    pub(super) fn number_at(&self, at: usize) -> Result<u32, VideoError> {
        self.bytes_at(at).map(u32::from_be_bytes)
    }

    /// The version of a full box: its first byte.
    pub(super) fn version(&self) -> Result<u8, VideoError> {
        self.bytes_at(0).map(|[version]| version)
    }

    /// The rows of a table whose number of rows is at `offset`, `row` bytes each.
    pub(super) fn table_rows(&self, offset: usize, row: usize) -> Result<std::slice::ChunksExact<'a, u8>, VideoError> {
        let count = u64::from(self.number_at(offset)?);
        let table = &self.content[offset + 4..];
        let needed = count * row as u64;
        if needed > table.len() as u64 {
            let why = format!("it lists {count} entries of {row} bytes, {needed} bytes in all; it has {}", table.len());
            return Err(self.refuse(why));
        }
        Ok(table[..needed as usize].chunks_exact(row))
    }

    /// The error that this box cannot be right.
    pub(super) fn refuse(&self, why: impl Into<String>) -> VideoError {
        VideoError::damaged_box(self.path, self.name, self.offset, why.into())
    }

    fn ends_early(&self, needed: usize) -> String {
        format!("its content has {} bytes; at least {needed} are needed", self.content.len())
    }
}

/// Iterator over the boxes inside of another; an error ends it.
#[derive(Debug, Clone)]
pub(super) struct Boxes<'a> {
    parent: Mp4Box<'a>,
    /// Bytes of the parent's content that are passed.
    at: usize,
}

impl<'a> Iterator for Boxes<'a> {
    type Item = Result<Mp4Box<'a>, VideoError>;

    fn next(&mut self) -> Option<Self::Item> {
        let remaining = &self.parent.content[self.at..];
        // a list of boxes in a QuickTime file may end in a terminator of 32 zero bits
        if remaining.len() < Header::SHORT as usize && remaining.iter().all(|&byte| byte == 0) {
            return None;
        }
        let child = self.parent.box_at(self.at);
        self.at = child.as_ref().map_or(self.parent.content.len(), |(_, behind)| *behind);
        Some(child.map(|(child, _)| child))
    }
}

impl<'a> Mp4Box<'a> {
    /// The box that begins at byte `at` of the content, and where it ends.
    fn box_at(&self, at: usize) -> Result<(Self, usize), VideoError> {
        let (rest, offset) = (&self.content[at..], self.offset + self.header + at as u64);
        let remaining_bytes = rest.len() as u64;
        let cut =
            || format!("its last {remaining_bytes} bytes, from byte {offset} on, are not a whole header of a box");
        let head = Header::read_header(rest, remaining_bytes).ok_or_else(|| self.refuse(cut()))?;
        if let Some(why) = head.defect(remaining_bytes) {
            return Err(VideoError::damaged_box(self.path, head.name, offset, why));
        }
        let content = &rest[head.length as usize..head.size as usize];
        let child = Mp4Box { path: self.path, name: head.name, offset, header: head.length, content };
        Ok((child, at + head.size as usize))
    }
}

/// Boxes written for tests.
#[cfg(test)]
pub(super) mod build {
    use super::{Mp4Box, Name};
    use std::path::Path;

    /// A box of a name and a content.
    pub(in crate::video) fn boxed(name: &Name, content: &[u8]) -> Vec<u8> {
        [&(content.len() as u32 + 8).to_be_bytes(), &name[..], content].concat()
    }

    /// 32-bit numbers.
    pub(in crate::video) fn numbers(of: &[u32]) -> Vec<u8> {
        of.iter().flat_map(|number| number.to_be_bytes()).collect()
    }

    /// A box that is read at the start of a file.
    pub(in crate::video) fn parent<'a>(name: &Name, content: &'a [u8]) -> Mp4Box<'a> {
        Mp4Box { path: Path::new("film.mp4"), name: *name, offset: 0, header: 8, content }
    }
}

#[cfg(test)]
mod tests {
    use super::build::{boxed, numbers, parent};
    use super::*;

    /// Name, offset and length of the content of each child, or the error.
    fn read(content: &[u8]) -> Result<Vec<(Name, u64, usize)>, String> {
        let found = parent(b"moov", content).children().map(|child| child.map(|b| (b.name, b.offset, b.content.len())));
        found.collect::<Result<_, _>>().map_err(|e| e.to_string())
    }

    #[test]
    fn boxes_follow_each_other_with_short_and_long_sizes() {
        let long = [&numbers(&[1])[..], b"free", &numbers(&[0, 19]), b"abc"].concat();
        let content = [boxed(b"mvhd", b"12"), long, boxed(b"trak", b"")].concat();
        assert_eq!(read(&content).unwrap(), [(*b"mvhd", 8, 2), (*b"free", 18, 3), (*b"trak", 37, 0)]);
    }

    #[test]
    fn a_size_of_zero_reaches_to_the_end_of_the_parent() {
        let content = [boxed(b"mvhd", b"12"), numbers(&[0]), b"freeabc".to_vec()].concat();
        assert_eq!(read(&content).unwrap(), [(*b"mvhd", 8, 2), (*b"free", 18, 3)]);
    }

    #[test]
    fn a_terminator_of_zeros_ends_the_list() {
        let content = [boxed(b"mvhd", b"12"), vec![0; 4]].concat();
        assert_eq!(read(&content).unwrap().len(), 1);
    }

    #[test]
    fn sizes_that_cannot_be_are_refused_with_box_and_byte() {
        let wrapping = [&numbers(&[1])[..], b"free", &(u64::MAX - 7).to_be_bytes()].concat();
        let small_long = [&numbers(&[1])[..], b"free", &15_u64.to_be_bytes()].concat();
        let cut_long = [&numbers(&[1])[..], b"free", &[0; 4]].concat();
        let small = [&numbers(&[7])[..], b"free"].concat();
        let large = [&numbers(&[9])[..], b"free"].concat();
        for (bytes, word) in
            [(wrapping, "free"), (small_long, "free"), (cut_long, "moov"), (small, "free"), (large, "free")]
        {
            let said = read(&[boxed(b"mvhd", b"12"), bytes].concat()).unwrap_err();
            assert!(said.contains(&format!("`{word}`")) && said.contains("18"), "{said}");
        }
    }

    #[test]
    fn a_table_is_held_against_the_bytes_of_its_box() {
        let content = numbers(&[0, 3, 10, 20, 30]);
        let rows = |count: u32, row| {
            let content = [&content[..4], &numbers(&[count]), &content[8..]].concat();
            parent(b"stco", &content).table_rows(4, row).map(|rows| rows.count()).map_err(|e| e.to_string())
        };
        assert_eq!(rows(3, 4), Ok(3));
        for (count, row) in [(4, 4), (2, 8), (u32::MAX, 20)] {
            assert!(rows(count, row).unwrap_err().contains("it has 12"));
        }
    }
}
