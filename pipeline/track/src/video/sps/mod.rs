//! Sequence parameter set of H.264 (section 7.3.2.1.1): profile, sample format and size of the pictures, up to the cropping.
//!
//! The bits are untrusted: reading past their end gives none, and no loop is longer than the bits that it reads.

use super::feature::{Feature, MAX_MACROBLOCKS, MAX_MACROBLOCKS_A_SIDE};

/// Bytes that are looked at: 12 scaling lists, the longest part, take up to 3 kB.
const MAX_BYTES: usize = 8192;
/// Profiles whose sets hold a sample format.
const WITH_FORMAT: [u8; 14] = [100, 110, 122, 144, 244, 44, 83, 86, 118, 128, 138, 139, 134, 135];
/// Profiles that are decoded: Baseline, Main, Extended, scalable Baseline and High by their base layer, High.
const DECODED: [u8; 6] = [66, 77, 83, 86, 88, 100];

/// The part of a sequence parameter set that decides whether its film can be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct SequenceParameters {
    profile: u8,
    /// 0: monochrome, 1: 4:2:0, 2: 4:2:2, 3: 4:4:4.
    chroma_format: u32,
    /// Bits of a luma and of a chroma sample.
    bit_depths: [u32; 2],
    is_progressive: bool,
    /// Width and height in macroblocks.
    macroblocks: [u64; 2],
    /// Width and height that are displayed, px.
    pub(super) size: [u64; 2],
}

impl SequenceParameters {
    /// Reads a NAL unit, its header among it; none when it ends early or a value is out of range.
    pub(super) fn read(unit: &[u8]) -> Option<Self> {
        let bytes = without_emulation_prevention(unit.get(1..unit.len().min(MAX_BYTES))?);
        let (&profile, _) = bytes.split_first()?;
        let mut bits = Bits { bytes: &bytes, at: 24 };
        bits.read_unsigned()?; // seq_parameter_set_id
        let (chroma_format, bit_depths) =
            if WITH_FORMAT.contains(&profile) { read_format(&mut bits)? } else { (1, [8, 8]) };
        order_count(&mut bits)?;
        bits.read_unsigned()?; // max_num_ref_frames
        bits.read_bit()?; // gaps_in_frame_num_value_allowed_flag
        let (macroblocks, is_progressive) = read_macroblocks(&mut bits)?;
        bits.read_bit()?; // direct_8x8_inference_flag
        let size = cropped_size(&mut bits, macroblocks, crop_units(chroma_format, is_progressive))?;
        Some(Self { profile, chroma_format, bit_depths, is_progressive, macroblocks, size })
    }

    /// What the built-in decoder lacks for it.
    pub(super) fn unsupported_feature(&self) -> Option<Feature> {
        let [width, height] = self.macroblocks;
        match *self {
            Self { chroma_format: 2, .. } => Some(Feature::Chroma("4:2:2")),
            Self { chroma_format: 3, .. } => Some(Feature::Chroma("4:4:4")),
            Self { bit_depths: [luma, chroma], .. } if luma.max(chroma) > 8 => {
                Some(Feature::BitDepth(luma.max(chroma)))
            }
            Self { is_progressive: false, .. } => Some(Feature::Interlaced),
            Self { profile, .. } if !DECODED.contains(&profile) => Some(Feature::Profile(profile)),
            _ if width * height > MAX_MACROBLOCKS || width.max(height) > MAX_MACROBLOCKS_A_SIDE => {
                Some(Feature::Size(self.size[0], self.size[1]))
            }
            _ => None,
        }
    }
}

/// chroma_format_idc and the bit depths.
fn read_format(bits: &mut Bits) -> Option<(u32, [u32; 2])> {
    let chroma_format = bits.read_unsigned().filter(|&format| format <= 3)?;
    if chroma_format == 3 {
        bits.read_bit()?; // separate_colour_plane_flag
    }
    let mut depth = || bits.read_unsigned().filter(|&more| more <= 6).map(|more| 8 + more);
    let depths = [depth()?, depth()?];
    bits.read_bit()?; // qpprime_y_zero_transform_bypass_flag
    if bits.read_bit()? {
        for list in 0..if chroma_format == 3 { 12 } else { 8 } {
            if bits.read_bit()? {
                pass_scaling_list(bits, if list < 6 { 16 } else { 64 })?;
            }
        }
    }
    Some((chroma_format, depths))
}

