//! Detection of a checkerboard: its inner corners, to a fraction of a pixel, in a unique order.
//!
//! The board's frame: corner (i, j) lies at (i · square, j · square, 0); i runs along the columns, j along the rows, and z
//! points from the printed side towards the camera. The square that touches corner (0, 0) diagonally from outside is
//! black. A board of odd × even squares looks different upside down, so the order of its corners is unique.

pub mod dots;
mod lattice;
mod saddle;

use crate::Gray;
use dots::Dots;
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
    /// A picture that lacks grey levels.
    #[error(
        "no board can be sought in a picture of {width} × {height} px\n  why: it has {levels} grey levels; each pixel has one\n  do:  give width × height grey levels"
    )]
    Levels {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// Grey levels.
        levels: usize,
    },
    /// A dot board whose dots have no unique order.
    #[error(
        "a board of {columns} × {rows} dots cannot be ordered\n  why: after a quarter turn it looks the same, or it has fewer than 3 dots a side\n  do:  print one with unequal sides, such as 9 × 6"
    )]
    Square {
        /// Dots along the first axis.
        columns: usize,
        /// Dots along the second axis.
        rows: usize,
    },
    /// Too few dots, or no grid of the right size among them.
    #[error(
        "no board of {columns} × {rows} dots is in the picture\n  why: {in_grid} of its dots were seen in one grid, {seen} dark discs in all\n  do:  show the whole board, dark dots on light ground, closer, sharper or less tilted, or correct columns and rows"
    )]
    NoDots {
        /// Dots along the first axis.
        columns: usize,
        /// Dots along the second axis.
        rows: usize,
        /// Dots in the largest grid.
        in_grid: usize,
        /// Dark discs in the whole picture.
        seen: usize,
    },
    /// Too few corners, or no grid of the right size among them.
    #[error(
        "no board of {columns} × {rows} squares is in the picture\n  why: {}, {seen} corners in all\n  do:  show the whole board with a light margin, closer, sharper or less tilted, or correct columns and rows",
        largest_grid(*.in_grid, *.expected)
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

/// Blurs at which corners are looked for, px: a sharp picture first, then one out of focus or of large squares.
const BLURS: [f64; 3] = [2.0, 1.2, 4.0];
/// A corner is refined within this share of the way to its nearest neighbour, so that no other edge comes in.
const REFINED_SHARE: f64 = 0.35;
/// Bounds of that distance, px: enough pixels for the fit, and no more than a lens bends.
const REFINED: (f64, f64) = (3.0, 8.0);

/// The largest grid that was seen beside what a board has.
fn largest_grid(in_grid: usize, expected: usize) -> String {
    if in_grid > expected {
        return format!("a grid of {in_grid} inner corners was seen where such a board has {expected}");
    }
    format!("{in_grid} of its {expected} inner corners were seen in one grid")
}

/// Finds the inner corners of `board`, px, in the order of [`Board::corners`].
///
/// Saddles of the blurred picture, joined to a grid, refined in the picture itself, then turned so that black and white
/// fit the board. The whole board must be seen, with a light margin.
///
/// # Errors
/// [`BoardError`] when the board's order is not unique, or it is not completely in the picture: then with the number of
/// corners were seen.
pub fn find(picture: &Gray, board: &Board) -> Result<Vec<Point2>, BoardError> {
    whole(picture)?;
    let (columns, rows) = (board.columns, board.rows);
    let (across, down) = board.inner();
    if across < 2 || down < 2 || (columns + rows).is_multiple_of(2) {
        return Err(BoardError::Ambiguous { columns, rows });
    }
    let (mut in_grid, mut seen) = (0, 0);
    for blur in BLURS {
        let places: Vec<Point2> = saddle::saddles(picture, blur).iter().map(|s| s.at).collect();
        let rough = lattice::find(&places, across, down);
        match rough.map(|rough| refined(picture, &rough, across)) {
            Ok(Some(corners)) => return Ok(turned(picture, corners, board)),
            Ok(None) => {}
            Err(size) => (in_grid, seen) = (in_grid, seen).max((size, places.len())),
        }
    }
    Err(BoardError::NotFound { columns, rows, in_grid, seen, expected: across * down })
}

/// # Errors
/// [`BoardError::Levels`]
fn whole(picture: &Gray) -> Result<(), BoardError> {
    let (width, height, levels) = (picture.width, picture.height, picture.pixels.len());
    picture.check().map_err(|_| BoardError::Levels { width, height, levels })
}

/// Every corner to a fraction of a pixel; none when one of them is no saddle after all.
fn refined(picture: &Gray, rough: &[Point2], across: usize) -> Option<Vec<Point2>> {
    let distance = |a: usize, b: usize| (rough[a][0] - rough[b][0]).hypot(rough[a][1] - rough[b][1]);
    let place = |k: usize| {
        let beside = if (k + 1).is_multiple_of(across) { k - 1 } else { k + 1 };
        let below = if k + across < rough.len() { k + across } else { k - across };
        let radius = (REFINED_SHARE * distance(k, beside).min(distance(k, below))).clamp(REFINED.0, REFINED.1);
        saddle::refine(picture, rough[k], radius)
    };
    (0..rough.len()).map(place).collect()
}

/// The corners, or the corners upside down, so that the squares between them have the board's colours.
fn turned(picture: &Gray, mut corners: Vec<Point2>, board: &Board) -> Vec<Point2> {
    let (across, down) = board.inner();
    let middle = |i: usize, j: usize| {
        let at = |i: usize, j: usize| corners[j * across + i];
        let around = [at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)];
        [0, 1].map(|axis| 0.25 * around.iter().map(|p| p[axis]).sum::<f64>())
    };
    let mut levels = [(0.0, 0.0); 2]; // sum and number, of squares that should be white and black
    for (i, j) in (0..down - 1).flat_map(|j| (0..across - 1).map(move |i| (i, j))) {
        let (sum, number) = &mut levels[usize::from(board.black(i + 1, j + 1))];
        *sum += picture.level(middle(i, j));
        *number += 1.0;
    }
    let [white, black] = levels.map(|(sum, number)| sum / number);
    if black > white {
        corners.reverse();
    }
    corners
}

/// A calibration target of either kind, by its points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// Black and white squares: the points are the inner corners.
    Checkerboard(Board),
    /// Dark dots: the points are their middles.
    Dots(Dots),
}

impl Target {
    /// Its points in its own frame, m.
    pub fn points(&self) -> Vec<Point3> {
        match self {
            Self::Checkerboard(board) => board.corners(),
            Self::Dots(dots) => dots.points(),
        }
    }

    /// Its points in a picture, px, in the order of [`Target::points`].
    ///
    /// # Errors
    /// [`BoardError`] when it is not in the picture as a whole.
    pub fn find(&self, picture: &Gray) -> Result<Vec<Point2>, BoardError> {
        match self {
            Self::Checkerboard(board) => find(picture, board),
            Self::Dots(board) => dots::find(picture, board),
        }
    }
}
