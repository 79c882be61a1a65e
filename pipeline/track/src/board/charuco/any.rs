//! A ChArUco board of which nothing is known: the dictionary of its markers, and from their numbers and places in several pictures its columns
//! and rows.
//!
//! In the white squares the numbers count up row after row, so that the number of columns decides where each stands: only the right one lets a
//! homography take all of a picture's markers to their squares.

use std::collections::{BTreeMap, HashMap};
use std::sync::LazyLock;

use nalgebra::Matrix3;
use si::Point2;

use super::dictionary::{Dictionary, quarter_turned};
use super::marker::read_bits;
use super::quads::{Quad, distance, find_quads};
use super::{WINDOWS, window_half_side};
use crate::Gray;
use crate::board::margin::{has_light_margin, level_at};
use crate::board::reduced::Reduced;
use crate::calibrate::homography::{homography, map_point};

/// Markers in a picture, all of one family of dictionaries.
#[derive(Debug, Clone, PartialEq)]
pub struct MarkerSet {
    /// The largest dictionary of the family.
    pub dictionary: Dictionary,
    /// Corners of each number, px, clockwise from the upper left one as it is printed.
    pub markers: BTreeMap<usize, [Point2; 4]>,
    /// The picture, perhaps reduced.
    picture: Reduced,
}

/// The board of markers in several pictures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AnyCharuco {
    /// The smallest dictionary that has its markers.
    pub dictionary: Dictionary,
    /// The first of its markers that was seen; 0 of a board as OpenCV prints it.
    pub first: usize,
    /// Squares along the rows in which the markers count up.
    pub columns: usize,
    /// Squares across them, down to the last marker that was seen.
    pub rows: usize,
    /// Side of a marker as a share of that of a square.
    pub marker_share: f64,
    /// Whether its upper left square is white, as OpenCV printed boards of even rows before 4.6.
    pub is_legacy: bool,
    /// Pictures in which it ends all around at light ground.
    pub whole: usize,
}

/// Pixels of the picture that is kept with its markers, at most.
const KEPT: usize = 400_000;
/// Where the margin of a board is looked at, in squares beyond it.
const BEYOND: f64 = 0.25;
/// Markers of a picture, at least: a homography has eight numbers, six places twelve.
const LEAST_MARKERS: usize = 6;
/// Columns that are tried.
const COLUMNS: std::ops::RangeInclusive<usize> = 3..=50;
/// A marker within this share of its side from where it is predicted stands there.
const ASTRAY: f64 = 0.35;
/// Markers that are left out of a picture, at most: those that were misread.
const MISREAD: usize = 2;
/// The second best number of columns explains less of the markers than this share of the best.
const CLEAR: f64 = 0.8;

/// Numbers of the markers of a family by their bits, in each orientation, with the quarter turns.
type Codes = HashMap<u64, (usize, usize)>;

static FAMILIES: LazyLock<Vec<(Dictionary, Codes)>> = LazyLock::new(|| {
    let codes = |dictionary: Dictionary| {
        let mut codes = Codes::new();
        for (number, code) in dictionary.marker_codes(usize::MAX).into_iter().enumerate() {
            // a reading that is k turns ahead becomes the code by 4 − k further ones
            let mut bits = code;
            for turns in 0..4 {
                codes.entry(bits).or_insert((number, turns));
                bits = quarter_turned(bits, dictionary.side);
            }
        }
        (dictionary, codes)
    };
    Dictionary::largest_of_families().map(codes).collect()
});