/// Passes over a scaling list (section 7.3.2.1.1.1).
fn pass_scaling_list(bits: &mut Bits, length: usize) -> Option<()> {
    let (mut last, mut next) = (8_i32, 8_i32);
    for _ in 0..length {
        if next != 0 {
            next = last.wrapping_add(bits.read_signed()?).rem_euclid(256);
        }
        last = if next == 0 { last } else { next };
    }
    Some(())
}

/// Passes over log2_max_frame_num_minus4 and the picture order count.
fn order_count(bits: &mut Bits) -> Option<()> {
    bits.read_unsigned()?;
    match bits.read_unsigned()? {
        0 => bits.read_unsigned().map(drop),
        1 => {
            bits.read_bit()?;
            let _ = (bits.read_signed()?, bits.read_signed()?);
            // at most 255 by section 7.4.2.1.1; a longer cycle is damage
            let cycle = bits.read_unsigned().filter(|&n| n <= 255)?;
            (0..cycle).try_for_each(|_| bits.read_signed().map(drop))
        }
        2 => Some(()),
        _ => None,
    }
}

/// Width and height in macroblocks, and frame_mbs_only_flag.
fn read_macroblocks(bits: &mut Bits) -> Option<([u64; 2], bool)> {
    let (width, height) = (u64::from(bits.read_unsigned()?) + 1, u64::from(bits.read_unsigned()?) + 1);
    let is_progressive = bits.read_bit()?;
    if is_progressive {
        return Some(([width, height], true));
    }
    bits.read_bit()?; // mb_adaptive_frame_field_flag
    // heights are those of a field, half of a frame's
    Some(([width, 2 * height], false))
}

/// Pixels in a unit of the cropping, across and down (equations 7-19 to 7-22).
fn crop_units(chroma_format: u32, is_progressive: bool) -> [u64; 2] {
    let rows = if is_progressive { 1 } else { 2 };
    match chroma_format {
        1 => [2, 2 * rows],
        2 => [2, rows],
        _ => [1, rows],
    }
}

/// Displayed width and height: the macroblocks without the cropping, which is counted in `units` of pixels.
fn cropped_size(bits: &mut Bits, macroblocks: [u64; 2], units: [u64; 2]) -> Option<[u64; 2]> {
    let [mut width, mut height] = macroblocks.map(|n| 16 * n);
    if bits.read_bit()? {
        let mut crop = || bits.read_unsigned().map(u64::from);
        let [left, right, top, bottom] = [crop()?, crop()?, crop()?, crop()?];
        width = width.checked_sub((left + right) * units[0])?;
        height = height.checked_sub((top + bottom) * units[1])?;
    }
    Some([width, height])
}

/// The payload of a NAL unit: each 3 behind two zeros only keeps the bytes from looking like a start code (section 7.4.1).
fn without_emulation_prevention(payload: &[u8]) -> Vec<u8> {
    let mut out = Vec::with_capacity(payload.len());
    let mut zeros = 0;
    for &byte in payload {
        if zeros >= 2 && byte == 3 {
            zeros = 0;
            continue;
        }
        zeros = if byte == 0 { zeros + 1 } else { 0 };
        out.push(byte);
    }
    out
}

/// Bits of a payload, most significant first.
struct Bits<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Bits<'_> {
    fn read_bit(&mut self) -> Option<bool> {
        let byte = self.bytes.get(self.at / 8)?;
        let bit = byte >> (7 - self.at % 8) & 1;
        self.at += 1;
        Some(bit == 1)
    }

    /// An Exp-Golomb code (section 9.1); none when it has more than 32 bits.
    fn read_unsigned(&mut self) -> Option<u32> {
        let mut zeros = 0;
        while !self.read_bit()? {
            zeros += 1;
            if zeros > 31 {
                return None;
            }
        }
        let mut suffix = 0;
        for _ in 0..zeros {
            suffix = suffix << 1 | u32::from(self.read_bit()?);
        }
        Some((1_u32 << zeros) - 1 + suffix)
    }

    /// A signed Exp-Golomb code (section 9.1.1).
    fn read_signed(&mut self) -> Option<i32> {
        let code = i64::from(self.read_unsigned()?);
        let magnitude = (code + 1) / 2;
        i32::try_from(if code % 2 == 1 { magnitude } else { -magnitude }).ok()
    }
}

#[cfg(test)]
mod tests;
