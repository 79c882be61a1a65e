//! Sample tables of a track (ISO/IEC 14496-12, sections 8.6 and 8.7): where each coded frame is in the file and when it is displayed.
//!
//! Tables of runs (stts, ctts, stsc) stay as bytes. What is collected holds at most [`MAX_FRAMES`] entries, because the number of
//! samples is held against that limit and against the length of the file first.

use super::VideoError;
use super::boxes::Mp4Box;
use crate::limits::{MAX_CODED_BYTES, MAX_FRAMES};
use std::iter::repeat_n;

/// One coded frame in the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sample {
    pub(super) offset: u64,
    pub(super) size: u64,
}

/// Times at which frames are displayed, in ticks of the track's clock.
#[derive(Debug, PartialEq)]
pub(super) struct DisplayTicks {
    /// Of each frame, ascending.
    pub(super) starts: Vec<i64>,
    /// Of the last frame's end.
    pub(super) end: i64,
}

/// Offset and size of every sample in the order of decoding, from the sample table `stbl` of a film of `bytes` bytes.
pub(super) fn read_samples(stbl: &Mp4Box, bytes: u64) -> Result<Vec<Sample>, VideoError> {
    let sizes = sample_sizes(&stbl.required_child(b"stsz")?, bytes)?;
    let stsc = stbl.required_child(b"stsc")?.table_rows(4, 12)?;
    let runs = stsc.map(|row| (number(row), number(&row[4..])));
    let placed = match stbl.find_child(b"co64")? {
        Some(table) => place_samples(&sizes, table.table_rows(4, 8)?.map(long_number), runs),
        None => {
            place_samples(&sizes, stbl.required_child(b"stco")?.table_rows(4, 4)?.map(|row| number(row).into()), runs)
        }
    };
    let contradiction = || {
        let count = sizes.len();
        stbl.refuse(format!("its tables contradict each other: stsz lists {count} samples, stsc and the chunks others"))
    };
    placed.ok_or_else(contradiction)
}

/// The size of every sample.
fn sample_sizes(stsz: &Mp4Box, bytes: u64) -> Result<Vec<u64>, VideoError> {
    let (same, count) = (u64::from(stsz.number_at(4)?), u64::from(stsz.number_at(8)?));
    check_count(stsz, (same, count), bytes)?;
    let sizes: Vec<u64> = match same {
        0 => stsz.table_rows(8, 4)?.map(|row| number(row).into()).collect(),
        same => repeat_n(same, count as usize).collect(),
    };
    match sizes.iter().position(|&size| size > MAX_CODED_BYTES) {
        Some(i) => Err(stsz.refuse(format!("frame {i} takes {} bytes; the limit is {MAX_CODED_BYTES}", sizes[i]))),
        None => Ok(sizes),
    }
}

/// Holds `count` samples of the `same` size (0: of sizes of their own) against the film and the limit.
fn check_count(stsz: &Mp4Box, (same, count): (u64, u64), bytes: u64) -> Result<(), VideoError> {
    let total = same * count;
    if total > bytes {
        let why = format!("it lists {count} samples of {same} bytes, {total} bytes in all; the film has {bytes}");
        return Err(stsz.refuse(why));
    }
    if count > MAX_FRAMES {
        let why = format!("its box `stsz` at byte {} lists {count} frames; the limit is {MAX_FRAMES}", stsz.offset);
        let action = "cut the film into shorter ones";
        return Err(VideoError::TooLarge { path: stsz.path.into(), why, action });
    }
    Ok(())
}

/// Chunks begin at the offsets of the table, samples follow each other inside a chunk.
///
/// `runs` holds (first chunk, from 1; samples in each chunk from there on). None when the tables do not fit together.
fn place_samples(
    sizes: &[u64],
    chunks: impl Iterator<Item = u64>,
    runs: impl Iterator<Item = (u32, u32)>,
) -> Option<Vec<Sample>> {
    let mut out = Vec::with_capacity(sizes.len());
    let mut runs = runs.peekable();
    let mut per_chunk = 0;
    for (number, chunk) in (1_u32..).zip(chunks) {
        if let Some((_, new)) = runs.next_if(|(first, _)| *first == number) {
            per_chunk = new as usize;
        }
        let mut offset = chunk;
        for &size in sizes[out.len()..].iter().take(per_chunk) {
            out.push(Sample { offset, size });
            offset = offset.checked_add(size)?;
        }
    }
    (out.len() == sizes.len() && !out.is_empty()).then_some(out)
}

/// When each of `count` samples is displayed.
pub(super) fn display_ticks(stbl: &Mp4Box, count: usize) -> Result<DisplayTicks, VideoError> {
    let stts = stbl.required_child(b"stts")?;
    let steps = stts.table_rows(4, 8)?.map(|row| (number(row), number(&row[4..])));
    let presentation_times = match stbl.find_child(b"ctts")? {
        None => ticks(count, steps, std::iter::empty()),
        Some(ctts) => {
            // version 0 holds unsigned shifts by its text; writers put negative ones into it, and none needs 2^31 ticks
            let rows = ctts.table_rows(4, 8)?;
            ticks(count, steps, rows.map(|row| (number(row), number(&row[4..]).cast_signed())))
        }
    };
    presentation_times.ok_or_else(|| stts.refuse(format!("it gives fewer times than the {count} samples of the film")))
}

