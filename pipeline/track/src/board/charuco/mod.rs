//! Detection of a ChArUco board: a checkerboard with a numbered marker in each white square, so that a part of it is enough.
//!
//! Printed upright, square (0, 0) is the upper left one and the markers count up row after row. The board's frame is that of a
//! checkerboard: corner (0, 0) is the inner corner at the lower left, columns run to the right, rows upwards, z towards the camera.
//! The upper left square is black; on a board of OpenCV before 4.6 with an even number of rows it is white: which one is seen is decided by
//! the numbers of neighbours.

pub mod any;
mod dictionary;
mod layout;
mod marker;
mod quads;

use super::reduced::Reduced;
use super::{BoardError, check_levels, saddle};
use crate::Gray;
use crate::calibrate::View;
use crate::calibrate::homography::map_point;
pub use dictionary::{Dictionary, UnknownDictionary};
use layout::{Located, locate_markers};
use marker::Marker;
use quads::distance;
use si::{Metre, Point2};

/// A ChArUco board of `columns` × `rows` squares.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Charuco {
    /// Squares along the first axis, to the right as it is printed.
    pub columns: usize,
    /// Squares along the second axis.
    pub rows: usize,
    /// Side of a square, m.
    pub square: Metre,
    /// Side of a marker, m.
    pub marker: Metre,
    /// Its markers' dictionary.
    pub dictionary: Dictionary,
}

/// Corners that a view has at least, in two rows and two columns: with fewer its pose is hardly determined.
const LEAST_CORNERS: usize = 6;
/// Half sides of the squares around a pixel with whose mean it is compared, as shares of the picture's shorter side.
const WINDOWS: [f64; 2] = [0.06, 0.02];
/// A corner is refined within this share of the way to the nearest corner of a marker.
const REFINED_SHARE: f64 = 0.7;
/// Bounds of that distance, px.
const REFINED: (f64, f64) = (2.5, 8.0);
/// Least difference of the black and white squares at a corner, grey levels.
const LEAST_CONTRAST: f64 = 10.0;

impl Charuco {
    /// Markers of the board, in its white squares.
    pub(crate) fn marker_count(&self) -> usize {
        self.columns * self.rows / 2
    }

    /// White between a marker and its square, as a share of the square's side.
    fn gap_share(&self) -> f64 {
        0.5 * (1.0 - self.marker / self.square)
    }
}

/// Finds the corners of `board` that are in the picture, px, with their numbers in the order of the checkerboard's corners.
///
/// Dark quadrilaterals are read as markers; the homographies of those beside a corner predict it; the saddle there is its place.
///
/// # Errors
/// [`BoardError`] when too few corners are seen, no marker is, or their numbers are those of another board.
pub fn find(picture: &Gray, board: &Charuco) -> Result<View, BoardError> {
    check_levels(picture)?;
    let (needed, has) = (board.marker_count(), board.dictionary.count);
    let fits = (0.1..0.95).contains(&(board.marker / board.square));
    if needed > has || board.columns < 3 || board.rows < 3 || !fits {
        return Err(BoardError::NoCharuco { board: *board });
    }
    let from_reduced = Reduced::of_large_picture(picture).and_then(|reduced| {
        let (markers, _) = find_markers(&reduced.picture, board);
        corner_view(picture, board, &enlarge_markers(&reduced, &markers)).ok()
    });
    if let Some(view) = from_reduced {
        return Ok(view);
    }
    let (markers, quads) = find_markers(picture, board);
    match markers.is_empty() {
        true => Err(no_marker(picture, board, quads)),
        false => corner_view(picture, board, &markers),
    }
}

fn enlarge_markers(reduced: &Reduced, markers: &[Marker]) -> Vec<Marker> {
    let enlarge = |marker: &Marker| Marker { corners: marker.corners.map(|p| reduced.to_picture(p)), ..*marker };
    markers.iter().map(enlarge).collect()
}

/// The markers of a picture, and the number of its dark quadrilaterals.
fn find_markers(picture: &Gray, board: &Charuco) -> (Vec<Marker>, usize) {
    let codes = board.dictionary.marker_codes(board.marker_count());
    let (mut markers, mut count): (Vec<Marker>, usize) = (Vec::new(), 0);
    for quad in WINDOWS.iter().flat_map(|share| quads::find_quads(picture, window_half_side(picture, *share))) {
        count += 1;
        let read = marker::read_marker(picture, &quad, board.dictionary, &codes);
        // a marker is dark by either mean, its corners the same within some pixels
        let is_new = |read: &Marker| {
            !markers.iter().any(|m| m.number == read.number && distance(m.corners[0], read.corners[0]) < 8.0)
        };
        markers.extend(read.filter(is_new));
    }
    (markers, count)
}

