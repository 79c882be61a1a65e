//! Calibration: from views of a board to the lens and where the camera stood.
//!
//! Stands on: the lens, poses, nalgebra. Never knows: how the corners were found. Paper: section IV.

use crate::board::Board;
use crate::lens::Lens;
use crate::pose::Pose;
use si::{Point2, Point3};

/// What one picture shows of the board.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// The inner corners, px, in the order of [`Board::corners`].
    pub corners: Vec<Point2>,
}

/// A calibrated camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// The lens.
    pub lens: Lens,
    /// Where the camera stood for each view: board → camera.
    pub poses: Vec<Pose>,
    /// Root of the mean squared distance between seen and projected corners, px.
    pub reprojection_px: f64,
    /// Standard deviation of each value of `lens`, in its own unit.
    pub sigma: Lens,
}

/// Why no lens or pose comes out.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CalibrateError {
    /// Fewer views than the lens needs.
    #[error(
        "{given} views are too few to calibrate a lens\n  why: {needed} are needed\n  do:  film the board in more and different tilts"
    )]
    TooFewViews {
        /// Views given.
        given: usize,
        /// Views needed.
        needed: usize,
    },
    /// A view with another number of corners than the board.
    #[error(
        "view {view} has {given} corners\n  why: the board has {expected}\n  do:  give whole boards only, in the order of its corners"
    )]
    Corners {
        /// Which view.
        view: usize,
        /// Its corners.
        given: usize,
        /// The board's corners.
        expected: usize,
    },
    /// Views or points that do not determine the unknowns.
    #[error(
        "the views do not fix the camera\n  why: {why}\n  do:  film the board in different tilts of 15 to 35 degrees, all over the frame"
    )]
    Degenerate {
        /// What is missing.
        why: String,
    },
    /// Points for a pose that are too few or not in a plane.
    #[error(
        "a pose cannot be found from these points\n  why: {why}\n  do:  give at least four points of one plane z = const and the pixel of each, spread over the frame"
    )]
    Points {
        /// What is wrong.
        why: String,
    },
}

/// Lens and poses from views of one board, for pictures of `width` × `height` px.
///
/// # Errors
/// [`CalibrateError`] when there are too few views, a view is not whole, or the tilts are too alike.
pub fn calibrate(views: &[View], board: &Board, width: usize, height: usize) -> Result<Calibration, CalibrateError> {
    let _ = (board, width, height);
    Err(CalibrateError::TooFewViews { given: views.len(), needed: 3 })
}

/// Where the camera stands, from points of a plane z = const (m) and their pixels (px).
///
/// # Errors
/// [`CalibrateError::Points`] when there are fewer than four, they are not in such a plane, or lie on a line.
pub fn pose_from_plane(lens: &Lens, points: &[Point3], pixels: &[Point2]) -> Result<Pose, CalibrateError> {
    let _ = (lens, pixels);
    Err(CalibrateError::Points { why: format!("{} points", points.len()) })
}
