//! A board of which nothing is known: what is printed on it, its size and its points in a picture.
//!
//! Each kind is told from the others by what they lack: readable markers, plain squares, light ground between dots.

use super::charuco::any::{MarkerSet, any_markers};
use super::lattice::Place;
use super::margin::{grid_margin, has_light_margin, level_at};
use super::reduced::Reduced;
use super::{BLURS, check_levels, dots, lattice, saddle};
use crate::Gray;
use crate::calibrate::homography::homography;
use si::Point2;

/// A board of which nothing was known.
#[derive(Debug, Clone, PartialEq)]
pub enum AnyBoard {
    /// A whole grid.
    Grid(AnyGrid),
    /// Markers, perhaps of a part of a ChArUco board.
    Markers(MarkerSet),
}

/// What a grid consists of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GridKind {
    /// Black and white squares.
    Checkerboard,
    /// Dark dots in a square grid.
    Dots,
    /// Rows of dark dots, every second one shifted.
    AsymmetricDots,
}

/// A whole grid of squares or dots.
#[derive(Debug, Clone, PartialEq)]
pub struct AnyGrid {
    /// What it consists of.
    pub kind: GridKind,
    /// Squares or dots along its longer side; of asymmetric dots, dots of a row.
    pub columns: usize,
    /// Squares or dots along its shorter side; of asymmetric dots, rows.
    pub rows: usize,
    /// Inner corners or dots, px, to some pixels; of square grids the first is the end that is nearer the picture's upper left corner.
    pub points: Vec<Point2>,
    /// Whether light ground is seen all around it: what ends at something dark may go on behind it.
    pub has_margin: bool,
}

/// Levels within a square may differ by this share of the difference of black and white.
const PLAIN: f64 = 0.5;
/// Part of the squares that are plain: a reflection may lie on some.
const MOSTLY: f64 = 0.8;
/// Dots of a grid, at least: fewer may be marks on a specimen.
const LEAST_DOTS: usize = 12;
/// Between two dots the ground has this share of the contrast, at least. Squares of a checkerboard touch there and have half.
const LIGHT_GROUND: f64 = 0.75;

/// The board in a picture of which nothing is known; none where there is no whole grid and no six markers.
pub fn any_board(picture: &Gray) -> Option<AnyBoard> {
    check_levels(picture).ok()?;
    let markers = any_markers(picture).map(AnyBoard::Markers);
    let checkerboard = || any_checkerboard(picture);
    markers.or_else(|| checkerboard().or_else(|| any_dots(picture)).map(AnyBoard::Grid))
}

fn any_checkerboard(picture: &Gray) -> Option<AnyGrid> {
    let reduced = Reduced::of_large_picture(picture);
    let searched = reduced.as_ref().map_or(picture, |reduced| &reduced.picture);
    let grid = BLURS[..2].iter().find_map(|blur| {
        let places: Vec<Point2> = saddle::find_saddles(searched, *blur).iter().map(|s| s.at).collect();
        lattice::largest_grid(&places)
    })?;
    let enlarge = |place: &Point2| reduced.as_ref().map_or(*place, |reduced| reduced.to_picture(*place));
    let points = from_upper_left(grid.places.iter().map(enlarge).collect());
    // of a board with markers that cannot be read the corners are those of a checkerboard
    let is_plain = has_plain_squares(picture, &points, grid.columns);
    let has_margin = grid_margin(picture, (&points, grid.columns), 1.3);
    let (columns, rows) = (grid.columns + 1, grid.rows + 1);
    is_plain.then_some(AnyGrid { kind: GridKind::Checkerboard, columns, rows, points, has_margin })
}

fn from_upper_left(mut points: Vec<Point2>) -> Vec<Point2> {
    let (first, last) = (points[0], points[points.len() - 1]);
    if last[0] + last[1] < first[0] + first[1] {
        points.reverse();
    }
    points
}

