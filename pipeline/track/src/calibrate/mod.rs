//! Camera calibration from views of a planar target: intrinsic parameters, distortion and poses. Paper, section IV.

mod elimination;
mod focal;
pub(crate) mod homography;
mod refine;

use crate::lens::{Distortion, Lens, VALUES};
use crate::pose::Pose;
pub use focal::{FocalDifference, focal_difference};
use homography::{homography, mirrored_pose, pose_of_homography};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use refine::{Guess, Seen, refine, squared_misses};
use si::{Metre, Point2, Point3};

/// What one picture shows of a board.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// Its points, px, in the board's own order.
    pub corners: Vec<Point2>,
    /// Which of the board's points they are, in ascending order; all of them where nothing is said.
    pub numbers: Option<Vec<usize>>,
}

impl View {
    /// A view of all points.
    pub fn of_whole_board(corners: Vec<Point2>) -> Self {
        Self { corners, numbers: None }
    }

    /// The points of the board that it shows, m.
    pub fn points(&self, board: &[Point3]) -> Vec<Point3> {
        match &self.numbers {
            None => board.to_vec(),
            Some(numbers) => numbers.iter().filter_map(|number| board.get(*number).copied()).collect(),
        }
    }

    /// The pixel of one of the board's points, where it is seen.
    pub fn corner_pixel(&self, number: usize) -> Option<Point2> {
        let index = self.numbers.as_ref().map_or(Some(number), |numbers| numbers.binary_search(&number).ok());
        self.corners.get(index?).copied()
    }

    /// The mean of views of a board at rest: of each point that one of them shows, over those that do.
    pub fn mean(views: &[Self]) -> Self {
        let count = views.iter().map(Self::extent).max().unwrap_or(0);
        let mean = |number: usize| {
            let pixels: Vec<Point2> = views.iter().filter_map(|view| view.corner_pixel(number)).collect();
            let sum = |k: usize| pixels.iter().map(|p| p[k]).sum::<f64>() / pixels.len() as f64;
            (!pixels.is_empty()).then(|| (number, [sum(0), sum(1)]))
        };
        let (numbers, corners) = (0..count).filter_map(mean).unzip();
        let is_whole = views.iter().all(|view| view.numbers.is_none());
        Self { corners, numbers: (!is_whole).then_some(numbers) }
    }

    /// One more than the largest number of its points.
    fn extent(&self) -> usize {
        let last = self.numbers.as_ref().and_then(|numbers| numbers.last());
        self.numbers.as_ref().map_or(self.corners.len(), |_| last.map_or(0, |last| last + 1))
    }
}

/// A calibrated camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    /// The lens.
    pub lens: Lens,
    /// Camera pose of each view: board → camera.
    pub poses: Vec<Pose>,
    /// Root of the mean squared distance between seen and projected corners, px.
    pub reprojection_px: f64,
    /// Covariance of [`Lens::values`], in their units.
    pub covariance: [[f64; VALUES]; VALUES],
}

impl Calibration {
    /// Standard deviation of each of [`Lens::values`], in its own unit.
    pub fn sigma(&self) -> [f64; VALUES] {
        std::array::from_fn(|i| self.covariance[i][i].sqrt())
    }
}

/// Numbers of a camera: those of its lens, then turn (rad) and shift (m) of its pose as [`Pose::rotated_and_shifted`] takes them.
pub const CAMERA_PARAMETERS: usize = VALUES + 6;

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
        "the views do not determine the camera\n  why: {why}\n  do:  film the board in different tilts of 15 to 35 degrees, all over the frame"
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

/// Least number of views of a plane that determine the parameters of a lens.
const LEAST_VIEWS: usize = 3;