/// The markers of a picture of which nothing is known, by the family that reads most of its dark quadrilaterals without a wrong bit; none of
/// less than six.
pub(crate) fn any_markers(picture: &Gray) -> Option<MarkerSet> {
    let reduced = Reduced::of_large_picture(picture);
    let searched = reduced.as_ref().map_or(picture, |reduced| &reduced.picture);
    let quads: Vec<Quad> =
        WINDOWS.iter().flat_map(|share| find_quads(searched, window_half_side(searched, *share))).collect();
    let sides = [4, 5, 6, 7].map(|side| quads.iter().map(|quad| read_bits(searched, quad, side)).collect::<Vec<_>>());
    let small = Reduced::with_at_most(picture, KEPT);
    let read = |(dictionary, codes): &(Dictionary, Codes)| {
        // length: each quadrilateral was read at each side
        let readings = quads.iter().zip(&sides[dictionary.side - 4]);
        let marker = |(quad, bits): (&Quad, &Option<u64>)| {
            let (number, turns) = *codes.get(&(*bits)?)?;
            let first = (4 - turns) % 4;
            let enlarge = |place: Point2| reduced.as_ref().map_or(place, |reduced| reduced.to_picture(place));
            Some((number, std::array::from_fn(|k| enlarge(quad[(k + first) % 4]))))
        };
        MarkerSet { dictionary: *dictionary, markers: readings.filter_map(marker).collect(), picture: small.clone() }
    };
    // the first of equals
    let best = FAMILIES.iter().map(read).reduce(|a, b| if b.markers.len() > a.markers.len() { b } else { a });
    best.filter(|set| set.markers.len() >= LEAST_MARKERS)
}

/// Columns, and whether the print is the legacy one.
type Candidate = (usize, bool);

/// A picture's markers on a board of so many columns.
struct Fit {
    map: Matrix3<f64>,
    numbers: Vec<usize>,
    /// Sides of markers over those of squares.
    shares: Vec<f64>,
}

/// The board whose markers several pictures show, all of one family; none where they do not tell its columns.
pub fn any_charuco(sets: &[&MarkerSet]) -> Option<AnyCharuco> {
    let family = sets.first()?.dictionary;
    let candidates = COLUMNS.flat_map(|columns| [(columns, false), (columns, true)]);
    let mut fits: Vec<(Candidate, Vec<Option<Fit>>)> =
        candidates.map(|candidate| (candidate, sets.iter().map(|set| fit_columns(set, candidate)).collect())).collect();
    let explained = |fits: &[Option<Fit>]| fits.iter().flatten().map(|fit| fit.numbers.len()).sum::<usize>();
    // stable: the print of today before the legacy one
    fits.sort_by_key(|(_, fits)| std::cmp::Reverse(explained(fits)));
    let second = explained(&fits.get(1)?.1);
    let ((columns, is_legacy), best) = fits.swap_remove(0);
    let marker_count: usize = sets.iter().map(|set| set.markers.len()).sum();
    if explained(&best) as f64 <= CLEAR * marker_count as f64 || second as f64 > CLEAR * explained(&best) as f64 {
        return None;
    }
    let numbers = || best.iter().flatten().flat_map(|fit| &fit.numbers);
    let (first, last) = (*numbers().min()?, numbers().max()?);
    let rows = white_square(*last, columns, is_legacy)[1] + 1;
    let mut shares: Vec<f64> = best.iter().flatten().flat_map(|fit| fit.shares.clone()).collect();
    shares.sort_by(f64::total_cmp);
    // length: a fit or none for each picture
    let is_whole = |(fit, set): &(&Option<Fit>, &&MarkerSet)| {
        fit.as_ref().is_some_and(|fit| shows_margin(fit, &set.picture, [columns, rows]))
    };
    let whole_boards = best.iter().zip(sets).filter(is_whole).count();
    let dictionary = family.smallest_with(columns * rows / 2);
    Some(AnyCharuco {
        dictionary,
        first,
        columns,
        rows,
        marker_share: shares[shares.len() / 2],
        is_legacy,
        whole: whole_boards,
    })
}

/// Column and row of the white square of a marker.
fn white_square(number: usize, columns: usize, is_legacy: bool) -> [usize; 2] {
    // white squares of two rows together are as many as columns
    let (pair, rest) = (number / columns, number % columns);
    let begins = usize::from(!is_legacy);
    let in_first = (columns - begins).div_ceil(2);
    if rest < in_first { [begins + 2 * rest, 2 * pair] } else { [1 - begins + 2 * (rest - in_first), 2 * pair + 1] }
}