/// Whether most squares between inner corners (rows of `across`) have one level each, in two classes.
fn has_plain_squares(picture: &Gray, corners: &[Point2], across: usize) -> bool {
    let down = corners.len() / across;
    let squares: Vec<[f64; 9]> = (0..down - 1)
        .flat_map(|j| (0..across - 1).map(move |i| j * across + i))
        .map(|k| square_levels(picture, [corners[k], corners[k + 1], corners[k + across], corners[k + across + 1]]))
        .collect();
    let mut middles: Vec<f64> = squares.iter().map(|levels| levels[4]).collect();
    middles.sort_by(f64::total_cmp);
    let contrast = middles[middles.len() - 1] - middles[0];
    let is_plain = |levels: &&[f64; 9]| {
        let (low, high) = levels.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        high - low < PLAIN * contrast
    };
    squares.iter().filter(is_plain).count() as f64 >= MOSTLY * squares.len() as f64
}

/// Levels at nine places of a square, its middle the fifth.
fn square_levels(picture: &Gray, [a, b, c, d]: [Point2; 4]) -> [f64; 9] {
    std::array::from_fn(|k| {
        let [u, v] = [k % 3, k / 3].map(|step| 0.25 + 0.25 * step as f64);
        let pixel = [0, 1]
            .map(|axis| (1.0 - v) * ((1.0 - u) * a[axis] + u * b[axis]) + v * ((1.0 - u) * c[axis] + u * d[axis]));
        picture.interpolated_level(pixel)
    })
}

fn any_dots(picture: &Gray) -> Option<AnyGrid> {
    dots::rough_centres(picture)
        .find_map(|places| square_dots(picture, &places).or_else(|| shifted_dots(picture, &places)))
}

fn square_dots(picture: &Gray, places: &[Point2]) -> Option<AnyGrid> {
    let grid = lattice::largest_grid(places)?;
    let (columns, rows) = (grid.columns, grid.rows);
    let pairs = (0..grid.places.len()).filter(|k| (k + 1) % columns > 0).map(|k| [grid.places[k], grid.places[k + 1]]);
    let is_board = rows >= 3 && columns * rows >= LEAST_DOTS && is_ground_light(picture, &pairs.collect::<Vec<_>>());
    let points = from_upper_left(grid.places);
    let has_margin = grid_margin(picture, (&points, columns), 1.0);
    is_board.then_some(AnyGrid { kind: GridKind::Dots, columns, rows, points, has_margin })
}

/// Whether the picture is light half way between neighbouring dots, against what the darkest and the lightest of these places have.
fn is_ground_light(picture: &Gray, pairs: &[[Point2; 2]]) -> bool {
    let level = |[a, b]: &[Point2; 2], share: f64| {
        picture.interpolated_level([0, 1].map(|axis| (1.0 - share) * a[axis] + share * b[axis]))
    };
    let median = |mut levels: Vec<f64>| {
        levels.sort_by(f64::total_cmp);
        levels[levels.len() / 2]
    };
    if pairs.is_empty() {
        return false;
    }
    let dark = median(pairs.iter().map(|pair| level(pair, 0.0)).collect());
    let between = median(pairs.iter().map(|pair| level(pair, 0.5)).collect());
    // the lightest place beside the line of two dots, a quarter turn away from it
    let beside = |[a, b]: &[Point2; 2]| {
        let (middle, half) = ([0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])], [0.5 * (b[0] - a[0]), 0.5 * (b[1] - a[1])]);
        [1.0, -1.0]
            .map(|sign| [middle[0] - sign * half[1], middle[1] + sign * half[0]])
            .map(|place| if picture.holds_with_margin(place, 1.0) { picture.interpolated_level(place) } else { 0.0 })
    };
    let light = median(pairs.iter().map(|pair| beside(pair).into_iter().fold(0.0, f64::max)).collect());
    between - dark > LIGHT_GROUND * (light.max(between) - dark)
}

