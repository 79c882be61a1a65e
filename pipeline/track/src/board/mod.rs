//! Detection of a checkerboard: its inner corners, to a fraction of a pixel, in a unique order.
//!
//! The board's frame: corner (i, j) lies at (i · square, j · square, 0); i runs along the columns, j along the rows, and z
//! points from the printed side towards the camera. The square that touches corner (0, 0) diagonally from outside is
//! black. A board of odd × even squares looks different upside down, so the order of its corners is unique.

pub mod any;
pub mod asymmetric;
pub mod charuco;
mod dark;
pub mod dots;
mod lattice;
mod margin;
pub mod reduced;
mod saddle;

use crate::Gray;
use crate::calibrate::View;
use asymmetric::AsymmetricDots;
use charuco::{Charuco, Dictionary};
use dots::Dots;
use reduced::Reduced;
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
    /// An asymmetric circle grid whose dots have no unique order.
    #[error(
        "a board of {rows} shifted rows of {columns} dots cannot be ordered\n  why: with an even number of rows it looks the same upside down, or it has fewer than 3 rows of 2\n  do:  print one with an odd number of rows, such as 4 × 11"
    )]
    EvenRows {
        /// Dots of a row.
        columns: usize,
        /// Rows.
        rows: usize,
    },
    /// A ChArUco board that cannot be.
    #[error(
        "a ChArUco board of {} × {} squares of {} m with markers of {} m of {} cannot be\n  why: it needs {} markers of the dictionary's {}, 3 squares a side, and markers smaller than its squares\n  do:  correct columns, rows, square, marker or dictionary", .board.columns, .board.rows, .board.square, .board.marker, .board.dictionary, .board.marker_count(), .board.dictionary.count
    )]
    NoCharuco {
        /// The board.
        board: Charuco,
    },
    /// No marker of the dictionary.
    #[error(
        "no marker of {dictionary} is in the picture\n  why: it has {quads} dark quadrilaterals{}\n  do:  {}", known_markers(*.other), other_dictionary(*.other)
    )]
    NoMarker {
        /// The board's dictionary.
        dictionary: Dictionary,
        /// Dark quadrilaterals, those in which a marker is looked for.
        quads: usize,
        /// A dictionary whose markers are in the picture.
        other: Option<Dictionary>,
    },
    /// Markers that do not stand as those of the board.
    #[error(
        "the {markers} markers in the picture do not stand as those of a board of {} × {} squares\n  why: their numbers count up row after row of such a board; most neighbours contradict it\n  do:  correct columns and rows: squares, columns along the rows in which the markers count up", .board.columns, .board.rows
    )]
    OtherBoard {
        /// The board.
        board: Charuco,
        /// Markers that were read.
        markers: usize,
    },
    /// Too few corners of a ChArUco board.
    #[error(
        "{corners} of the board's {expected} inner corners are seen beside {markers} markers\n  why: a view needs {least} of them, in two rows and two columns\n  do:  show more of the board, closer, sharper or less tilted"
    )]
    FewCorners {
        /// Corners that were seen.
        corners: usize,
        /// Markers that were read.
        markers: usize,
        /// Corners that a view needs.
        least: usize,
        /// Corners of the board.
        expected: usize,
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
    // of a plain checkerboard a part could be any part: there is nothing that says which
    #[error(
        "no board of {columns} × {rows} squares is in the picture\n  why: {}, {seen} corners in all; of a plain checkerboard a part cannot be told from another\n  do:  show the whole board with a light margin, closer, sharper or less tilted, or correct columns and rows",
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
    pub(crate) fn inner_corner_counts(&self) -> (usize, usize) {
        (self.columns.saturating_sub(1), self.rows.saturating_sub(1))
    }

    /// The inner corners in the board's frame, m: row after row, i fastest.
    pub fn corner_points(&self) -> Vec<Point3> {
        let (across, down) = self.inner_corner_counts();
        let corner = |i: usize, j: usize| [i as f64 * self.square, j as f64 * self.square, 0.0];
        (0..down).flat_map(|j| (0..across).map(move |i| corner(i, j))).collect()
    }

    /// Whether the square (column, row) is black; (0, 0) is the outer square at corner (0, 0).
    pub fn is_black(&self, column: usize, row: usize) -> bool {
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

/// What is said of a dictionary whose markers were seen instead.
fn known_markers(other: Option<Dictionary>) -> String {
    other.map_or_else(String::new, |other| format!(", of which several are markers of {other}"))
}

fn other_dictionary(other: Option<Dictionary>) -> String {
    match other {
        Some(other) => format!(
            "name the dictionary that the board was printed from: {other} or another of {0}×{0} bits",
            other.side
        ),
        None => "show the board closer, sharper or less tilted, with the print upright: not mirrored".into(),
    }
}

/// Finds the inner corners of `board`, px, in the order of [`Board::corner_points`].
///
/// Saddles of the blurred picture, joined to a grid, refined in the picture itself, then turned so that black and white
/// fit the board. The whole board must be seen, with a light margin.
///
/// # Errors
/// [`BoardError`] when the board's order is not unique, or it is not completely in the picture: then with the number of
/// corners were seen.
pub fn find(picture: &Gray, board: &Board) -> Result<Vec<Point2>, BoardError> {
    check_levels(picture)?;
    let (columns, rows) = (board.columns, board.rows);
    let (across, down) = board.inner_corner_counts();
    if across < 2 || down < 2 || (columns + rows).is_multiple_of(2) {
        return Err(BoardError::Ambiguous { columns, rows });
    }
    let reduced = Reduced::of_large_picture(picture).and_then(|reduced| {
        let rough: Vec<Point2> =
            corners_in_order(&reduced.picture, board).ok()?.iter().map(|p| reduced.to_picture(*p)).collect();
        refine_corners(picture, &rough, across)
    });
    match reduced {
        Some(corners) => Ok(orient_corners(picture, corners, board)),
        None => corners_in_order(picture, board).map(|corners| orient_corners(picture, corners, board)),
    }
}

/// The corners of the board in the order of a grid, from either end.
fn corners_in_order(picture: &Gray, board: &Board) -> Result<Vec<Point2>, BoardError> {
    let (across, down) = board.inner_corner_counts();
    let (mut in_grid, mut count_seen) = (0, 0);
    for blur in BLURS {
        let places: Vec<Point2> = saddle::find_saddles(picture, blur).iter().map(|s| s.at).collect();
        let rough = lattice::find(&places, across, down);
        match rough.map(|rough| refine_corners(picture, &rough, across)) {
            Ok(Some(corners)) => return Ok(corners),
            Ok(None) => {}
            Err(size) => (in_grid, count_seen) = (in_grid, count_seen).max((size, places.len())),
        }
    }
    let Board { columns, rows, .. } = *board;
    Err(BoardError::NotFound { columns, rows, in_grid, seen: count_seen, expected: across * down })
}

/// # Errors
/// [`BoardError::Levels`]
fn check_levels(picture: &Gray) -> Result<(), BoardError> {
    let (width, height, levels) = (picture.width, picture.height, picture.pixels.len());
    picture.check().map_err(|_| BoardError::Levels { width, height, levels })
}

/// Every corner to a fraction of a pixel; none when one of them is no saddle after all.
fn refine_corners(picture: &Gray, rough: &[Point2], across: usize) -> Option<Vec<Point2>> {
    let distance = |a: usize, b: usize| (rough[a][0] - rough[b][0]).hypot(rough[a][1] - rough[b][1]);
    let refine_corner = |k: usize| {
        let column_neighbour = if (k + 1).is_multiple_of(across) { k - 1 } else { k + 1 };
        let row_neighbour = if k + across < rough.len() { k + across } else { k - across };
        let radius =
            (REFINED_SHARE * distance(k, column_neighbour).min(distance(k, row_neighbour))).clamp(REFINED.0, REFINED.1);
        saddle::refine_saddle(picture, rough[k], radius)
    };
    (0..rough.len()).map(refine_corner).collect()
}

/// The corners, or the corners upside down, so that the squares between them have the board's colours.
fn orient_corners(picture: &Gray, mut corners: Vec<Point2>, board: &Board) -> Vec<Point2> {
    let (across, down) = board.inner_corner_counts();
    let middle = |i: usize, j: usize| {
        let corner_at = |i: usize, j: usize| corners[j * across + i];
        let square_corners = [corner_at(i, j), corner_at(i + 1, j), corner_at(i, j + 1), corner_at(i + 1, j + 1)];
        [0, 1].map(|axis| 0.25 * square_corners.iter().map(|p| p[axis]).sum::<f64>())
    };
    let mut levels = [(0.0, 0.0); 2]; // sum and number, of squares that should be white and black
    for (i, j) in (0..down - 1).flat_map(|j| (0..across - 1).map(move |i| (i, j))) {
        let (sum, number) = &mut levels[usize::from(board.is_black(i + 1, j + 1))];
        *sum += picture.interpolated_level(middle(i, j));
        *number += 1.0;
    }
    let [white, black] = levels.map(|(sum, number)| sum / number);
    if black > white {
        corners.reverse();
    }
    corners
}

/// A calibration target of any kind, by its points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// Black and white squares: the points are the inner corners.
    Checkerboard(Board),
    /// Dark dots: the points are their middles.
    Dots(Dots),
    /// Rows of dark dots, every second one shifted.
    AsymmetricDots(AsymmetricDots),
    /// Squares with markers: the points are the inner corners, of which a part may be seen.
    Charuco(Charuco),
}

/// What is printed on a target.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum TargetKind {
    /// Black and white squares.
    #[default]
    Checkerboard,
    /// Dark dots in a square grid.
    Dots,
    /// Rows of dark dots, every second one shifted.
    AsymmetricDots,
    /// Squares with markers of this side (m) and dictionary.
    Charuco(Metre, Dictionary),
}

