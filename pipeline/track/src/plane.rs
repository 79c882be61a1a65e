//! A plane of known height: where the ray of a pixel meets it, and how far a pixel's error carries.
//!
//! Stands on: the lens and the pose. Never knows: what lies in the plane. Paper: section IV.

use crate::lens::{Lens, invert};
use crate::pose::Pose;
use si::{Metre, Point2};

/// Where the ray of `pixel` (px) meets the plane z = `height` (m) of the world: [x, y], m.
///
/// None where the lens has no ray, or the ray runs along the plane or away from it.
pub fn meet(lens: &Lens, pose: &Pose, pixel: Point2, height: Metre) -> Option<Point2> {
    let [u, v] = lens.unproject(pixel)?;
    let from = pose.centre();
    let along = pose.undo_direction([u, v, 1.0]);
    let far = (height - from[2]) / along[2];
    (far.is_finite() && far > 0.0).then(|| [from[0] + far * along[0], from[1] + far * along[1]])
}

/// d(world)/d(pixel) of [`meet`], 2 × 2, m/px: rows x and y of the world, columns x and y of the picture.
///
/// The inverse of d(pixel)/d(world) = d(pixel)/d(camera) · R, its two columns of the plane.
pub fn sensitivity(lens: &Lens, pose: &Pose, pixel: Point2, height: Metre) -> Option<[[f64; 2]; 2]> {
    let [x, y] = meet(lens, pose, pixel, height)?;
    let slope = lens.slope(pose.apply([x, y, height]));
    let column = |i: usize, j: usize| (0..3).map(|k| slope[i][k] * pose.rotation[k][j]).sum();
    invert([0, 1].map(|i| [0, 1].map(|j| column(i, j))))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENS: Lens =
        Lens { fx: 1473.0, fy: 1478.0, cx: 969.0, cy: 541.0, k1: -0.05, k2: 0.02, p1: 2e-4, p2: -3e-4, k3: 0.0 };

    fn above() -> Pose {
        Pose::from_vector([std::f64::consts::PI - 0.2, 0.1, 0.05], [-0.05, 0.02, 0.6])
    }

    #[test]
    fn a_point_of_the_plane_is_met_again() {
        for height in [0.0, 0.03] {
            let [x, y] = [0.08, -0.04];
            let pixel = LENS.project(above().apply([x, y, height])).unwrap();
            let met = meet(&LENS, &above(), pixel, height).unwrap();
            assert!((met[0] - x).hypot(met[1] - y) < 1e-12, "{met:?}");
        }
    }

    #[test]
    fn the_sensitivity_is_the_difference_of_meeting() {
        let (pixel, h) = ([700.0, 300.0], 1e-3);
        let slope = sensitivity(&LENS, &above(), pixel, 0.02).unwrap();
        for j in 0..2 {
            let moved = |s: f64| {
                let mut p = pixel;
                p[j] += s;
                meet(&LENS, &above(), p, 0.02).unwrap()
            };
            for (i, row) in slope.iter().enumerate() {
                let difference = (moved(h)[i] - moved(-h)[i]) / (2.0 * h);
                assert!((row[j] - difference).abs() < 1e-11);
            }
        }
    }

    #[test]
    fn a_plane_behind_the_camera_is_not_met() {
        assert_eq!(meet(&LENS, &above(), [700.0, 300.0], 5.0), None);
    }
}
