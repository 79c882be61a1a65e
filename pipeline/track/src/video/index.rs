//! The index of a film: where each coded frame is in the file and when it is shown.

use super::{Quarter, VideoError, boxes};
use mp4::{MoovBox, ReadBox};
use si::Second;
use std::fs::File;
use std::io::{Cursor, Read, Seek, SeekFrom};
use std::path::Path;

/// One coded frame in the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sample {
    pub(super) offset: u64,
    pub(super) size: u64,
}

/// The metadata of the container.
pub(super) struct Index {
    pub(super) width: usize,
    pub(super) height: usize,
    /// How its pictures want to be turned.
    pub(super) turn: Quarter,
    /// In the order of decoding.
    pub(super) samples: Vec<Sample>,
    /// In the order of showing, from 0 s.
    pub(super) times: Vec<Second>,
    /// SPS and PPS, each with its start code.
    pub(super) parameters: Vec<u8>,
    /// Bytes of the length in front of each NAL unit.
    pub(super) length_bytes: usize,
}

/// Reads the index and holds every sample against the file's length.
///
/// # Errors
/// [`VideoError`]: not an MP4, cut short, or not H.264.
pub(super) fn read(file: &mut File, path: &Path) -> Result<Index, VideoError> {
    let disk = |e| VideoError::reading(path, e);
    let place = boxes::find_index(file, path)?;
    let mut moov_bytes = vec![0; (place.end - place.start) as usize];
    file.seek(SeekFrom::Start(place.start)).map_err(disk)?;
    file.read_exact(&mut moov_bytes).map_err(disk)?;
    let refused =
        |why: String| VideoError::NotMp4 { path: path.into(), found: format!("its index cannot be read: {why}") };
    let unknown = || VideoError::UnknownCodec { path: path.into(), codec: codecs(&moov_bytes) };

    let moov = parse(&moov_bytes).map_err(|e| refused(e.to_string()))?;
    let film = moov.traks.iter().find(|t| t.mdia.minf.stbl.stsd.avc1.is_some()).ok_or_else(unknown)?;
    let table = &film.mdia.minf.stbl;
    let size = |i| match table.stsz.sample_size {
        0 => table.stsz.sample_sizes.get(i).map(|&s| u64::from(s)),
        all => Some(u64::from(all)),
    };
    let sizes: Option<Vec<u64>> = (0..table.stsz.sample_count as usize).map(size).collect();
    let short = table.stco.iter().flat_map(|t| &t.entries).map(|&o| u64::from(o));
    let chunks: Vec<u64> = short.chain(table.co64.iter().flat_map(|t| t.entries.clone())).collect();
    let runs: Vec<_> = table.stsc.entries.iter().map(|e| (e.first_chunk as usize, e.samples_per_chunk)).collect();
    let samples = sizes.and_then(|sizes| samples(&sizes, &chunks, &runs));
    let samples = samples.ok_or_else(|| refused("its tables of samples contradict each other".into()))?;
    let bytes = file.metadata().map_err(disk)?.len();
    if let Some(frame) = samples.iter().position(|s| s.offset.saturating_add(s.size) > bytes) {
        let needed = samples[frame].offset.saturating_add(samples[frame].size);
        return Err(VideoError::Truncated { path: path.into(), frame, expected: samples.len(), needed, bytes });
    }
    let avc1 = table.stsd.avc1.as_ref().ok_or_else(unknown)?;
    let mut parameters = Vec::new();
    for unit in avc1.avcc.sequence_parameter_sets.iter().chain(&avc1.avcc.picture_parameter_sets) {
        parameters.extend_from_slice(&super::writer::START_CODE);
        parameters.extend_from_slice(&unit.bytes);
    }
    let steps: Vec<_> = table.stts.entries.iter().map(|e| (e.sample_count, e.sample_delta)).collect();
    let shifts = table.ctts.iter().flat_map(|t| &t.entries);
    let shifts: Vec<_> = shifts.map(|e| (e.sample_count, e.sample_offset)).collect();
    let times = times(samples.len(), &steps, &shifts, film.mdia.mdhd.timescale);
    let times = times.ok_or_else(|| refused("its frames have no times".into()))?;
    let turn = &film.tkhd.matrix;
    Ok(Index {
        width: avc1.width.into(),
        height: avc1.height.into(),
        turn: Quarter::of_matrix(turn.a, turn.b, turn.c, turn.d).unwrap_or_default(),
        samples,
        times,
        parameters,
        length_bytes: usize::from(avc1.avcc.length_size_minus_one & 3) + 1,
    })
}

