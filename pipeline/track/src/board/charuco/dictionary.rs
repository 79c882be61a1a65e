//! The predefined dictionaries of ArUco markers by OpenCV's names: `DICT_4X4_50` to `DICT_7X7_1000`.
//!
//! The files beside this one hold the bit patterns that `cv::aruco::getPredefinedDictionary` gives (OpenCV 5.0.0), rows from the top,
//! 1 white, the first bit highest. The dictionary of 50, 100 or 250 markers of a size is the beginning of that of 1000.

/// A dictionary: markers of `side` × `side` bits, the first `count` of their size.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dictionary {
    /// Bits along a side, without the black border.
    pub side: usize,
    /// Markers.
    pub count: usize,
}

/// Numbers of markers, and how many wrong bits OpenCV corrects in the dictionary of each (`maxCorrectionBits`).
const SIZES: [(usize, [u32; 4], &str); 4] = [
    (4, [1, 1, 1, 0], include_str!("dictionaries/4x4.txt")),
    (5, [3, 3, 2, 2], include_str!("dictionaries/5x5.txt")),
    (6, [6, 5, 5, 4], include_str!("dictionaries/6x6.txt")),
    (7, [9, 8, 8, 6], include_str!("dictionaries/7x7.txt")),
];
const COUNTS: [usize; 4] = [50, 100, 250, 1000];

/// A name that is none of a dictionary.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{name}` is not a dictionary that is known here\n  why: the predefined ones of 4×4 to 7×7 bits are, as OpenCV names them\n  do:  give DICT_4X4_50, DICT_5X5_100, DICT_6X6_250 or the like; 50, 100, 250 or 1000 markers"
)]
pub struct UnknownDictionary {
    /// The name.
    pub name: String,
}

impl std::str::FromStr for Dictionary {
    type Err = UnknownDictionary;

    fn from_str(name: &str) -> Result<Self, UnknownDictionary> {
        let upper = name.trim().to_ascii_uppercase();
        let same = |dictionary: &Self| dictionary.to_string() == upper;
        Self::all().find(same).ok_or_else(|| UnknownDictionary { name: name.to_owned() })
    }
}

impl std::fmt::Display for Dictionary {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "DICT_{0}X{0}_{1}", self.side, self.count)
    }
}

/// A marker that was read: its number, and how many quarter turns the reading is ahead of the marker.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Identified {
    pub(super) number: usize,
    pub(super) quarter_turns: usize,
}

impl Dictionary {
    /// Every dictionary, small ones first.
    pub(super) fn all() -> impl Iterator<Item = Self> {
        SIZES.iter().flat_map(|&(side, ..)| COUNTS.map(|count| Self { side, count }))
    }

    /// The bits of the first `limit` markers, row after row from the highest bit.
    pub(super) fn codes(self, limit: usize) -> Vec<u64> {
        let text = SIZES.iter().find(|(side, ..)| *side == self.side).map_or("", |(.., text)| text);
        text.split_ascii_whitespace()
            .take(limit.min(self.count))
            .filter_map(|w| u64::from_str_radix(w, 16).ok())
            .collect()
    }

    fn correctable(self) -> u32 {
        let place = COUNTS.iter().position(|count| *count == self.count);
        let limits = SIZES.iter().find(|(side, ..)| *side == self.side).map(|(_, limits, _)| limits);
        place.zip(limits).map_or(0, |(place, limits)| limits[place])
    }

    /// The marker of `codes` that was read as `bits`, in any of the four orientations; none where two are as near or all too far.
    pub(super) fn identify(self, bits: u64, codes: &[u64]) -> Option<Identified> {
        let turns = std::iter::successors(Some(bits), |bits| Some(quarter_turned(*bits, self.side)));
        let distances = turns.take(4).enumerate().flat_map(|(quarter_turns, bits)| {
            let distance =
                move |(number, code): (usize, &u64)| ((bits ^ code).count_ones(), Identified { number, quarter_turns });
            codes.iter().enumerate().map(distance)
        });
        let mut nearest: Option<(u32, Identified)> = None;
        let mut tied = false;
        for (distance, identified) in distances.filter(|(distance, _)| *distance <= self.correctable()) {
            match nearest {
                Some((least, _)) if distance > least => {}
                Some((least, _)) if distance == least => tied = true,
                _ => (nearest, tied) = (Some((distance, identified)), false),
            }
        }
        nearest.filter(|_| !tied).map(|(_, identified)| identified)
    }
}

/// The reading that begins at the next corner of the marker, clockwise: row r, column c is what stood in row c, column n − 1 − r.
fn quarter_turned(bits: u64, side: usize) -> u64 {
    let bit = |row: usize, column: usize| bits >> (side * side - 1 - row * side - column) & 1;
    (0..side * side).fold(0, |turned, k| turned << 1 | bit(k % side, side - 1 - k / side))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_dictionary_has_its_markers_and_its_name_back() {
        for dictionary in Dictionary::all() {
            let codes = dictionary.codes(usize::MAX);
            assert_eq!(codes.len(), dictionary.count);
            assert!(codes.iter().all(|code| code >> (dictionary.side * dictionary.side) == 0));
            assert_eq!(dictionary.to_string().to_lowercase().parse(), Ok(dictionary));
        }
        assert!("DICT_ARUCO_ORIGINAL".parse::<Dictionary>().unwrap_err().to_string().contains("DICT_4X4_50"));
    }

    #[test]
    fn the_first_marker_of_four_bits_is_that_of_opencv() {
        // its bytesList begins with 181, 50
        assert_eq!("DICT_4X4_50".parse::<Dictionary>().unwrap().codes(1), [181 << 8 | 50]);
    }

    #[test]
    fn a_marker_is_identified_in_each_orientation_and_with_wrong_bits() {
        let dictionary = Dictionary { side: 5, count: 100 };
        let codes = dictionary.codes(100);
        let mut bits = codes[37];
        for quarter_turns in [0, 3, 2, 1] {
            let identified = Some(Identified { number: 37, quarter_turns });
            assert_eq!(dictionary.identify(bits, &codes), identified);
            assert_eq!(dictionary.identify(bits ^ 0b1_0000_0100_0001, &codes), identified);
            assert_eq!(dictionary.identify(bits ^ 0b1_0000_0101_0001, &codes), None);
            bits = quarter_turned(bits, 5);
        }
    }

    #[test]
    fn what_is_as_near_to_two_markers_is_neither() {
        let dictionary = Dictionary { side: 4, count: 50 };
        assert_eq!(dictionary.identify(0x8001, &[0x8003, 0x8041]), None);
    }
}
