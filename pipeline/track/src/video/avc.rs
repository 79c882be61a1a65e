//! Sample entry of H.264 (avc1, ISO/IEC 14496-15, section 5.3): size of the pictures, parameter sets, length of a NAL unit's size.

use super::VideoError;
use super::boxes::Mp4Box;
use super::sps::SequenceParameters;
use super::writer::{SEQUENCE_PARAMETERS, START_CODE};
use crate::limits::is_picture_size;
use std::path::Path;

/// Bytes of a visual sample entry in front of its boxes.
const ENTRY: usize = 78;

/// What the decoder needs in front of the first sample.
pub(super) struct Avc {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Sequence and picture parameter sets, each with its start code.
    pub(super) parameters: Vec<u8>,
    /// Bytes of the length in front of each NAL unit.
    pub(super) length_bytes: usize,
}

/// Reads a box avc1.
///
/// # Errors
/// [`VideoError::Unsupported`] for a sample format that is not decoded, [`VideoError::PictureSize`], [`VideoError::DamagedBox`].
pub(super) fn read_avc(avc1: &Mp4Box) -> Result<Avc, VideoError> {
    let [width, height] = [avc1.bytes_at(24)?, avc1.bytes_at(26)?].map(u16::from_be_bytes);
    let is_avcc = |found: &Result<Mp4Box, VideoError>| found.as_ref().map_or(true, |child| &child.name == b"avcC");
    let avcc = avc1.children_behind(ENTRY)?.find(is_avcc).transpose()?;
    let avcc = avcc.ok_or_else(|| avc1.refuse("it holds no box `avcC`"))?;
    let [_, _, _, _, lengths, count] = avcc.bytes_at(0)?;
    let mut offset = 6;
    let mut parameters = read_units(&avcc, &mut offset, count & 31, true)?;
    let [count] = avcc.bytes_at(offset)?;
    offset += 1;
    parameters.extend(read_units(&avcc, &mut offset, count, false)?);
    check_size(avc1.path, [width.into(), height.into()])?;
    Ok(Avc { width: width.into(), height: height.into(), parameters, length_bytes: usize::from(lengths & 3) + 1 })
}

/// `count` parameter sets from `offset` on, each with its start code.
fn read_units(avcc: &Mp4Box, offset: &mut usize, count: u8, of_sequence: bool) -> Result<Vec<u8>, VideoError> {
    let mut out = Vec::new();
    for _ in 0..count {
        let length = usize::from(u16::from_be_bytes(avcc.bytes_at(*offset)?));
        let unit = avcc.content.get(*offset + 2..*offset + 2 + length);
        let unit =
            unit.ok_or_else(|| avcc.refuse(format!("a parameter set of {length} bytes reaches past its end")))?;
        if of_sequence {
            check_unit(avcc.path, unit, || avcc.refuse("its sequence parameter set ends early or is out of range"))?;
        }
        out.extend_from_slice(&START_CODE);
        out.extend_from_slice(unit);
        *offset += 2 + length;
    }
    Ok(out)
}

/// Holds a sequence parameter set against what can be decoded; other units pass.
pub(super) fn check_unit(path: &Path, unit: &[u8], damaged: impl FnOnce() -> VideoError) -> Result<(), VideoError> {
    if unit.first().is_none_or(|head| head & 31 != SEQUENCE_PARAMETERS) {
        return Ok(());
    }
    let set = SequenceParameters::read(unit).ok_or_else(damaged)?;
    // the size comes first: what is too large for any picture is not better converted
    check_size(path, set.size)?;
    set.unsupported_feature().map_or(Ok(()), |feature| Err(VideoError::Unsupported { path: path.into(), feature }))
}

fn check_size(path: &Path, [width, height]: [u64; 2]) -> Result<(), VideoError> {
    match is_picture_size(width, height) {
        true => Ok(()),
        false => Err(VideoError::PictureSize { path: path.into(), width, height }),
    }
}

#[cfg(test)]
mod tests {
    use super::super::boxes::build::{boxed, parent};
    use super::*;

    /// A sample entry of pictures of a size, with the content of its avcC.
    fn entry(width: u16, height: u16, avcc: &[u8]) -> Result<Avc, VideoError> {
        let mut content = vec![0; ENTRY];
        content[24..26].copy_from_slice(&width.to_be_bytes());
        content[26..28].copy_from_slice(&height.to_be_bytes());
        content.extend(boxed(b"avcC", avcc));
        read_avc(&parent(b"avc1", &content))
    }

    #[test]
    fn parameter_sets_come_with_start_codes() {
        let found = entry(64, 48, &[1, 66, 0, 10, 0xff, 0xe0, 2, 0, 2, 0x68, 7, 0, 1, 0x68]).unwrap();
        assert_eq!((found.width, found.height, found.length_bytes), (64, 48, 4));
        assert_eq!(found.parameters, [0, 0, 0, 1, 0x68, 7, 0, 0, 0, 1, 0x68]);
    }

    #[test]
    fn parameter_sets_that_reach_past_their_box_are_refused() {
        for (avcc, word) in [
            (&[1, 66, 0, 10, 0xff, 0xe1, 0, 9, 0x67][..], "9 bytes reaches past"),
            (&[1, 66, 0, 10, 0xff, 0xe1, 0], "at least 8"),
            (&[1, 66, 0, 10, 0xff, 0xe1, 0, 2, 0x67, 66, 0], "ends early"),
            (&[1, 66], "at least 6"),
        ] {
            let said = entry(64, 48, avcc).err().unwrap().to_string();
            assert!(said.contains("`avcC` at byte 86") && said.contains(word), "{said}");
        }
    }

    #[test]
    fn a_size_of_no_picture_is_refused() {
        let none = [1, 66, 0, 10, 0xff, 0xe0, 0];
        for (width, height) in [(0, 48), (65_535, 65_535)] {
            let error = entry(width, height, &none).err().unwrap();
            assert!(matches!(error, VideoError::PictureSize { .. }), "{error}");
        }
    }
}
