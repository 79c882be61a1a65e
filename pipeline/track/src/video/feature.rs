//! Features of films that the built-in reader lacks, and how to convert such a film.

use std::fmt;

/// What a film uses that is left to `ffmpeg`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Feature {
    /// Samples of more than 8 bits.
    BitDepth(u32),
    /// Colour at more than a quarter of the pixels: "4:2:2" or "4:4:4".
    Chroma(&'static str),
    /// Frames that may consist of two fields.
    Interlaced,
    /// A profile beyond High, by its number (profile_idc).
    Profile(u8),
    /// Pictures of more pixels than level 5.2 allows: width and height in px.
    Size(u64, u64),
    /// An index in fragments (mvex, moof).
    Fragments,
    /// A compressed index (cmov) of old QuickTime films.
    CompressedIndex,
}

/// Macroblocks of the largest picture of H.264, level 5.2, and of its longest side, √(8 × 36,864) [H.264, table A-1].
pub(super) const MAX_MACROBLOCKS: u64 = 36_864;
pub(super) const MAX_MACROBLOCKS_A_SIDE: u64 = 543;

impl fmt::Display for Feature {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BitDepth(bits) => write!(f, "H.264 with {bits} bits a sample"),
            Self::Chroma(format) => write!(f, "H.264 with colour as {format}"),
            Self::Interlaced => f.write_str("H.264 with interlaced frames"),
            Self::Profile(144 | 244) => f.write_str("H.264 of the profile High 4:4:4, as lossless films are"),
            Self::Profile(number) => write!(f, "H.264 of a profile with the number {number}"),
            Self::Size(width, height) => write!(f, "H.264 of {width} × {height} px"),
            Self::Fragments => f.write_str("an MP4 in fragments"),
            Self::CompressedIndex => f.write_str("a QuickTime film with a compressed index"),
        }
    }
}

impl Feature {
    /// What is read without `ffmpeg`.
    pub(super) fn supported_range(&self) -> &'static str {
        match self {
            Self::BitDepth(_) => "only 8 bits a sample are read",
            Self::Chroma(_) => "only colour as 4:2:0 and none (4:0:0) are read",
            Self::Interlaced => "only progressive frames are read",
            Self::Profile(_) => "only the profiles Baseline, Main and High are read",
            Self::Size(..) => "only pictures of up to 36864 macroblocks (9.4 Mpx) and 8688 px a side are read",
            Self::Fragments => "only films with one index of all frames are read",
            Self::CompressedIndex => "only a plain index is read",
        }
    }

    /// Options of `ffmpeg` that convert such a film.
    pub(super) fn conversion_options(&self) -> &'static str {
        match self {
            Self::BitDepth(_) | Self::Chroma(_) | Self::Profile(_) => "-c:v libx264 -crf 16 -pix_fmt yuv420p -an",
            Self::Interlaced => "-vf yadif -c:v libx264 -crf 16 -pix_fmt yuv420p -an",
            Self::Size(..) => "-vf scale=3840:-2 -c:v libx264 -crf 16 -pix_fmt yuv420p -an",
            Self::Fragments | Self::CompressedIndex => "-c copy",
        }
    }

    /// Options of `ffmpeg` with which its pictures are read: the two fields of a frame were exposed one after the other, and would
    /// show a moving marker twice. Frames that are marked as progressive pass unchanged.
    pub(super) fn filter_options(&self) -> &'static [&'static str] {
        match self {
            Self::Interlaced => &["-vf", "yadif=deint=interlaced"],
            _ => &[],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_feature_has_a_name_a_limit_and_a_conversion_of_its_own_kind() {
        let lossless = Feature::Profile(244).to_string();
        assert!(lossless.contains("lossless") && !Feature::Profile(118).to_string().contains("lossless"));
        assert_eq!(Feature::BitDepth(10).to_string(), "H.264 with 10 bits a sample");
        assert!(
            Feature::Interlaced.conversion_options().contains("yadif")
                && !Feature::Interlaced.filter_options().is_empty()
        );
        assert!(
            Feature::Chroma("4:2:2").supported_range().contains("4:2:0")
                && Feature::BitDepth(10).filter_options().is_empty()
        );
    }
}
