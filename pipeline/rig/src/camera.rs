//! The bench's camera: its true lens, where it hangs, how it reads its rows, and the outline of anything in its picture.
//!
//! Stands on: `track` (lens and pose). Never knows: what is filmed.

mod shutter;
mod water;

pub use shutter::{Passing, View};
pub use water::Water;

use si::{Metre, Point2, Point3, Second, vec3};
use track::lens::Lens;
use track::pose::Pose;

use crate::draw::Draw;
use crate::settings;

/// A camera in the CAD frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Its true lens.
    pub lens: Lens,
    /// Where it hangs: CAD frame → camera frame.
    pub pose: Pose,
    /// px.
    pub width: usize,
    /// px.
    pub height: usize,
    /// From the first row's time to the last one's, s.
    pub readout: Second,
}

impl Camera {
    /// The camera of the settings, its focal length and its hanging drawn a little off their nominal values.
    pub fn drawn(set: &settings::Camera, draw: &mut Draw) -> Self {
        let fx = draw.between(set.focal);
        let near = |draw: &mut Draw, value: f64, spread: f64| value + draw.between([-spread, spread]);
        let lens = Lens {
            fx,
            fy: fx * set.aspect,
            cx: near(draw, set.centre[0], 3.0),
            cy: near(draw, set.centre[1], 3.0),
            k1: near(draw, set.radial[0], 0.005),
            k2: near(draw, set.radial[1], 0.002),
            p1: near(draw, set.tangential[0], 1e-4),
            p2: near(draw, set.tangential[1], 1e-4),
            k3: set.radial[2],
            ..Lens::default()
        };
        let above = set.above.map(|x| near(draw, x, 0.001));
        let tilt = set.tilt.map(|angle| near(draw, angle, 0.3).to_radians());
        Self { lens, pose: hang(above, tilt), width: set.width, height: set.height, readout: set.readout }
    }

    /// The same camera after a hand has started it: shifted and turned a little.
    pub fn nudged(&self, by: &settings::Nudge, draw: &mut Draw) -> Self {
        let mut within = |most: f64| [(); 3].map(|()| draw.between([-most, most]));
        let (shift, turn) = (within(by.shift), within(by.turn.to_radians()));
        let turn = Pose::from_vector(turn, shift);
        let rows = self.pose.rotation;
        let column = |j: usize| turn.apply(rows.map(|row| row[j]));
        let columns = [0, 1, 2].map(|j| vec3::sub(column(j), shift));
        let rotation = [0, 1, 2].map(|i| columns.map(|column| column[i]));
        Self { pose: Pose { rotation, translation: turn.apply(self.pose.translation) }, ..*self }
    }

    /// The pixel of a point in space (m, CAD frame), where the camera sees it.
    pub fn pixel(&self, at: Point3) -> Option<Point2> {
        self.lens.project(self.pose.apply(at))
    }

    /// How much later than the frame's time, which is the middle row's, row `v` (px) is read, s.
    pub fn late(&self, v: f64) -> Second {
        let last = self.height as f64 - 1.0;
        self.readout * (v.clamp(0.0, last) / last - 0.5)
    }

    /// Where its pinhole is, m, CAD frame.
    pub fn eye(&self) -> Point3 {
        self.pose.centre()
    }

    /// How far in front of the camera a point (m, CAD frame) lies, m.
    pub fn depth(&self, at: Point3) -> Metre {
        self.pose.apply(at)[2]
    }

    /// The outline of a polygon in space (m), px, point by point; none when a corner has no pixel.
    pub fn outline(&self, polygon: &[Point3]) -> Option<Vec<Point2>> {
        polygon.iter().map(|p| self.pixel(*p)).collect()
    }
}

/// A camera at `above` (m) that looks down −z with the picture's right along +x, then turned by `tilt` (rad) about the
/// picture's right, down and view.
fn hang(above: Point3, tilt: Point3) -> Pose {
    let down = Pose { rotation: [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]], translation: [0.0; 3] };
    let turn = Pose::from_vector(tilt, [0.0; 3]);
    let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| turn.apply(down.apply(axis)));
    let rotation = [0, 1, 2].map(|i| columns.map(|column| column[i]));
    let translation = vec3::scale(rotation.map(|row| vec3::dot(row, above)), -1.0);
    Pose { rotation, translation }
}

/// Corners of a disc of `radius` (m) around `centre` (m) that lies flat in z, `corners` of them.
pub fn flat_disc(centre: Point3, radius: Metre, corners: usize) -> Vec<Point3> {
    let angle = |i: usize| std::f64::consts::TAU * i as f64 / corners as f64;
    let corner = |i: usize| vec3::add(centre, [radius * angle(i).cos(), radius * angle(i).sin(), 0.0]);
    (0..corners).map(corner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;

    #[test]
    fn a_nudged_camera_stands_and_looks_within_what_a_hand_may_do() {
        let camera = Camera::drawn(&Settings::built_in().camera, &mut Draw::new(3, "camera"));
        let by = settings::Nudge { shift: 3e-4, turn: 0.05 };
        let nudged = camera.nudged(&by, &mut Draw::new(3, "nudge"));
        // a turn about the pinhole leaves it where it is
        let (was, is) = (camera.pose.centre(), nudged.pose.centre());
        let moved = vec3::norm(vec3::sub(is, was));
        assert!(moved > 0.0 && moved <= 3e-4 * 3f64.sqrt() + 1e-12, "{moved}");
        let axes = |c: &Camera| c.pose.rotation;
        for (a, b) in axes(&camera).iter().zip(axes(&nudged)) {
            assert!(vec3::norm(vec3::sub(*a, b)) < 0.05f64.to_radians() * 3f64.sqrt());
            assert!((vec3::norm(b) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_camera_hangs_where_it_is_put_and_sees_x_to_the_right_and_y_upwards() {
        let camera = Camera::drawn(&Settings::built_in().camera, &mut Draw::new(3, "camera"));
        let [x, y, z] = camera.pose.centre();
        assert!((x - 0.058).abs() < 0.0011 && (y - 0.002).abs() < 0.0011 && (z - 0.205).abs() < 0.0011);
        let at = |p| camera.pixel(p).unwrap();
        let (middle, right, left_side) = (at([0.05, 0.0, 0.0]), at([0.06, 0.0, 0.0]), at([0.05, 0.01, 0.0]));
        assert!(right[0] - middle[0] > 40.0 && middle[1] - left_side[1] > 40.0);
    }
}
