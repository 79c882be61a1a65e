//! Parameter sets written bit by bit are read back, and cut or random ones end in none.

use super::*;

/// Bits that are being written.
#[derive(Default)]
struct Written(Vec<bool>);

impl Written {
    fn bits(mut self, value: u32, count: u32) -> Self {
        self.0.extend((0..count).rev().map(|k| value >> k & 1 == 1));
        self
    }

    fn unsigned(self, value: u32) -> Self {
        let length = (value + 1).ilog2();
        self.bits(0, length).bits(value + 1, length + 1)
    }

    /// A NAL unit: header, the bits, a stop bit, emulation prevention.
    fn unit(self) -> Vec<u8> {
        let bits = self.bits(1, 1).0;
        let bytes =
            bits.chunks(8).map(|eight| eight.iter().enumerate().map(|(k, &bit)| u8::from(bit) << (7 - k)).sum());
        let mut out = vec![0x67];
        for byte in bytes {
            if byte <= 3 && out.ends_with(&[0, 0]) {
                out.push(3);
            }
            out.push(byte);
        }
        out
    }
}

/// What differs between the sets of these tests.
#[derive(Clone, Copy)]
struct Set {
    profile: u32,
    chroma_format: u32,
    bits: u32,
    progressive: bool,
    macroblocks: [u32; 2],
    crop: [u32; 4],
}

const HIGH: Set =
    Set { profile: 100, chroma_format: 1, bits: 8, progressive: true, macroblocks: [120, 68], crop: [0, 0, 0, 4] };

fn written(set: Set) -> Vec<u8> {
    let mut out = Written::default().bits(set.profile, 8).bits(0, 8).bits(40, 8).unsigned(0);
    if set.profile >= 100 {
        out = out.unsigned(set.chroma_format);
        out = if set.chroma_format == 3 { out.bits(0, 1) } else { out };
        out = out.unsigned(set.bits - 8).unsigned(set.bits - 8).bits(0, 1).bits(0, 1);
    }
    out = out.unsigned(0).unsigned(0).unsigned(4).unsigned(4).bits(0, 1);
    out = out.unsigned(set.macroblocks[0] - 1).unsigned(set.macroblocks[1] - 1).bits(set.progressive.into(), 1);
    out = if set.progressive { out } else { out.bits(1, 1) };
    out = out.bits(1, 1).bits(1, 1);
    set.crop.into_iter().fold(out, Written::unsigned).bits(0, 1).unit()
}

fn read(set: Set) -> SequenceParameters {
    SequenceParameters::read(&written(set)).unwrap()
}

#[test]
fn a_full_hd_film_of_profile_high_is_read_with_its_cropping() {
    assert_eq!(read(HIGH).size, [1920, 1080]);
    assert_eq!(read(HIGH).unsupported_feature(), None);
    assert_eq!(read(Set { profile: 66, ..HIGH }).size, [1920, 1080]);
    assert_eq!(read(Set { crop: [1, 2, 3, 4], ..HIGH }).size, [1914, 1074]);
}

#[test]
fn each_format_that_is_not_decoded_is_named() {
    let named = |set| read(set).unsupported_feature();
    assert_eq!(named(Set { profile: 110, bits: 10, ..HIGH }), Some(Feature::BitDepth(10)));
    assert_eq!(named(Set { profile: 122, chroma_format: 2, ..HIGH }), Some(Feature::Chroma("4:2:2")));
    assert_eq!(named(Set { profile: 244, chroma_format: 3, ..HIGH }), Some(Feature::Chroma("4:4:4")));
    assert_eq!(named(Set { chroma_format: 0, crop: [0, 0, 0, 8], ..HIGH }), None);
    assert_eq!(named(Set { profile: 244, ..HIGH }), Some(Feature::Profile(244)));
    assert_eq!(named(Set { macroblocks: [480, 270], ..HIGH }), Some(Feature::Size(7680, 4312)));
}

#[test]
fn an_interlaced_film_has_twice_the_rows_and_crops_by_four() {
    let set = read(Set { progressive: false, macroblocks: [120, 34], crop: [0, 0, 0, 2], ..HIGH });
    assert_eq!((set.size, set.unsupported_feature()), ([1920, 1080], Some(Feature::Interlaced)));
}

#[test]
fn emulation_prevention_is_removed() {
    assert_eq!(without_emulation_prevention(&[0, 0, 3, 1, 0, 0, 0, 3, 3]), [0, 0, 1, 0, 0, 0, 3]);
}

#[test]
fn codes_are_bounded_in_length_and_range() {
    let unsigned = |bytes: &[u8]| Bits { bytes, at: 0 }.read_unsigned();
    assert_eq!(unsigned(&[0b0010_1000]), Some(4));
    assert_eq!(unsigned(&[0, 0, 0, 1, 0xff, 0xff, 0xff, 0xff]), Some(u32::MAX - 1));
    assert_eq!(unsigned(&[0; 100]), None);
    assert_eq!(unsigned(&[0, 0, 1]), None);
    assert_eq!(Bits { bytes: &[0b0010_0000], at: 0 }.read_signed(), Some(2));
    assert_eq!(Bits { bytes: &[0b0010_1000], at: 0 }.read_signed(), Some(-2));
}

#[test]
fn a_set_that_is_cut_or_damaged_ends_in_none_or_some_but_never_in_a_panic() {
    let whole = written(Set { profile: 122, chroma_format: 2, ..HIGH });
    for end in 0..whole.len() - 1 {
        assert_eq!(SequenceParameters::read(&whole[..end]), None, "{end} bytes");
    }
    // a linear congruential generator with a fixed seed; profiles with and without a sample format
    let mut state = 7_u64;
    for round in 0..20_000 {
        let mut bytes: Vec<u8> = (0..40)
            .map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                (state >> 56) as u8
            })
            .collect();
        bytes[1] = [100, 66, 244][round % 3];
        let _ = SequenceParameters::read(&bytes).map(|set| set.unsupported_feature());
    }
}
