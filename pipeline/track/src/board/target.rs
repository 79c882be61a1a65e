//! A calibration target of either kind, by its points.

use si::{Point2, Point3};

use super::dots::{self, Dots};
use super::{Board, BoardError, find};
use crate::Gray;

/// A board of either kind.
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