/// The markers that stand where a board of so many columns has them, without a few that were misread.
fn fit_columns(set: &MarkerSet, (columns, is_legacy): Candidate) -> Option<Fit> {
    let middle = |number: &usize| white_square(*number, columns, is_legacy).map(|place| place as f64 + 0.5);
    let mut members: Vec<(usize, Quad)> = set.markers.iter().map(|(number, quad)| (*number, *quad)).collect();
    for _ in 0..=MISREAD {
        if members.len() < LEAST_MARKERS {
            return None;
        }
        let from: Vec<Point2> = members.iter().map(|(number, _)| middle(number)).collect();
        let onto: Vec<Point2> = members.iter().map(|(_, quad)| quad_middle(quad)).collect();
        let map = homography(&from, &onto)?;
        let misses: Vec<f64> = members.iter().map(|(number, quad)| miss(&map, middle(number), quad)).collect();
        if misses.iter().all(|miss| *miss < ASTRAY) {
            let share =
                |(number, quad): &(usize, Quad)| distance(quad[0], quad[1]) / column_step(&map, middle(number)).1;
            let shares = members.iter().map(share).collect();
            return Some(Fit { map, numbers: members.into_iter().map(|(number, _)| number).collect(), shares });
        }
        let worst = (0..misses.len()).max_by(|a, b| misses[*a].total_cmp(&misses[*b]))?;
        members.remove(worst);
    }
    None
}

/// Where the diagonals of a quadrilateral cross: the middle of a square in perspective.
fn quad_middle([a, b, c, d]: &Quad) -> Point2 {
    let (along, across) = ([c[0] - a[0], c[1] - a[1]], [d[0] - b[0], d[1] - b[1]]);
    let between = [b[0] - a[0], b[1] - a[1]];
    let share = (between[0] * across[1] - between[1] * across[0]) / (along[0] * across[1] - along[1] * across[0]);
    [a[0] + share * along[0], a[1] + share * along[1]]
}

/// The way along a row at a place of the board, px a square, and its length.
fn column_step(map: &Matrix3<f64>, place: Point2) -> (Point2, f64) {
    let [low, high] = [-0.5, 0.5].map(|offset| map_point(map, [place[0] + offset, place[1]]));
    ([high[0] - low[0], high[1] - low[1]], distance(low, high))
}

/// How far a marker is from where it is predicted, as a share of its side; infinite where it is turned against the rows.
fn miss(map: &Matrix3<f64>, place: Point2, quad: &Quad) -> f64 {
    let side = distance(quad[0], quad[1]);
    let ([u, v], step) = column_step(map, place);
    let cosine = (u * (quad[1][0] - quad[0][0]) + v * (quad[1][1] - quad[0][1])) / (step * side);
    let is_upright = cosine > 0.9 && side < step;
    if is_upright { distance(map_point(map, place), quad_middle(quad)) / side } else { f64::INFINITY }
}

/// Whether a board of this size ends at light ground.
fn shows_margin(fit: &Fit, reduced: &Reduced, [columns, rows]: [usize; 2]) -> bool {
    let (columns, rows) = (columns as f64, rows as f64);
    // the squares' middles and corners of the first row: some are black, some white
    let cells = (0..4 * columns as usize).map(|k| [0.25 * k as f64, 0.06]);
    let block = reduced.block as f64;
    let shift = 0.5 * (block - 1.0);
    let to_copy = Matrix3::new(1.0 / block, 0.0, -shift / block, 0.0, 1.0 / block, -shift / block, 0.0, 0.0, 1.0);
    let map = to_copy * fit.map;
    let levels: Vec<f64> = cells.filter_map(|cell| level_at(&reduced.picture, &map, cell)).collect();
    let (across, down) = ([-BEYOND, columns + BEYOND], [-BEYOND, rows + BEYOND]);
    has_light_margin(&reduced.picture, &map, (across, down), &levels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markers_stand_in_white_squares_row_after_row() {
        let squares = |columns, is_legacy| [0, 2, 3, 6].map(|number| white_square(number, columns, is_legacy));
        assert_eq!(squares(7, false), [[1, 0], [5, 0], [0, 1], [6, 1]]);
        assert_eq!(squares(6, false), [[1, 0], [5, 0], [0, 1], [1, 2]]);
        assert_eq!(squares(6, true), [[0, 0], [4, 0], [1, 1], [0, 2]]);
    }

    #[test]
    fn the_middle_of_a_square_in_perspective_is_where_its_diagonals_cross() {
        let middle = quad_middle(&[[0.0, 0.0], [4.0, 0.0], [3.0, 2.0], [1.0, 2.0]]);
        assert!((middle[0] - 2.0).abs() < 1e-12 && (middle[1] - 4.0 / 3.0).abs() < 1e-12, "{middle:?}");
    }
}
