//! Camera pose from the grid of lines under a scene, in one picture.
//!
//! An approximate pose predicts where each line is seen. Between two crossings the middle of the line is measured across it; the rays
//! through these points must intersect the plane on their lines. The six parameters of the pose are adjusted by Gauss–Newton.

use nalgebra::{Matrix6, Vector6};
use si::{Metre, Point2};

use crate::gray::Gray;
use crate::pose::Pose;
use crate::refraction::RefractiveCamera;

/// Lines along x and y through every multiple of the pitch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Distance of neighbouring lines, m.
    pub pitch: Metre,
    /// z of the plane, m.
    pub height: Metre,
}

/// Camera pose estimated from a grid.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraPose {
    /// World → camera.
    pub pose: Pose,
    /// Pieces of lines that were used.
    pub segments: usize,
    /// Root of the mean squared distance of their middles from their lines, m on the plane.
    pub rms_error: Metre,
}

/// A middle of a line: where it is seen, and what its ray must intersect.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Tie {
    pixel: Point2,
    /// 0 when the line lies at one x, 1 at one y.
    axis: usize,
    at: Metre,
}

/// A line is looked for this far to both sides of where it should be, over the pitch.
const REACH: f64 = 0.3;
/// Samples across, to each side.
const SAMPLES: usize = 24;
/// Along a piece between two crossings: where lines are cut, over the pitch.
// Away from the crossings at 0 and 1, where the line across, up to 0.16 wide and blurred, widens what is measured.
const CUTS: [f64; 3] = [0.35, 0.5, 0.65];
/// A line is this much brighter than its ground, grey levels, and darker ground lies on both of its sides.
const CONTRAST: f64 = 40.0;
/// A line is at most this wide, over the pitch: what is wider is no line.
const WIDEST: f64 = 0.16;
/// Ties fewer than this fix no pose.
const FEWEST: usize = 24;
/// Ties farther off than so many times the typical one are left out.
const STRAY: f64 = 4.0;
/// Gauss-Newton steps, and rounds of leaving strays out.
const STEPS: usize = 6;
const ROUNDS: usize = 4;
/// Steps of the differences: turn, rad; shift, m.
const TURN_STEP: f64 = 1e-6;
const SHIFT_STEP: f64 = 1e-7;

/// The pose of a camera whose approximate pose is off by less than a third of a pitch on the plane.
///
/// None where too few segments of lines are seen.
pub fn find_pose(picture: &Gray, sight: &RefractiveCamera, grid: &Grid) -> Option<CameraPose> {
    let mut ties = View { picture, sight, grid }.segment_ties();
    let mut pose = sight.pose;
    for _ in 0..ROUNDS {
        if ties.len() < FEWEST {
            return None;
        }
        pose = refine_pose(&ties, &RefractiveCamera { pose, ..*sight }, grid.height)?;
        let now = RefractiveCamera { pose, ..*sight };
        let miss = |tie: &Tie| line_miss(&now, tie, grid.height).map_or(f64::INFINITY, f64::abs);
        let mut sizes: Vec<f64> = ties.iter().map(miss).collect();
        sizes.sort_by(f64::total_cmp);
        // The floor is a tenth of a micrometre: misses of an exactly drawn grid are rounding, of which many exceed four
        // times the median.
        let limit = STRAY * sizes[sizes.len() / 2].max(1e-7);
        let count_before = ties.len();
        ties.retain(|tie| miss(tie) <= limit);
        if ties.len() == count_before {
            break;
        }
    }
    let now = RefractiveCamera { pose, ..*sight };
    let squares: f64 = ties.iter().filter_map(|tie| line_miss(&now, tie, grid.height)).map(|miss| miss * miss).sum();
    Some(CameraPose { pose, segments: ties.len(), rms_error: (squares / ties.len() as f64).sqrt() })
}

/// A picture of a grid by a camera with an approximate pose.
#[derive(Clone, Copy)]
struct View<'a> {
    picture: &'a Gray,
    sight: &'a RefractiveCamera,
    grid: &'a Grid,
}