impl TargetKind {
    /// A ChArUco board; with nothing known of it, one that [`Target::find`] refuses.
    pub fn charuco(marker: Option<Metre>, dictionary: Option<Dictionary>) -> Self {
        Self::Charuco(marker.unwrap_or(0.0), dictionary.unwrap_or(Dictionary::opencv(4, 50)))
    }
}

impl Target {
    /// A target of `columns` × `rows` squares or dots; `square` is the side of a square, or the distance of dots (of rows, where every
    /// second one is shifted), m.
    pub fn new(kind: TargetKind, [columns, rows]: [usize; 2], square: Metre) -> Self {
        match kind {
            TargetKind::Checkerboard => Self::Checkerboard(Board { columns, rows, square }),
            TargetKind::Dots => Self::Dots(Dots { columns, rows, pitch: square }),
            TargetKind::AsymmetricDots => Self::AsymmetricDots(AsymmetricDots { columns, rows, square }),
            TargetKind::Charuco(marker, dictionary) => {
                Self::Charuco(Charuco { columns, rows, square, marker, dictionary })
            }
        }
    }

    /// Its points in its own frame, m.
    pub fn points(&self) -> Vec<Point3> {
        match self {
            Self::Checkerboard(board) => board.corner_points(),
            Self::Dots(dots) => dots.points(),
            Self::AsymmetricDots(dots) => dots.points(),
            Self::Charuco(Charuco { columns, rows, square, .. }) => {
                Board { columns: *columns, rows: *rows, square: *square }.corner_points()
            }
        }
    }

    /// Its points in a picture, px, in the order of [`Target::points`]: all of them, but of a ChArUco board those that are seen.
    ///
    /// # Errors
    /// [`BoardError`] when it is not in the picture as a whole, or too little of a ChArUco board is.
    pub fn find(&self, picture: &Gray) -> Result<View, BoardError> {
        match self {
            Self::Checkerboard(board) => find(picture, board).map(View::of_whole_board),
            Self::Dots(board) => dots::find(picture, board).map(View::of_whole_board),
            Self::AsymmetricDots(board) => asymmetric::find(picture, board).map(View::of_whole_board),
            Self::Charuco(board) => charuco::find(picture, board),
        }
    }
}
