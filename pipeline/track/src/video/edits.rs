//! Edit list of a track (ISO/IEC 14496-12, section 8.6.6): which part of its frames is displayed, and with which delay.
//!
//! Phones trim a film by its edit list alone: the frames that were cut away stay in the file, where they serve as references. Encoders
//! with B-frames write one edit that begins at the first displayed frame. Several parts of one film are not joined here.

use super::VideoError;
use super::boxes::Mp4Box;
use super::tables::DisplayTicks;
use si::Second;
use std::ops::Range;

/// The one part of a track that is displayed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Edit {
    /// First tick of the track's clock that is displayed.
    start: i64,
    /// Duration in ticks of the movie's clock; none: to the end.
    duration: Option<u64>,
    /// Empty edits in front of it, ticks of the movie's clock.
    delay: u64,
}

/// Ticks of a second of the movie's clock and of the track's.
#[derive(Debug, Clone, Copy)]
pub(super) struct Clocks {
    pub(super) movie: u32,
    pub(super) track: u32,
}

/// One entry of the list; a media time of -1 makes it empty.
struct Entry {
    duration: u64,
    media_time: i64,
    /// Fixed point, 16 bits behind the point.
    rate: u32,
}

/// A rate of one.
const UNCHANGED: u32 = 1 << 16;

/// The edit of a track, none when it has no list.
///
/// # Errors
/// [`VideoError::Edits`] for several parts, a changed rate or nothing at all; [`VideoError::DamagedBox`].
pub(super) fn read_edit(trak: &Mp4Box) -> Result<Option<Edit>, VideoError> {
    let Some(edts) = trak.find_child(b"edts")? else { return Ok(None) };
    let Some(elst) = edts.find_child(b"elst")? else { return Ok(None) };
    let entries = read_entries(&elst)?;
    if entries.is_empty() {
        return Ok(None);
    }
    let part = only_part(&entries).map_err(|why| VideoError::Edits { path: trak.path.into(), why })?;
    let Entry { duration, media_time, .. } = entries[part];
    if media_time < 0 {
        return Err(elst.refuse(format!("an edit begins at {media_time} ticks")));
    }
    let delay = entries[..part].iter().try_fold(0_u64, |sum, entry| sum.checked_add(entry.duration));
    let delay = delay.ok_or_else(|| elst.refuse("its empty edits last more than 2^64 ticks"))?;
    Ok(Some(Edit { start: media_time, duration: (duration > 0).then_some(duration), delay }))
}

/// Which entry is the only one that is not empty, or why the list is not read.
fn only_part(entries: &[Entry]) -> Result<usize, String> {
    let parts: Vec<usize> = (0..entries.len()).filter(|&k| entries[k].media_time != -1).collect();
    match parts[..] {
        [] => Err("its edit list displays no frame".into()),
        [part] if entries[part].rate != UNCHANGED => {
            Err(format!("its edit list plays it at {} times its rate", f64::from(entries[part].rate) / 65536.0))
        }
        [part] => Ok(part),
        _ => Err(format!("its edit list joins {} parts; one is read", parts.len())),
    }
}

fn read_entries(elst: &Mp4Box) -> Result<Vec<Entry>, VideoError> {
    let long = match elst.version()? {
        0 => false,
        1 => true,
        other => return Err(elst.refuse(format!("it has the version {other}; 0 and 1 are known"))),
    };
    let rows = elst.table_rows(4, if long { 20 } else { 12 })?;
    Ok(rows.map(|row| read_entry(row, long)).collect())
}

/// An entry from its 12 or 20 bytes.
fn read_entry(row: &[u8], long: bool) -> Entry {
    let number = |from: &[u8]| from.iter().fold(0_u64, |sum, &byte| sum << 8 | u64::from(byte));
    let width = if long { 8 } else { 4 };
    let ([duration, time], rate) = ([&row[..width], &row[width..2 * width]].map(number), number(&row[2 * width..]));
    let media_time = if long { time.cast_signed() } else { i64::from((time as u32).cast_signed()) };
    Entry { duration, media_time, rate: rate as u32 }
}

impl Edit {
    /// The frames that are displayed, of those in the order of display.
    ///
    /// Durations are rounded to a tick of the movie's clock, which may be longer than a frame. A frame that begins in the last tick is
    /// therefore none of the film's, and an edit that ends within a tick of the track's end ends with the track.
    pub(super) fn frame_range(&self, ticks: &DisplayTicks, clocks: Clocks) -> Range<usize> {
        let first = ticks.starts.partition_point(|&start| start < self.start);
        let Some(duration) = self.duration else { return first..ticks.starts.len() };
        // in units of 1 / (movie × track) s, which hold both clocks exactly
        let [movie, track] = [clocks.movie, clocks.track].map(i128::from);
        let since = |tick: i64| (i128::from(tick) - i128::from(self.start)) * movie;
        let end = i128::from(duration) * track;
        if since(ticks.end) - track <= end {
            return first..ticks.starts.len();
        }
        first..ticks.starts.partition_point(|&start| since(start) + track <= end).max(first)
    }