/// Times of display, sorted: times of decoding plus the shifts of frames that are coded out of order.
///
/// `steps` and `shifts` are runs of (how many samples, ticks). None when times are missing.
fn ticks(
    count: usize,
    steps: impl Iterator<Item = (u32, u32)>,
    shifts: impl Iterator<Item = (u32, i32)>,
) -> Option<DisplayTicks> {
    let steps = steps.flat_map(|(n, ticks)| repeat_n(i64::from(ticks), n as usize));
    let shifts = shifts.flat_map(|(n, ticks)| repeat_n(i64::from(ticks), n as usize));
    let (mut at, mut end) = (0, i64::MIN);
    let mut starts = Vec::with_capacity(count);
    for (step, shift) in steps.zip(shifts.chain(std::iter::repeat(0))).take(count) {
        starts.push(at + shift);
        end = end.max(at + shift + step);
        at += step;
    }
    starts.sort_unstable();
    (starts.len() == count && count > 0).then_some(DisplayTicks { starts, end })
}

/// The 32-bit number at the start of a row.
fn number(row: &[u8]) -> u32 {
    row.iter().take(4).fold(0, |sum, &byte| sum << 8 | u32::from(byte))
}

/// The 64-bit number at the start of a row.
fn long_number(row: &[u8]) -> u64 {
    row.iter().take(8).fold(0, |sum, &byte| sum << 8 | u64::from(byte))
}

#[cfg(test)]
mod tests {
    use super::super::boxes::build::{boxed, numbers, parent};
    use super::*;

    #[test]
    fn samples_follow_each_other_inside_their_chunks() {
        let samples = |chunks: &[u64], runs: &[(u32, u32)]| {
            place_samples(&[5, 6, 7, 8], chunks.iter().copied(), runs.iter().copied())
        };
        let found = samples(&[100, 300], &[(1, 3), (2, 1)]).unwrap();
        assert_eq!(found.iter().map(|s| s.offset).collect::<Vec<_>>(), [100, 105, 111, 300]);
        assert!(samples(&[100], &[(1, 3)]).is_none());
        assert!(samples(&[u64::MAX - 3], &[(1, 4)]).is_none());
    }

    #[test]
    fn frames_coded_out_of_order_are_shown_in_order() {
        let shifts = [(1, 20), (1, 40), (1, 10), (1, 10)];
        let found = ticks(4, [(4, 10)].into_iter(), shifts.into_iter()).unwrap();
        assert_eq!(found, DisplayTicks { starts: vec![20, 30, 40, 50], end: 60 });
    }

    #[test]
    fn shifts_may_be_negative_in_either_version_of_the_table() {
        for version in [0, 1 << 24] {
            let stts = boxed(b"stts", &numbers(&[0, 1, 3, 10]));
            let ctts = boxed(b"ctts", &numbers(&[version, 3, 1, 0, 1, 10, 1, (-10_i32).cast_unsigned()]));
            let content = [stts, ctts].concat();
            let found = display_ticks(&parent(b"stbl", &content), 3).unwrap();
            assert_eq!(found.starts, [0, 10, 20]);
        }
    }

    /// A sample table with these sizes of samples in one chunk at byte 100.
    fn stbl(stsz: &[u32]) -> Vec<u8> {
        let (stsc, stco) = (boxed(b"stsc", &numbers(&[0, 1, 1, 9, 1])), boxed(b"stco", &numbers(&[0, 1, 100])));
        [boxed(b"stsz", &numbers(stsz)), stsc, stco].concat()
    }

    #[test]
    fn a_number_of_samples_is_held_against_the_film_before_memory_is_reserved() {
        let read = |stsz: &[u32], bytes| {
            let content = stbl(stsz);
            read_samples(&parent(b"stbl", &content), bytes).map(|found| found.len())
        };
        assert_eq!(read(&[0, 160, 9], 2000).unwrap(), 9);
        for count in [200_000_000, u32::MAX] {
            let said = read(&[0, 160, count], 2000).unwrap_err().to_string();
            assert!(said.contains("`stsz` at byte 8") && said.contains("the film has 2000"), "{said}");
            let said = read(&[0, 0, count, 7, 7], 2000).unwrap_err().to_string();
            assert!(said.contains("limit is 10000000"), "{said}");
            assert!(matches!(read(&[0, 1, count], 1 << 40), Err(VideoError::TooLarge { .. })));
        }
        assert!(read(&[0, 0, 9_999_999, 7, 7], 2000).unwrap_err().to_string().contains("it has 8"));
        assert!(read(&[0, 70_000_000, 1], 1 << 40).unwrap_err().to_string().contains("67108864"));
    }
}