/// Lens and poses from views of one board, whose `points` lie in its plane z = 0 (m), for pictures of `width` × `height` px.
///
/// Focal lengths from homographies with the optical axis in the middle of the picture [zhang2000, section 3.1], then
/// Levenberg–Marquardt over everything, first without and then with the numbers of the lens.
///
/// # Errors
/// [`CalibrateError`] when there are too few views, a view is not whole, or the tilts are too alike.
pub fn calibrate(
    views: &[View],
    points: &[Point3],
    distortion: Distortion,
    (width, height): (usize, usize),
) -> Result<Calibration, CalibrateError> {
    let shown: Vec<Vec<Point3>> = views.iter().map(|view| view.points(points)).collect();
    if let Some(view) = (0..views.len()).find(|view| views[*view].corners.len() != shown[*view].len()) {
        return Err(CalibrateError::Corners { view, given: views[view].corners.len(), expected: shown[view].len() });
    }
    if views.len() < LEAST_VIEWS {
        return Err(CalibrateError::TooFewViews { given: views.len(), needed: LEAST_VIEWS });
    }
    let middle = [0.5 * (width as f64 - 1.0), 0.5 * (height as f64 - 1.0)];
    let correspondences: Vec<_> =
        views.iter().zip(&shown).map(|(view, points)| Seen { points, pixels: &view.corners }).collect();
    let lens = Lens { distortion, ..initial_lens(&correspondences, middle)? };
    let mut guess = Guess { lens, poses: initial_poses(&lens, &correspondences)? };
    refine(&mut guess, &correspondences, false);
    let sum = refine(&mut guess, &correspondences, true);
    let covariance = refine::lens_covariance(&guess, &correspondences);
    let covariance = covariance.ok_or_else(|| degenerate_error("the equations of the lens are singular"))?;
    let sigma = covariance[0][0].sqrt();
    if sigma > FOCAL_SIGMA_LIMIT * guess.lens.fx {
        let why = format!("the focal length would be {:.0} ± {sigma:.0} px", guess.lens.fx);
        return Err(CalibrateError::Degenerate { why });
    }
    let reprojection_px = (sum / shown.iter().map(Vec::len).sum::<usize>() as f64).sqrt();
    Ok(Calibration { lens: guess.lens, poses: guess.poses, reprojection_px, covariance })
}

fn degenerate_error(why: &str) -> CalibrateError {
    CalibrateError::Degenerate { why: why.into() }
}

/// x and y of points of the plane z = 0.
fn in_plane(points: &[Point3]) -> Vec<Point2> {
    points.iter().map(|p| [p[0], p[1]]).collect()
}

/// A pinhole from the maps of the views, the optical axis at `middle` (px).
fn initial_lens(views: &[Seen], middle: Point2) -> Result<Lens, CalibrateError> {
    let maps: Option<Vec<_>> = views.iter().map(|view| homography(&in_plane(view.points), view.pixels)).collect();
    let maps = maps.ok_or_else(|| degenerate_error("the corners of a view lie on a line"))?;
    focal_lengths(&maps, middle).ok_or_else(|| degenerate_error("the board is tilted alike in all views"))
}

/// Initial pose of each view, from the rays of its pixels through the initial lens.
fn initial_poses(lens: &Lens, views: &[Seen]) -> Result<Vec<Pose>, CalibrateError> {
    let initial_pose = |view: &Seen| {
        let rays: Option<Vec<Point2>> = view.pixels.iter().map(|pixel| lens.unproject(*pixel)).collect();
        Some(pose_of_homography(&homography(&in_plane(view.points), &rays?)?))
    };
    let poses: Option<Vec<Pose>> = views.iter().map(initial_pose).collect();
    poses.ok_or_else(|| degenerate_error("a view reaches beyond the rays of its first lens"))
}

/// Joint covariance of a lens and a pose, when the pose was found from `points` (m) and `pixels` (px) with a lens
/// of this covariance: 15 × 15, in the order and units of [`CAMERA_PARAMETERS`].
///
/// # Errors
/// [`CalibrateError::Points`] when the points do not fix the pose.
pub fn joint_covariance(
    (lens, covariance): (&Lens, &[[f64; VALUES]; VALUES]),
    pose: &Pose,
    points: &[Point3],
    pixels: &[Point2],
) -> Result<[[f64; CAMERA_PARAMETERS]; CAMERA_PARAMETERS], CalibrateError> {
    let guess = Guess { lens: *lens, poses: vec![*pose] };
    let joint = refine::joint_covariance(covariance, &guess, &[Seen { points, pixels }]);
    joint.ok_or_else(|| CalibrateError::Points { why: "the points lie on a line".into() })
}

/// Largest relative standard deviation of a focal length that is accepted.
const FOCAL_SIGMA_LIMIT: f64 = 0.1;

