//! Where on the board the markers of a picture stand, by their numbers and their neighbours.

use super::Charuco;
use super::marker::{Marker, UNIT};
use super::quads::{Quad, distance};
use crate::board::BoardError;
use crate::calibrate::homography::{homography, map_point};
use nalgebra::Matrix3;
use si::Point2;

/// A marker whose square is known.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Located {
    /// Column and row of its square; the first row is the upper one of the printed board.
    pub(super) square: [usize; 2],
    /// Its corners, px.
    pub(super) corners: Quad,
    /// From squares right and down of the printed board's upper left corner to px.
    pub(super) map: Matrix3<f64>,
}

/// Neighbours are compared within so many squares: further away a homography of four rough corners says little.
const NEAR: usize = 2;
/// A neighbour stands within this share of its side from where it is predicted; a square further it would be off by more than one.
const ASTRAY: f64 = 0.5;

/// The markers at their squares, without those whose neighbours contradict them.
///
/// # Errors
/// [`BoardError::OtherBoard`] when most neighbours are not where the board has them.
pub(super) fn locate_markers(markers: &[Marker], board: &Charuco) -> Result<Vec<Located>, BoardError> {
    // of an odd number of rows both prints begin with a black square
    let parities: &[usize] = if board.rows.is_multiple_of(2) { &[1, 0] } else { &[1] };
    let layouts = parities.iter().map(|parity| {
        let squares = white_squares(board, *parity);
        let placed: Vec<Located> =
            markers.iter().filter_map(|marker| at_square(marker, squares[marker.number], board)).collect();
        let balances: Vec<i64> = placed.iter().map(|marker| neighbour_balance(marker, &placed)).collect();
        (balances.iter().sum::<i64>(), placed, balances)
    });
    // the first of equals: today's print
    let best = layouts.reduce(|best, other| if other.0 > best.0 { other } else { best });
    let Some((sum, placed, balances)) = best else { return Ok(Vec::new()) };
    if sum < 0 {
        return Err(BoardError::OtherBoard { board: *board, markers: markers.len() });
    }
    let agreed = placed.iter().zip(&balances).filter(|(_, balance)| **balance >= 0);
    Ok(agreed.map(|(marker, _)| marker.clone()).collect())
}

/// The white squares, row after row: those with column + row of `parity`.
fn white_squares(board: &Charuco, parity: usize) -> Vec<[usize; 2]> {
    let cells = (0..board.rows).flat_map(|row| (0..board.columns).map(move |column| [column, row]));
    let mut white: Vec<[usize; 2]> = cells.filter(|[column, row]| (column + row) % 2 == parity).collect();
    // an odd board of the other parity has a square more than markers; never fewer
    white.resize(white.len().max(board.marker_count()), [0, 0]);
    white
}

fn at_square(marker: &Marker, square: [usize; 2], board: &Charuco) -> Option<Located> {
    let corner =
        |unit: Point2| [0, 1].map(|k| square[k] as f64 + board.gap_share() + unit[k] * (1.0 - 2.0 * board.gap_share()));
    let map = homography(&UNIT.map(corner), &marker.corners)?;
    Some(Located { square, corners: marker.corners, map })
}

/// Neighbours that stand where a marker predicts them, less those that do not.
fn neighbour_balance(marker: &Located, markers: &[Located]) -> i64 {
    let is_near = |other: &&Located| (0..2).all(|k| marker.square[k].abs_diff(other.square[k]) <= NEAR);
    let agrees = |other: &Located| {
        let predicted = map_point(&marker.map, other.square.map(|s| s as f64 + 0.5));
        distance(predicted, marker_centre(other)) < ASTRAY * distance(other.corners[0], other.corners[1])
    };
    let neighbours = markers.iter().filter(|other| !std::ptr::eq(*other, marker)).filter(is_near);
    neighbours.map(|other| if agrees(other) { 1 } else { -1 }).sum()
}

fn marker_centre(marker: &Located) -> Point2 {
    map_point(&marker.map, marker.square.map(|s| s as f64 + 0.5))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::charuco::Dictionary;

    const BOARD: Charuco =
        Charuco { columns: 5, rows: 4, square: 0.04, marker: 0.03, dictionary: Dictionary::opencv(4, 50) };

    /// The board seen squarely, 40 px a square, its upper left corner at (100, 50).
    fn seen(parity: usize, number: usize) -> Marker {
        let [column, row] = white_squares(&BOARD, parity)[number];
        let place = |unit: Point2| {
            [
                100.0 + 40.0 * (column as f64 + 0.125 + 0.75 * unit[0]),
                50.0 + 40.0 * (row as f64 + 0.125 + 0.75 * unit[1]),
            ]
        };
        Marker { number, corners: UNIT.map(place) }
    }

    #[test]
    fn both_prints_of_a_board_of_even_rows_are_told_apart() {
        for (parity, third) in [(1, [0, 1]), (0, [4, 0])] {
            let markers: Vec<Marker> = (0..10).map(|number| seen(parity, number)).collect();
            let located = locate_markers(&markers, &BOARD).unwrap();
            assert_eq!((located.len(), located[2].square), (10, third));
        }
    }

    #[test]
    fn a_marker_that_its_neighbours_contradict_is_left_out() {
        let mut markers: Vec<Marker> = (0..9).map(|number| seen(1, number)).collect();
        markers[4] = Marker { number: 4, ..seen(1, 9) };
        let located = locate_markers(&markers, &BOARD).unwrap();
        assert!(located.len() == 8 && located.iter().all(|marker| marker.square != white_squares(&BOARD, 1)[4]));
    }

    #[test]
    fn markers_of_a_board_of_another_size_are_refused() {
        let other = Charuco { columns: 6, rows: 5, ..BOARD };
        let markers: Vec<Marker> = (0..10).map(|number| seen(1, number)).collect();
        assert!(matches!(locate_markers(&markers, &other), Err(BoardError::OtherBoard { markers: 10, .. })));
    }
}
