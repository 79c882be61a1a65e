//! The predefined dictionaries of ArUco markers by OpenCV's names: `DICT_4X4_50` to `DICT_7X7_1000`, that of the first ArUco, those of AprilTag
//! and ArUco's MIP.
//!
//! The files beside this one hold the bit patterns that `cv::aruco::getPredefinedDictionary` gives (OpenCV 5.0.0), rows from the top,
//! 1 white, the first bit highest. The dictionary of 50, 100 or 250 markers of a size is the beginning of that of 1000.

/// A dictionary: markers of `side` × `side` bits, the first `count` of their family.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dictionary {
    /// Bits along a side, without the black border.
    pub side: usize,
    /// Markers.
    pub count: usize,
    family: Family,
}

/// Where the markers of a dictionary come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Family {
    /// OpenCV's own, by their size.
    OpenCv,
    /// Others, by their place in [`OTHERS`].
    Other(usize),
}

/// Numbers of markers, and how many wrong bits OpenCV corrects in the dictionary of each (`maxCorrectionBits`).
const SIZES: [(usize, [u32; 4], &str); 4] = [
    (4, [1, 1, 1, 0], include_str!("dictionaries/4x4.txt")),
    (5, [3, 3, 2, 2], include_str!("dictionaries/5x5.txt")),
    (6, [6, 5, 5, 4], include_str!("dictionaries/6x6.txt")),
    (7, [9, 8, 8, 6], include_str!("dictionaries/7x7.txt")),
];
const COUNTS: [usize; 4] = [50, 100, 250, 1000];

/// A dictionary of its own name.
struct Other {
    name: &'static str,
    side: usize,
    count: usize,
    correctable: u32,
    /// None of the first ArUco's, whose bits follow from the number.
    codes: Option<&'static str>,
}

const OTHERS: [Other; 6] = [
    Other { name: "DICT_ARUCO_ORIGINAL", side: 5, count: 1024, correctable: 1, codes: None },
    from_table("DICT_APRILTAG_16H5", 4, [30, 2], include_str!("dictionaries/apriltag_16h5.txt")),
    from_table("DICT_APRILTAG_25H9", 5, [35, 4], include_str!("dictionaries/apriltag_25h9.txt")),
    from_table("DICT_APRILTAG_36H10", 6, [2320, 4], include_str!("dictionaries/apriltag_36h10.txt")),
    from_table("DICT_APRILTAG_36H11", 6, [587, 5], include_str!("dictionaries/apriltag_36h11.txt")),
    from_table("DICT_ARUCO_MIP_36H12", 6, [250, 5], include_str!("dictionaries/mip_36h12.txt")),
];

const fn from_table(name: &'static str, side: usize, [count, correctable]: [u32; 2], codes: &'static str) -> Other {
    Other { name, side, count: count as usize, correctable, codes: Some(codes) }
}

/// A name that is none of a dictionary.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{name}` is not a dictionary that is known here\n  why: the predefined ones of 4×4 to 7×7 bits, of the first ArUco, AprilTag and MIP are, as OpenCV names them\n  do:  give DICT_4X4_50, DICT_5X5_100, DICT_ARUCO_ORIGINAL, DICT_APRILTAG_36h11, DICT_ARUCO_MIP_36h12 or the like; 50, 100, 250 or 1000 markers"
)]
pub struct UnknownDictionary {
    /// The name.
    pub name: String,
}

impl std::str::FromStr for Dictionary {
    type Err = UnknownDictionary;

    fn from_str(name: &str) -> Result<Self, UnknownDictionary> {
        let upper = name.trim().to_ascii_uppercase();
        let same = |dictionary: &Self| dictionary.to_string().to_ascii_uppercase() == upper;
        Self::all_dictionaries().find(same).ok_or_else(|| UnknownDictionary { name: name.to_owned() })
    }
}

impl std::fmt::Display for Dictionary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.family {
            Family::OpenCv => write!(f, "DICT_{0}X{0}_{1}", self.side, self.count),
            // OpenCV writes the distance of a family with a small h
            Family::Other(place) => f.write_str(&OTHERS[place].name.replace("6H", "6h").replace("5H", "5h")),
        }
    }
}