/// fx and fy from maps of a plane, the optical axis at `middle` (px): the columns of K⁻¹H are orthogonal and equally long.
///
/// Two equations a map in 1/fx² and 1/fy², least squares. None when they do not fix both or ask for an imaginary lens.
fn focal_lengths(maps: &[Matrix3<f64>], middle: Point2) -> Option<Lens> {
    let centre = Matrix3::new(1.0, 0.0, -middle[0], 0.0, 1.0, -middle[1], 0.0, 0.0, 1.0);
    let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
    for map in maps {
        let map = centre * map;
        // A homography has no scale: undivided, a view would count by the size of its numbers.
        let size = 0.5 * (map.column(0).norm() + map.column(1).norm());
        let (a, b): (Vector3<f64>, Vector3<f64>) = (map.column(0) / size, map.column(1) / size);
        let (sum, difference) = (a + b, a - b);
        for (row, value) in [
            (Vector2::new(a.x * b.x, a.y * b.y), -a.z * b.z),
            (Vector2::new(sum.x * difference.x, sum.y * difference.y), -sum.z * difference.z),
        ] {
            normal += row * row.transpose();
            right += row * value;
        }
    }
    let inverse = normal.try_inverse()? * right;
    let lens = Lens::pinhole(inverse.x.recip().sqrt(), inverse.y.recip().sqrt(), middle[0], middle[1]);
    (lens.fx.is_finite() && lens.fy.is_finite()).then_some(lens)
}

/// The camera pose from points of a plane z = const (m) and their pixels (px): world → camera.
///
/// # Errors
/// [`CalibrateError::Points`] when there are fewer than four, they are not in such a plane, or lie on a line.
pub fn pose_from_plane(lens: &Lens, points: &[Point3], pixels: &[Point2]) -> Result<Pose, CalibrateError> {
    let height = plane_height(points, pixels)?;
    let unseen = |i: usize| CalibrateError::Points { why: format!("no ray of the lens reaches pixel {:?}", pixels[i]) };
    let rays: Result<Vec<Point2>, _> =
        pixels.iter().enumerate().map(|(i, &pixel)| lens.unproject(pixel).ok_or_else(|| unseen(i))).collect();
    let plane: Vec<Point2> = points.iter().map(|p| [p[0], p[1]]).collect();
    let line = || CalibrateError::Points { why: "the points or pixels lie on a line".into() };
    let flat = pose_of_homography(&homography(&plane, &rays?).ok_or_else(line)?);
    let n = points.len() as f64;
    let middle = plane.iter().fold([0.0; 3], |m, p| [m[0] + p[0] / n, m[1] + p[1] / n, 0.0]);

    let correspondences = [Seen { points: &points.iter().map(|p| [p[0], p[1], 0.0]).collect::<Vec<_>>(), pixels }];
    // Both tilts are local minima of the reprojection error of a plane far away, and noise decides which one the
    // homography gives.
    let starts = [flat, mirrored_pose(&flat, middle)];
    let refined = starts.map(|start| {
        let mut guess = Guess { lens: *lens, poses: vec![start] };
        (refine(&mut guess, &correspondences, false), guess.poses[0])
    });
    let (_, Pose { rotation, translation }) = if refined[1].0 < refined[0].0 { refined[1] } else { refined[0] };
    let lowered = si::vec3::sub(translation, rotation.map(|row| row[2] * height));
    Ok(Pose { rotation, translation: lowered })
}

/// The common z of the points, m.
fn plane_height(points: &[Point3], pixels: &[Point2]) -> Result<Metre, CalibrateError> {
    if points.len() != pixels.len() || points.len() < 4 {
        let why = format!("{} points and {} pixels", points.len(), pixels.len());
        return Err(CalibrateError::Points { why });
    }
    let (low, high) = points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p[2]), h.max(p[2])));
    if high - low > 1e-9 {
        return Err(CalibrateError::Points { why: format!("their z runs from {low} to {high} m") });
    }
    Ok(low)
}

/// Root of the mean squared distance between `pixels` and the projected `points`, px.
pub fn reprojection_error(lens: &Lens, pose: &Pose, points: &[Point3], pixels: &[Point2]) -> f64 {
    let guess = Guess { lens: *lens, poses: vec![*pose] };
    (squared_misses(&guess, &[Seen { points, pixels }]) / points.len().max(1) as f64).sqrt()
}