    /// How long nothing is displayed before the first frame.
    pub(super) fn start_delay(&self, clocks: Clocks) -> Second {
        self.delay as f64 / f64::from(clocks.movie)
    }
}

#[cfg(test)]
mod tests {
    use super::super::boxes::build::{boxed, numbers, parent};
    use super::*;

    const NORMAL: u32 = UNCHANGED;
    const EMPTY: u32 = u32::MAX;

    /// The edit of a list of (duration, media time, rate) of version 0.
    fn of(list: &[[u32; 3]]) -> Result<Option<Edit>, String> {
        let content = [numbers(&[0, list.len() as u32]), numbers(list.as_flattened())].concat();
        let edts = boxed(b"edts", &boxed(b"elst", &content));
        read_edit(&parent(b"trak", &edts)).map_err(|e| e.to_string())
    }

    /// The frames of ten at 30 frames/s in ticks of 1/15,360 s, of a movie with ticks of 1 ms.
    fn frames(list: &[[u32; 3]]) -> Range<usize> {
        let ticks = DisplayTicks { starts: (0..10).map(|k| 512 * k).collect(), end: 5120 };
        of(list).unwrap().unwrap().frame_range(&ticks, Clocks { movie: 1000, track: 15_360 })
    }

    #[test]
    fn a_part_begins_and_ends_with_whole_frames() {
        assert_eq!(frames(&[[0, 0, NORMAL]]), 0..10);
        assert_eq!(frames(&[[0, 3 * 512, NORMAL]]), 3..10);
        assert_eq!(frames(&[[0, 3 * 512 + 1, NORMAL]]), 4..10);
        assert_eq!(frames(&[[100, 3 * 512, NORMAL]]), 3..6);
        assert_eq!(frames(&[[100, 20 * 512, NORMAL]]), 10..10);
    }

    #[test]
    fn a_duration_that_was_rounded_to_the_clock_of_the_movie_keeps_the_number_of_frames() {
        // four frames last 133.33 ms
        assert_eq!(frames(&[[133, 0, NORMAL]]), 0..4);
        assert_eq!(frames(&[[134, 0, NORMAL]]), 0..4);
        // 2000 frames/s: the last two frames begin in the last tick of a film that is not trimmed
        let ticks = DisplayTicks { starts: (0..9).collect(), end: 9 };
        let whole = of(&[[4, 0, NORMAL]]).unwrap().unwrap();
        assert_eq!(whole.frame_range(&ticks, Clocks { movie: 1000, track: 2000 }), 0..9);
    }

    #[test]
    fn empty_edits_in_front_delay_and_others_do_nothing() {
        let edit = of(&[[250, EMPTY, NORMAL], [250, EMPTY, NORMAL], [100, 512, NORMAL], [70, EMPTY, NORMAL]]);
        let edit = edit.unwrap().unwrap();
        assert!((edit.start_delay(Clocks { movie: 1000, track: 15_360 }) - 0.5).abs() < 1e-12);
        assert_eq!(edit, Edit { start: 512, duration: Some(100), delay: 500 });
    }

    #[test]
    fn both_versions_of_the_list_are_read() {
        let row = [&100_u64.to_be_bytes()[..], &512_u64.to_be_bytes(), &NORMAL.to_be_bytes()].concat();
        let content = [numbers(&[1 << 24, 1]), row].concat();
        let edts = boxed(b"edts", &boxed(b"elst", &content));
        assert_eq!(read_edit(&parent(b"trak", &edts)).unwrap(), of(&[[100, 512, NORMAL]]).unwrap());
    }

    #[test]
    fn lists_that_need_an_editor_are_refused_with_what_to_do() {
        for (list, word) in [
            (&[[100, 0, NORMAL], [100, 512, NORMAL]][..], "joins 2 parts"),
            (&[[100, 0, NORMAL / 2]], "0.5 times"),
            (&[[100, EMPTY, NORMAL]], "no frame"),
        ] {
            let said = of(list).unwrap_err();
            assert!(
                said.contains(word) && said.contains("do:  write its displayed frames to a new film: ffmpeg"),
                "{said}"
            );
        }
        assert!(of(&[[100, EMPTY - 1, NORMAL]]).unwrap_err().contains("begins at -2 ticks"));
        assert_eq!(of(&[]), Ok(None));
    }
}