/// A marker that was read: its number, and how many quarter turns the reading is ahead of the marker.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Identified {
    pub(super) number: usize,
    pub(super) quarter_turns: usize,
}

impl Dictionary {
    /// The first `count` markers of OpenCV's own of `side` × `side` bits.
    pub const fn opencv(side: usize, count: usize) -> Self {
        Self { side, count, family: Family::OpenCv }
    }

    /// Every dictionary, OpenCV's own first, small ones before large ones.
    pub(super) fn all_dictionaries() -> impl Iterator<Item = Self> {
        let other_families = OTHERS.iter().enumerate();
        let other = |(index, family): (usize, &Other)| Self {
            side: family.side,
            count: family.count,
            family: Family::Other(index),
        };
        SIZES
            .iter()
            .flat_map(|&(side, ..)| COUNTS.map(|count| Self::opencv(side, count)))
            .chain(other_families.map(other))
    }

    /// Whether markers that it reads are its own: a larger one of its family does not read them as well, and it reads one square in a hundred that is
    /// none of its markers. AprilTag's of 16 and 25 bits correct so many that they read a quarter of all squares, and a twentieth.
    pub(super) fn is_distinctive(&self) -> bool {
        match self.family {
            Family::OpenCv => [50, 1000].contains(&self.count),
            Family::Other(place) => OTHERS[place].codes.is_none() || self.side == 6,
        }
    }

    /// The largest of each family, which reads the markers of the others.
    pub(super) fn largest_of_families() -> impl Iterator<Item = Self> {
        Self::all_dictionaries().filter(|dictionary| dictionary.family != Family::OpenCv || dictionary.count == 1000)
    }

    /// The smallest of its family with so many markers; others begin with the same.
    pub(super) fn smallest_with(self, markers: usize) -> Self {
        let fits = |count: &usize| self.family == Family::OpenCv && *count >= markers;
        COUNTS.into_iter().find(fits).map_or(self, |count| Self { count, ..self })
    }

    /// Whether smaller and larger dictionaries have markers in common with it.
    pub fn has_siblings(self) -> bool {
        self.family == Family::OpenCv
    }

    /// The bits of the first `limit` markers, row after row from the highest bit.
    pub(super) fn marker_codes(self, limit: usize) -> Vec<u64> {
        let text = match self.family {
            Family::OpenCv => SIZES.iter().find(|(side, ..)| *side == self.side).map(|(.., text)| *text),
            Family::Other(place) => OTHERS[place].codes,
        };
        let count = limit.min(self.count);
        let Some(text) = text else { return (0..count).map(first_aruco).collect() };
        text.split_ascii_whitespace().take(count).filter_map(|w| u64::from_str_radix(w, 16).ok()).collect()
    }

    fn correctable_bits(self) -> u32 {
        if let Family::Other(index) = self.family {
            return OTHERS[index].correctable;
        }
        let index = COUNTS.iter().position(|count| *count == self.count);
        let limits = SIZES.iter().find(|(side, ..)| *side == self.side).map(|(_, limits, _)| limits);
        index.zip(limits).map_or(0, |(index, limits)| limits[index])
    }

    /// The marker of `codes` that was read as `bits`, in any of the four orientations; none where two are as near or all too far.
    pub(super) fn identify_marker(self, bits: u64, codes: &[u64]) -> Option<Identified> {
        let turns = std::iter::successors(Some(bits), |bits| Some(quarter_turned(*bits, self.side)));
        let distances = turns.take(4).enumerate().flat_map(|(quarter_turns, bits)| {
            let distance =
                move |(number, code): (usize, &u64)| ((bits ^ code).count_ones(), Identified { number, quarter_turns });
            codes.iter().enumerate().map(distance)
        });
        let mut nearest: Option<(u32, Identified)> = None;
        let mut tied = false;
        for (distance, identified) in distances.filter(|(distance, _)| *distance <= self.correctable_bits()) {
            match nearest {
                Some((least, _)) if distance > least => {}
                Some((least, _)) if distance == least => tied = true,
                _ => (nearest, tied) = (Some((distance, identified)), false),
            }
        }
        nearest.filter(|_| !tied).map(|(_, identified)| identified)
    }
}