fn window_half_side(picture: &Gray, share: f64) -> usize {
    ((share * picture.width.min(picture.height) as f64) as usize).max(3)
}

/// Why no marker was read: there is none, or those that are there belong to another dictionary, which is named.
fn no_marker(picture: &Gray, board: &Charuco, quads: usize) -> BoardError {
    let reads = |dictionary: &Dictionary| {
        let codes = dictionary.marker_codes(usize::MAX);
        let quads = quads::find_quads(picture, window_half_side(picture, WINDOWS[0]));
        quads.iter().filter(|quad| marker::read_marker(picture, quad, *dictionary, &codes).is_some()).count()
    };
    let other = Dictionary::all_dictionaries().filter(Dictionary::is_distinctive).find(|d| reads(d) >= 3);
    BoardError::NoMarker { dictionary: board.dictionary, quads, other }
}

/// The corners beside the markers.
fn corner_view(picture: &Gray, board: &Charuco, markers: &[Marker]) -> Result<View, BoardError> {
    let located = locate_markers(markers, board)?;
    let (across, down) = (board.columns - 1, board.rows - 1);
    // printed rows run downwards, the board's upwards
    let number = |k: usize| (down - 1 - k / across) * across + k % across;
    let numbered_corner =
        |k: usize| Some((number(k), find_corner(picture, board, &located, [k % across + 1, k / across + 1])?));
    let mut corners: Vec<(usize, Point2)> = (0..across * down).filter_map(numbered_corner).collect();
    corners.sort_by_key(|(number, _)| *number);
    let spans = |line: fn(usize, usize) -> usize| {
        let lines = |number: &(usize, Point2)| line(number.0, across);
        corners.iter().map(lines).min() != corners.iter().map(lines).max()
    };
    if corners.len() < LEAST_CORNERS
        || !spans(|number, across| number / across)
        || !spans(|number, across| number % across)
    {
        let (corners, markers) = (corners.len(), located.len());
        return Err(BoardError::FewCorners { corners, markers, least: LEAST_CORNERS, expected: across * down });
    }
    let (numbers, corners) = corners.into_iter().unzip();
    Ok(View { corners, numbers: Some(numbers) })
}

/// The inner corner at `inner_corner` (squares to the right and down of the printed board's upper left corner), px.
fn find_corner(picture: &Gray, board: &Charuco, located: &[Located], inner_corner: [usize; 2]) -> Option<Point2> {
    let point = inner_corner.map(|p| p as f64);
    let is_beside = |marker: &&Located| {
        (0..2).all(|k| marker.square[k] + 1 == inner_corner[k] || marker.square[k] == inner_corner[k])
    };
    let adjacent_markers: Vec<&Located> = located.iter().filter(is_beside).collect();
    let predicted: Vec<Point2> = adjacent_markers.iter().map(|marker| map_point(&marker.map, point)).collect();
    let start = [0, 1].map(|k| predicted.iter().map(|p| p[k]).sum::<f64>() / predicted.len() as f64);
    let nearest =
        adjacent_markers.iter().flat_map(|marker| marker.corners).map(|p| distance(p, start)).min_by(f64::total_cmp)?;
    let radius = (REFINED_SHARE * nearest).min(REFINED.1);
    let refined = (radius >= REFINED.0).then(|| saddle::refine_saddle(picture, start, radius))??;
    let shift = [refined[0] - start[0], refined[1] - start[1]];
    is_crossing(picture, board, adjacent_markers[0], (point, shift)).then_some(refined)
}

/// Whether the squares that touch a corner are black and white as the board's are: of an occluded corner they are not.
fn is_crossing(picture: &Gray, board: &Charuco, marker: &Located, (point, shift): (Point2, Point2)) -> bool {
    let reach = 0.5 * board.gap_share();
    let level = |[x, y]: Point2| {
        let pixel = map_point(&marker.map, [point[0] + x * reach, point[1] + y * reach]);
        let shifted_pixel = [pixel[0] + shift[0], pixel[1] + shift[1]];
        picture.holds_with_margin(shifted_pixel, 1.0).then(|| picture.interpolated_level(shifted_pixel))
    };
    let pair = |a: Point2, b: Point2| Some((level(a)?.min(level(b)?), level(a)?.max(level(b)?)));
    // a marker to the upper left or lower right makes the falling diagonal white
    let is_falling = (marker.square[0] as f64 + 0.5 > point[0]) == (marker.square[1] as f64 + 0.5 > point[1]);
    let (falling, rising) = (pair([-1.0, -1.0], [1.0, 1.0]), pair([1.0, -1.0], [-1.0, 1.0]));
    let (white, black) = if is_falling { (falling, rising) } else { (rising, falling) };
    white.zip(black).is_some_and(|((least_white, _), (_, most_black))| least_white - most_black > LEAST_CONTRAST)
}
