//! Limits of what a film or picture may ask for.
//!
//! Films and pictures are untrusted: every count and size in a header is held against one of these, and against the length of the
//! file, before memory is reserved for it.

/// Pixels of a picture: above the largest sensors on sale (151 Mpx), and 0.2 GB as grey levels.
pub(crate) const MAX_PIXELS: u64 = 200_000_000;
/// Pixels of one side: a picture of one column and 1e8 rows is decoded row by row, which takes a minute.
pub(crate) const MAX_SIDE: u64 = 65_535;
/// Bytes of a decoded picture before it is converted to grey levels: 200 Mpx grey, or 178 Mpx in colour.
pub(crate) const MAX_DECODED_BYTES: u64 = 512 << 20;
/// Bytes of an index (moov): 8 h at 1000 frames/s take 230 MB.
pub(crate) const MAX_INDEX_BYTES: u64 = 256 << 20;
/// Frames of a film: 46 h at 60 frames/s, 2.8 h at 1000 frames/s.
pub(crate) const MAX_FRAMES: u64 = 10_000_000;
/// Bytes of one coded frame: four times an uncompressed frame of the largest size of H.264, level 5.2.
pub(crate) const MAX_CODED_BYTES: u64 = 64 << 20;
/// Bytes of a table of times, of 13 bytes a frame and more.
pub(crate) const MAX_TIMES_BYTES: u64 = 128 << 20;
/// Boxes at the top of an MP4: each costs a read of the disk; fragments of a second for a day are 172,800.
pub(crate) const MAX_OUTER_BOXES: usize = 200_000;

/// Whether a picture of this size may be decoded.
pub(crate) fn is_picture_size(width: u64, height: u64) -> bool {
    let side = 1..=MAX_SIDE;
    side.contains(&width) && side.contains(&height) && width * height <= MAX_PIXELS
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_without_pixels_or_with_too_many_is_no_picture() {
        assert!(is_picture_size(1, 1) && is_picture_size(20_000, 10_000));
        for (width, height) in [(0, 5), (5, 0), (22_000, 22_000), (1, 100_000_000), (u64::MAX, u64::MAX)] {
            assert!(!is_picture_size(width, height), "{width} × {height}");
        }
    }
}