/// The mp4 crate must be called just after the box's header: it computes the box's end from that position.
fn parse(moov: &[u8]) -> Result<MoovBox, mp4::Error> {
    let size = moov.len() as u64 + mp4::HEADER_SIZE;
    let mut whole = vec![0; mp4::HEADER_SIZE as usize];
    whole.extend_from_slice(moov);
    let mut reader = Cursor::new(whole);
    reader.set_position(mp4::HEADER_SIZE);
    MoovBox::read_box(&mut reader, size)
}

/// The four letters of every codec that the index names.
fn codecs(moov: &[u8]) -> String {
    let places = moov.windows(4).enumerate().filter(|(_, w)| w == b"stsd").map(|(i, _)| i + 16);
    let names: Vec<_> =
        places.filter_map(|i| moov.get(i..i + 4)).map(|name| String::from_utf8_lossy(name).into_owned()).collect();
    if names.is_empty() { "nothing known".into() } else { names.join(", ") }
}

/// Offset and size of every sample: chunks begin at the offsets of the table, samples follow each other inside a chunk.
///
/// `runs` holds (first chunk, from 1; samples in each chunk from there on). None when the tables do not fit together.
fn samples(sizes: &[u64], chunks: &[u64], runs: &[(usize, u32)]) -> Option<Vec<Sample>> {
    let mut out = Vec::with_capacity(sizes.len());
    let mut runs = runs.iter().peekable();
    let mut per_chunk = 0;
    for (number, &chunk) in chunks.iter().enumerate() {
        if let Some(&(_, new)) = runs.next_if(|(first, _)| *first == number + 1) {
            per_chunk = new as usize;
        }
        let mut offset = chunk;
        for &size in sizes.iter().skip(out.len()).take(per_chunk) {
            out.push(Sample { offset, size });
            offset = offset.checked_add(size)?;
        }
    }
    (out.len() == sizes.len() && !out.is_empty()).then_some(out)
}

/// Times of showing, sorted, from 0 s: decoding times plus the shifts of frames that are coded out of order.
///
/// `steps` and `shifts` are runs of (how many samples, ticks), `rate` the ticks of a second. None when times are missing.
fn times(count: usize, steps: &[(u32, u32)], shifts: &[(u32, i32)], rate: u32) -> Option<Vec<Second>> {
    let steps = steps.iter().flat_map(|&(n, ticks)| std::iter::repeat_n(i64::from(ticks), n as usize));
    let shifts = shifts.iter().flat_map(|&(n, ticks)| std::iter::repeat_n(i64::from(ticks), n as usize));
    let mut at = 0;
    let mut ticks = Vec::with_capacity(count);
    for (step, shift) in steps.zip(shifts.chain(std::iter::repeat(0))).take(count) {
        ticks.push(at + shift);
        at += step;
    }
    ticks.sort_unstable();
    let first = *ticks.first()?;
    let second = |t: i64| (t - first) as f64 / f64::from(rate);
    (ticks.len() == count && rate > 0).then(|| ticks.into_iter().map(second).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_follow_each_other_inside_their_chunks() {
        let found = samples(&[5, 6, 7, 8], &[100, 300], &[(1, 3), (2, 1)]).unwrap();
        assert_eq!(found.iter().map(|s| s.offset).collect::<Vec<_>>(), [100, 105, 111, 300]);
        assert!(samples(&[5, 6, 7, 8], &[100], &[(1, 3)]).is_none());
    }

    #[test]
    fn frames_coded_out_of_order_are_shown_in_order() {
        let shown = times(4, &[(4, 10)], &[(1, 20), (1, 40), (1, 10), (1, 10)], 1000).unwrap();
        assert_eq!(shown, [0.0, 0.01, 0.02, 0.03]);
    }
}