impl View<'_> {
    /// Middles of all segments that the picture shows.
    fn segment_ties(&self) -> Vec<Tie> {
        let Some([low, high]) = self.visible_lines() else { return Vec::new() };
        let mut ties = Vec::new();
        for axis in [0, 1] {
            let cross_axis = 1 - axis;
            for line in low[axis]..=high[axis] {
                for piece in low[cross_axis]..high[cross_axis] {
                    for cut in CUTS {
                        let mut point = [0.0; 2];
                        point[axis] = line as f64 * self.grid.pitch;
                        point[cross_axis] = (piece as f64 + cut) * self.grid.pitch;
                        let pixel = self.line_middle(point, axis);
                        ties.extend(pixel.map(|pixel| Tie { pixel, axis, at: point[axis] }));
                    }
                }
            }
        }
        ties
    }

    /// The least and greatest number of a line along each axis that the picture can show.
    fn visible_lines(&self) -> Option<[[i64; 2]; 2]> {
        let Self { picture, sight, grid } = *self;
        let (right, bottom) = (picture.width as f64 - 1.0, picture.height as f64 - 1.0);
        let corners = [[0.0, 0.0], [right, 0.0], [right, bottom], [0.0, bottom]];
        let corners_on_plane: Vec<Point2> =
            corners.iter().map(|c| sight.intersect(*c, grid.height)).collect::<Option<_>>()?;
        let end = |axis: usize, extreme: fn(f64, f64) -> f64, initial: f64| {
            corners_on_plane.iter().map(|p| p[axis]).fold(initial, extreme)
        };
        let low = [0, 1].map(|k| (end(k, f64::min, f64::INFINITY) / grid.pitch).ceil() as i64);
        let high = [0, 1].map(|k| (end(k, f64::max, f64::NEG_INFINITY) / grid.pitch).floor() as i64);
        Some([low, high])
    }

    /// The middle of the bright line across `segment`, px; none where there is no line alone.
    fn line_middle(&self, segment: Point2, axis: usize) -> Option<Point2> {
        let Self { picture, sight, grid } = *self;
        let offset_point = |part: f64| {
            let mut point = segment;
            point[axis] += part * REACH * grid.pitch;
            point
        };
        let ends =
            [pixel_of(sight, offset_point(-1.0), grid.height)?, pixel_of(sight, offset_point(1.0), grid.height)?];
        if ends.iter().any(|end| !picture.holds_with_margin(*end, 1.0)) {
            return None;
        }
        let count = 2 * SAMPLES + 1;
        let pixel_at = |i: f64| [0, 1].map(|k| ends[0][k] + (ends[1][k] - ends[0][k]) * i / (count - 1) as f64);
        let levels: Vec<f64> = (0..count).map(|i| picture.interpolated_level(pixel_at(i as f64))).collect();
        let sides =
            [&levels[..SAMPLES / 3], &levels[count - SAMPLES / 3..]].map(|s| s.iter().sum::<f64>() / s.len() as f64);
        let (ground, top) = (0.5 * (sides[0] + sides[1]), levels.iter().copied().fold(f64::MIN, f64::max));
        if top - ground < CONTRAST || (sides[0] - sides[1]).abs() > 0.25 * (top - ground) {
            return None;
        }
        // A quarter of the height is cut off: the noise of the ground on both sides, which has the longer arms, would
        // draw the centroid to the middle of the search.
        let weight = |level: &f64| (level - ground - 0.25 * (top - ground)).max(0.0);
        let sum: f64 = levels.iter().map(weight).sum();
        let mean = levels.iter().enumerate().map(|(i, l)| i as f64 * weight(l)).sum::<f64>() / sum;
        let spread = levels.iter().enumerate().map(|(i, l)| (i as f64 - mean).powi(2) * weight(l)).sum::<f64>() / sum;
        let width = (12.0 * spread).sqrt() / (count - 1) as f64 * 2.0 * REACH;
        (width <= WIDEST).then(|| pixel_at(mean))
    }
}

/// The pixel whose ray meets `at` on the plane: the air's pixel, moved until it does.
fn pixel_of(sight: &RefractiveCamera, at: Point2, height: Metre) -> Option<Point2> {
    let mut pixel = sight.lens.project(sight.pose.apply([at[0], at[1], height]))?;
    for _ in 0..4 {
        let (met, [[a, b], [c, d]]) = (sight.intersect(pixel, height)?, sight.by_pixel(pixel, height)?);
        let (x, y, whole) = (at[0] - met[0], at[1] - met[1], a * d - b * c);
        let step = [(d * x - b * y) / whole, (a * y - c * x) / whole];
        pixel = [pixel[0] + step[0], pixel[1] + step[1]];
        if step[0].hypot(step[1]) < 1e-3 {
            break;
        }
    }
    Some(pixel)
}

/// By how much a tie's ray misses its line, m.
fn line_miss(sight: &RefractiveCamera, tie: &Tie, height: Metre) -> Option<Metre> {
    sight.intersect(tie.pixel, height).map(|point| point[tie.axis] - tie.at)
}

