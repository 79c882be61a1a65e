//! `[camera]`: the calibration recording, the board in it, and the plane of the board.

use serde::{Deserialize, Serialize};
use si::{Metre, Point2, Second};

/// `[camera]`: the calibration recording.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Camera {
    /// Film of a board in several poses, with the same camera and settings as the trials; relative to the card.
    pub calibration: String,
    /// Interval of the frames that are used.
    pub frame_every: usize,
    /// Its distortion model; Brown–Conrady by default.
    #[serde(default)]
    pub lens: LensKind,
    /// Known lens coefficients: YAML, JSON or XML of OpenCV, ROS or Kalibr, relative to the card. The calibration then only has to show the board on
    /// its plane.
    #[serde(default)]
    pub coefficients: Option<String>,
    /// From the time of the first row of a frame to that of the last, s; the frame's time is its middle row's. 0 when the
    /// card is silent: all rows at once.
    #[serde(default)]
    pub readout: Second,
    /// The checkerboard.
    pub board: Board,
    /// The plane on which the board lay still at the end.
    pub plane: Plane,
}

/// The distortion model of a lens.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LensKind {
    /// Brown and Conrady's, of ordinary lenses.
    #[default]
    BrownConrady,
    /// Equidistant, of fisheyes.
    Fisheye,
}

/// What is printed on a board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum BoardKind {
    /// Black and white squares.
    #[default]
    Checkerboard,
    /// Dark dots in a square grid; the first is the one of its two ends that lies nearer the picture's upper left corner.
    Dots,
    /// Dark dots in an odd number of rows, every second row shifted by half a pitch: OpenCV's asymmetric circle grid.
    #[serde(rename = "asymmetric_dots")]
    AsymmetricDots,
    /// A checkerboard with ArUco markers in its white squares.
    Charuco,
}

/// `[camera.board]`: what is shown to the camera. With dots, `columns`, `rows` and `square` are their number each way and the
/// distance between their middles, and what is said of the inner corner (0, 0) holds for the first dot; of asymmetric dots `columns` are in
/// each of `rows`, and `square` is the distance of two rows. Of a ChArUco board corner (0, 0) is the lower left one of the upright print.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Board {
    /// What is printed on it; a checkerboard by default.
    #[serde(default)]
    pub kind: BoardKind,
    /// Squares along the first axis; odd where `rows` is even, or the other way round, so that the board has one way up.
    pub columns: usize,
    /// Squares along the second axis.
    pub rows: usize,
    /// Side of a square, m.
    pub square: Metre,
    /// Of a ChArUco board, the side of a marker, m.
    #[serde(default)]
    pub marker: Option<Metre>,
    /// Of a ChArUco board, the dictionary of its markers by OpenCV's name, such as `DICT_4X4_50`.
    #[serde(default)]
    pub dictionary: Option<String>,
}

/// `[camera.plane]`: when and where the board lay on the plane that ties pixels to the CAD frame.
#[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Plane {
    /// First and last second of the calibration video in which the board lies still on the plane.
    pub seconds: [f64; 2],
    /// Where its inner corner (0, 0) lies, m, x and y of the CAD frame.
    pub origin: Point2,
    /// Unit vector, in x and y of the CAD frame, along which the columns count up. Rows count up a quarter turn
    /// anticlockwise of it, seen from the camera: along (cos a, sin a), the rows run along (−sin a, cos a).
    pub along: Point2,
    /// z of the plane, m, CAD frame.
    pub height: Metre,
    /// Pitch of bright lines on it along x and y of the CAD frame, one of each through its origin, m: the camera's pose in each film is found from them.
    pub grid: Option<Metre>,
}