/// A marker of the first ArUco: its number in ten bits, two a row, each as a word of five bits that differs from the others in three.
fn first_aruco(number: usize) -> u64 {
    const WORDS: [u64; 4] = [0x10, 0x17, 0x09, 0x0e];
    (0..5).rev().fold(0, |bits, row| bits << 5 | WORDS[number >> (2 * row) & 3])
}

/// The reading that begins at the next corner of the marker, clockwise: row r, column c is what stood in row c, column n − 1 − r.
pub(super) fn quarter_turned(bits: u64, side: usize) -> u64 {
    let bit = |row: usize, column: usize| bits >> (side * side - 1 - row * side - column) & 1;
    (0..side * side).fold(0, |turned, k| turned << 1 | bit(k % side, side - 1 - k / side))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_dictionary_has_its_markers_and_its_name_back() {
        for dictionary in Dictionary::all_dictionaries() {
            let codes = dictionary.marker_codes(usize::MAX);
            assert_eq!(codes.len(), dictionary.count);
            assert!(codes.iter().all(|code| code >> (dictionary.side * dictionary.side) == 0));
            assert_eq!(dictionary.to_string().to_lowercase().parse(), Ok(dictionary));
        }
        assert!("DICT_8X8_50".parse::<Dictionary>().unwrap_err().to_string().contains("DICT_4X4_50"));
    }

    /// The first two markers as `cv::aruco::Dictionary::getBitsFromByteList` has them (OpenCV 5.0.0).
    #[test]
    fn the_first_markers_of_other_families_are_those_of_opencv() {
        for (name, codes) in [
            ("DICT_ARUCO_ORIGINAL", [0x108_4210, 0x108_4217]),
            ("DICT_APRILTAG_16h5", [0xd8c4, 0xa574]),
            ("DICT_APRILTAG_25h9", [0x11f_a755, 0xdb_164f]),
            ("DICT_APRILTAG_36h10", [0xe_1654_9538, 0x3_2358_4a04]),
            ("DICT_APRILTAG_36h11", [0x2_1a14_6bab, 0x9_2d18_fe9b]),
            ("DICT_ARUCO_MIP_36h12", [0xd_2b63_a09d, 0x6_0011_34e5]),
        ] {
            let dictionary: Dictionary = name.parse().unwrap();
            assert_eq!((dictionary.to_string().as_str(), &dictionary.marker_codes(2)[..]), (name, &codes[..]));
        }
    }

    #[test]
    fn the_first_marker_of_four_bits_is_that_of_opencv() {
        // its bytesList begins with 181, 50
        assert_eq!("DICT_4X4_50".parse::<Dictionary>().unwrap().marker_codes(1), [181 << 8 | 50]);
    }

    #[test]
    fn a_marker_is_identified_in_each_orientation_and_with_wrong_bits() {
        let dictionary = Dictionary::opencv(5, 100);
        let codes = dictionary.marker_codes(100);
        let mut bits = codes[37];
        for quarter_turns in [0, 3, 2, 1] {
            let identified = Some(Identified { number: 37, quarter_turns });
            assert_eq!(dictionary.identify_marker(bits, &codes), identified);
            assert_eq!(dictionary.identify_marker(bits ^ 0b1_0000_0100_0001, &codes), identified);
            assert_eq!(dictionary.identify_marker(bits ^ 0b1_0000_0101_0001, &codes), None);
            bits = quarter_turned(bits, 5);
        }
    }

    #[test]
    fn what_is_as_near_to_two_markers_is_neither() {
        let dictionary = Dictionary::opencv(4, 50);
        assert_eq!(dictionary.identify_marker(0x8001, &[0x8003, 0x8041]), None);
    }
}
