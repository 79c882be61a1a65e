//! Detection of an asymmetric circle grid, OpenCV's: rows of dark dots, every second one shifted by half a pitch.
//!
//! The board's frame: dot (i, j) lies at ((2i + j mod 2) · square, j · square, 0), where `square` is the distance of two rows, half that of
//! two dots of a row; z points from the printed side towards the camera. With an odd number of rows the board looks the same from no other
//! side, so the order of its dots is unique.

use si::{Metre, Point2, Point3};

use super::{BoardError, check_levels, dots, lattice};
use crate::Gray;

/// A board of `rows` rows of `columns` dots.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AsymmetricDots {
    /// Dots of a row.
    pub columns: usize,
    /// Rows; an odd number.
    pub rows: usize,
    /// Distance of two rows, m: half the distance of two dots of a row.
    pub square: Metre,
}

impl AsymmetricDots {
    /// Places of the dots in rows and half pitches, row after row.
    fn dot_cells(&self) -> Vec<[i32; 2]> {
        let dot = |i: usize, j: usize| [(2 * i + j % 2) as i32, j as i32];
        (0..self.rows).flat_map(|j| (0..self.columns).map(move |i| dot(i, j))).collect()
    }

    /// The dots in the board's frame, m: row after row, i fastest.
    pub fn points(&self) -> Vec<Point3> {
        self.dot_cells().iter().map(|[x, y]| [f64::from(*x) * self.square, f64::from(*y) * self.square, 0.0]).collect()
    }
}

/// Finds the dots of `board`, px, in the order of [`AsymmetricDots::points`].
///
/// # Errors
/// [`BoardError`] when the board's order is not unique, or it is not in the picture as a whole.
pub fn find(picture: &Gray, board: &AsymmetricDots) -> Result<Vec<Point2>, BoardError> {
    check_levels(picture)?;
    let AsymmetricDots { columns, rows, .. } = *board;
    if columns < 2 || rows < 3 || rows.is_multiple_of(2) {
        return Err(BoardError::EvenRows { columns, rows });
    }
    // neighbours stand on the diagonals: u = (x + y) / 2 to the upper right, v = (y − x) / 2 to the upper left
    let cells: Vec<(i32, i32)> =
        board.dot_cells().iter().map(|[x, y]| ((x + y).div_euclid(2), (y - x).div_euclid(2))).collect();
    let (mut in_grid, mut seen) = (0, 0);
    for places in dots::disc_centres(picture) {
        match lattice::find_cells(&places, &cells) {
            Ok(dots) => return Ok(dots),
            Err(size) => (in_grid, seen) = (in_grid, seen).max((size, places.len())),
        }
    }
    Err(BoardError::NoDots { columns, rows, in_grid, seen })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_second_row_is_shifted_by_half_a_pitch() {
        let points = AsymmetricDots { columns: 2, rows: 3, square: 0.01 }.points();
        let expected = [[0.0, 0.0], [0.02, 0.0], [0.01, 0.01], [0.03, 0.01], [0.0, 0.02], [0.02, 0.02]];
        assert_eq!(points, expected.map(|[x, y]| [x, y, 0.0]));
    }

    #[test]
    fn a_board_of_even_rows_has_no_unique_order() {
        let board = AsymmetricDots { columns: 4, rows: 10, square: 0.01 };
        assert!(matches!(find(&Gray::filled(100, 80, 200), &board), Err(BoardError::EvenRows { rows: 10, .. })));
    }
}
