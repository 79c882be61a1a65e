//! The index of a film: where each coded frame is in the file, which frames are displayed, and when.

use super::boxes::Mp4Box;
use super::edits::{self, Clocks};
use super::outermost::Source;
use super::tables::{self, Sample};
use super::{Feature, Quarter, VideoError, avc};
use si::Second;
use std::ops::Range;
use std::path::Path;

/// The metadata of the container.
pub(super) struct Index {
    pub(super) width: usize,
    pub(super) height: usize,
    /// How its pictures want to be turned.
    pub(super) turn: Quarter,
    /// In the order of decoding.
    pub(super) samples: Vec<Sample>,
    /// The frames of the film, of all samples in the order of display; the others are references of theirs.
    pub(super) displayed: Range<usize>,
    /// Of the frames of the film, from the first one on, behind the delay of its edit list.
    pub(super) times: Vec<Second>,
    /// SPS and PPS, each with its start code.
    pub(super) parameters: Vec<u8>,
    /// Bytes of the length in front of each NAL unit.
    pub(super) length_bytes: usize,
}

/// Reads the index and holds every sample against the file's length.
///
/// # Errors
/// [`VideoError`]: not an MP4, damaged, cut short, too large, or not of a kind that is decoded.
pub(super) fn read_index(mut source: Source) -> Result<Index, VideoError> {
    let (bytes, path) = (source.bytes, source.path);
    let index_bytes = source.find_index()?;
    let moov = index_bytes.moov_box(path);
    check_plain(&moov)?;
    let (trak, avc1) = film_track(&moov)?;
    let mdia = trak.required_child(b"mdia")?;
    let stbl = mdia.required_child(b"minf")?.required_child(b"stbl")?;
    let samples = tables::read_samples(&stbl, bytes)?;
    check_whole(&samples, bytes, path)?;
    let avc = avc::read_avc(&avc1)?;
    let (displayed, times) = displayed_frames(&moov, &trak, samples.len())?;
    let turn = quarter_turn(&trak.required_child(b"tkhd")?)?;
    let avc::Avc { width, height, parameters, length_bytes } = avc;
    Ok(Index { width, height, turn, samples, displayed, times, parameters, length_bytes })
}

/// The first track that is coded as H.264, and its sample entry.
fn film_track<'a>(moov: &Mp4Box<'a>) -> Result<(Mp4Box<'a>, Mp4Box<'a>), VideoError> {
    let mut codecs = Vec::new();
    for child in moov.children() {
        let trak = child?;
        if &trak.name != b"trak" {
            continue;
        }
        let stsd =
            trak.required_child(b"mdia")?.required_child(b"minf")?.required_child(b"stbl")?.required_child(b"stsd")?;
        for entry in stsd.children_behind(8)? {
            let entry = entry?;
            if &entry.name == b"avc1" {
                return Ok((trak, entry));
            }
            codecs.push(entry.name.escape_ascii().to_string());
        }
    }
    match codecs.is_empty() {
        true => Err(moov.refuse("it holds no track (`trak`) with a sample entry")),
        false => Err(VideoError::UnknownCodec { path: moov.path.into(), codec: codecs.join(", ") }),
    }
}

/// Whether the index lists all frames, and in the open.
fn check_plain(moov: &Mp4Box) -> Result<(), VideoError> {
    for (name, feature) in [(b"mvex", Feature::Fragments), (b"cmov", Feature::CompressedIndex)] {
        if moov.find_child(name)?.is_some() {
            return Err(VideoError::Unsupported { path: moov.path.into(), feature });
        }
    }
    Ok(())
}

fn check_whole(samples: &[Sample], bytes: u64, path: &Path) -> Result<(), VideoError> {
    let end = |sample: &Sample| sample.offset.saturating_add(sample.size);
    let Some(frame) = samples.iter().position(|sample| end(sample) > bytes) else { return Ok(()) };
    let (expected, needed) = (samples.len(), end(&samples[frame]));
    Err(VideoError::Truncated { path: path.into(), frame, expected, needed, bytes })
}

/// Which frames are displayed, and their times.
fn displayed_frames(moov: &Mp4Box, trak: &Mp4Box, count: usize) -> Result<(Range<usize>, Vec<Second>), VideoError> {
    let mdia = trak.required_child(b"mdia")?;
    let ticks = tables::display_ticks(&mdia.required_child(b"minf")?.required_child(b"stbl")?, count)?;
    let edit = edits::read_edit(trak)?;
    let track = timescale(&mdia.required_child(b"mdhd")?)?;
    let (frames, delay) = match edit {
        None => (0..count, 0.0),
        Some(edit) => {
            let clocks = Clocks { movie: timescale(&moov.required_child(b"mvhd")?)?, track };
            (edit.frame_range(&ticks, clocks), edit.start_delay(clocks))
        }
    };
    let displayed_ticks = &ticks.starts[frames.clone()];
    let Some(&first) = displayed_ticks.first() else {
        let why = format!("its edit list displays none of its {count} frames");
        return Err(VideoError::Edits { path: moov.path.into(), why });
    };
    let time = |&tick: &i64| delay + (tick - first) as f64 / f64::from(track);
    Ok((frames, displayed_ticks.iter().map(time).collect()))
}

/// Ticks a second of a header of the movie (mvhd) or of a track's media (mdhd).
fn timescale(header: &Mp4Box) -> Result<u32, VideoError> {
    // two times of 32 or 64 bits stand in front
    let ticks_offset = if header.version()? == 1 { 20 } else { 12 };
    match header.number_at(ticks_offset)? {
        0 => Err(header.refuse("its clock has no ticks a second")),
        ticks => Ok(ticks),
    }
}

/// How the pictures of a track want to be turned, from the matrix of its header.
fn quarter_turn(tkhd: &Mp4Box) -> Result<Quarter, VideoError> {
    let matrix = if tkhd.version()? == 1 { 52 } else { 40 };
    let number = |k: usize| tkhd.number_at(matrix + 4 * k).map(u32::cast_signed);
    Ok(Quarter::of_matrix(number(0)?, number(1)?, number(3)?, number(4)?).unwrap_or_default())
}