/// Dots in shifted rows, which stand on the diagonals of a square grid.
fn shifted_dots(picture: &Gray, places: &[Point2]) -> Option<AnyGrid> {
    let outline = lattice::largest_outline(places);
    let turns: [fn(Place) -> Place; 4] = [|(x, y)| (x, y), |(x, y)| (-y, x), |(x, y)| (-x, -y), |(x, y)| (y, -x)];
    let (columns, rows, points) = turns.iter().find_map(|turn| {
        let cells = outline.iter().map(|((u, v), place)| (turn((u - v, u + v)), *place));
        shifted_rows(cells.collect())
    })?;
    let pairs: Vec<[Point2; 2]> = (0..(rows - 1) * columns).map(|k| [points[k], points[k + columns]]).collect();
    let is_board = columns * rows >= LEAST_DOTS && rows >= 3 && is_ground_light(picture, &pairs);
    let cells: Vec<Point2> =
        (0..points.len()).map(|k| [(2 * (k % columns) + k / columns % 2) as f64, (k / columns) as f64]).collect();
    let has_margin = homography(&cells, &points).is_some_and(|map| {
        let beside = cells.iter().map(|[x, y]| [x + 1.0, *y]).collect::<Vec<_>>();
        let levels: Vec<f64> = beside.iter().chain(&cells).filter_map(|cell| level_at(picture, &map, *cell)).collect();
        has_light_margin(picture, &map, ([-1.0, 2.0 * columns as f64], [-1.0, rows as f64]), &levels)
    });
    is_board.then_some(AnyGrid { kind: GridKind::AsymmetricDots, columns, rows, points, has_margin })
}

/// Dots of a row, rows and dots in their order, where the cells (half pitches, rows) are exactly rows of equal length, every second one
/// shifted by one.
fn shifted_rows(mut cells: Vec<(Place, Point2)>) -> Option<(usize, usize, Vec<Point2>)> {
    let least = |axis: fn(&Place) -> i32| cells.iter().map(|(cell, _)| axis(cell)).min();
    let (left, top) = (least(|cell| cell.0)?, least(|cell| cell.1)?);
    cells.sort_by_key(|((x, y), _)| (*y, *x));
    let rows = (cells[cells.len() - 1].0.1 - top + 1) as usize;
    let columns = cells.len() / rows;
    let is_in_place = |(k, ((x, y), _)): (usize, &(Place, Point2))| {
        let (i, j) = (k % columns, k / columns);
        (x - left, y - top) == ((2 * i + j % 2) as i32, j as i32)
    };
    let is_whole = columns >= 2 && columns * rows == cells.len() && cells.iter().enumerate().all(is_in_place);
    is_whole.then(|| (columns, rows, cells.into_iter().map(|(_, place)| place).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_that_are_shifted_in_turn_are_told_from_others() {
        let cells = |rows: i32| {
            let row = move |j: i32| (0..4).map(move |i| ((2 * i + j % 2 + 7, j - 3), [f64::from(i), f64::from(j)]));
            (0..rows).flat_map(row).collect::<Vec<_>>()
        };
        let (columns, rows, points) = shifted_rows(cells(11)).unwrap_or_default();
        assert_eq!((columns, rows, points[5]), (4, 11, [1.0, 1.0]));
        let mut holed = cells(11);
        holed.remove(6);
        assert_eq!(shifted_rows(holed), None);
        let square = (0..20).map(|k| ((k % 5, k / 5), [0.0; 2])).collect();
        assert_eq!(shifted_rows(square), None);
    }

    #[test]
    fn squares_that_touch_are_no_dots_and_squares_with_markers_no_checkerboard() {
        let dark = |x: usize, y: usize| (x / 20 + y / 20).is_multiple_of(2);
        let board = Gray::from_fn(240, 200, |x, y| if dark(x, y) { 30.0 } else { 220.0 });
        let middles: Vec<[Point2; 2]> = (0..8).map(|k| [k, k + 1].map(|n| [9.5 + 20.0 * n as f64; 2])).collect();
        assert!(!is_ground_light(&board, &middles));
        let corners: Vec<Point2> =
            (0..20).map(|k| [19.5 + 20.0 * (k % 5) as f64, 19.5 + 20.0 * (k / 5) as f64]).collect();
        assert!(has_plain_squares(&board, &corners, 5));
        let marked = Gray::from_fn(240, 200, |x, y| {
            let is_inside = [x % 20, y % 20].iter().all(|place| (3..17).contains(place));
            let is_bit = is_inside && (x % 20 / 4 + y % 20 / 4).is_multiple_of(2);
            if dark(x, y) || is_bit { 30.0 } else { 220.0 }
        });
        assert!(!has_plain_squares(&marked, &corners, 5));
    }
}