/// Gauss-Newton over turn and shift.
fn refine_pose(ties: &[Tie], start: &RefractiveCamera, height: Metre) -> Option<Pose> {
    let mut pose = start.pose;
    for _ in 0..STEPS {
        let (mut normal, mut right) = (Matrix6::zeros(), Vector6::zeros());
        for tie in ties {
            let Some((miss, slope)) = miss_with_slope(tie, &RefractiveCamera { pose, ..*start }, height) else {
                continue;
            };
            normal += slope * slope.transpose();
            right -= slope * miss;
        }
        let step = normal.cholesky()?.solve(&right);
        pose = pose.rotated_and_shifted([step[0], step[1], step[2]], [step[3], step[4], step[5]]);
        if step.norm() < 1e-10 {
            break;
        }
    }
    Some(pose)
}

/// A tie's miss (m) and its slope by turn (rad) and shift (m), by central differences.
fn miss_with_slope(tie: &Tie, sight: &RefractiveCamera, height: Metre) -> Option<(Metre, Vector6<f64>)> {
    let perturbed_miss = |k: usize, change: f64| {
        let axis = |from: usize| std::array::from_fn(|i| if from + i == k { change } else { 0.0 });
        line_miss(&RefractiveCamera { pose: sight.pose.rotated_and_shifted(axis(0), axis(3)), ..*sight }, tie, height)
    };
    let mut slope = Vector6::zeros();
    for k in 0..6 {
        let step = if k < 3 { TURN_STEP } else { SHIFT_STEP };
        slope[k] = (perturbed_miss(k, step)? - perturbed_miss(k, -step)?) / (2.0 * step);
    }
    Some((line_miss(sight, tie, height)?, slope))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lens::Lens;
    use crate::refraction::Water;

    const GRID: Grid = Grid { pitch: 0.010, height: -0.045 };

    fn sight(water: bool) -> RefractiveCamera {
        let lens = Lens { k1: -0.11, k2: 0.03, p1: 4e-4, ..Lens::pinhole(980.0, 983.0, 646.0, 361.0) };
        let down = Pose {
            rotation: [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]],
            translation: [-0.058, 0.002, 0.205],
        };
        let water = water.then_some(Water { surface: 0.05, index: 1.333 });
        RefractiveCamera { lens, pose: down.rotated_and_shifted([0.02, -0.03, 0.01], [0.0; 3]), water }
    }

    /// A plate seen by that sight: lines 0.8 mm wide, a dark body on a part of it, uneven light.
    fn plate(sight: &RefractiveCamera) -> Gray {
        let line = |x: f64| ((x / 0.010).round() * 0.010 - x).abs() < 0.0004;
        let level = |pixel: Point2| match sight.intersect(pixel, GRID.height) {
            Some([x, y]) if (0.0..0.1).contains(&x) && y.abs() < 0.02 => 30.0,
            Some([x, y]) if line(x) || line(y) => 176.0,
            _ => 46.0,
        };
        let parts = [-0.375, -0.125, 0.125, 0.375];
        Gray::from_fn(1280, 720, |u, v| {
            let all = parts.iter().flat_map(|a| parts.map(|b| level([u as f64 + a, v as f64 + b])));
            all.sum::<f64>() / 16.0 * (1.0 - 1e-4 * u as f64)
        })
    }

    #[test]
    fn a_nudged_camera_is_found_by_the_lines_under_it_in_air_and_through_water() {
        for water in [false, true] {
            let truth = sight(water);
            let nudged = RefractiveCamera {
                pose: truth.pose.rotated_and_shifted([8e-4, -6e-4, 5e-4], [2e-4, -3e-4, 2e-4]),
                ..truth
            };
            let found = find_pose(&plate(&truth), &nudged, &GRID).unwrap();
            // what a height over the plane is seen at moves by less than a hundredth of a millimetre
            let off = |s: &RefractiveCamera, pixel: Point2| s.intersect(pixel, 0.01).unwrap();
            let now = RefractiveCamera { pose: found.pose, ..truth };
            for pixel in [[300.0, 200.0], [640.0, 360.0], [1000.0, 500.0]] {
                let (a, b, c) = (off(&now, pixel), off(&truth, pixel), off(&nudged, pixel));
                assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1.5e-5, "{water} {a:?} {b:?} {}", found.segments);
                assert!((c[0] - b[0]).hypot(c[1] - b[1]) > 5e-5);
            }
        }
    }

    #[test]
    fn a_plate_without_lines_tells_no_pose() {
        assert_eq!(find_pose(&Gray::filled(1280, 720, 46), &sight(false), &GRID), None);
    }
}
