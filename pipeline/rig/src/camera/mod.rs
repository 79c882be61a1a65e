//! The bench's camera: its true lens and pose, its rolling shutter, and the projection of points and outlines.

mod shutter;
mod water;

pub use shutter::{FrameMotion, View};
pub use water::Water;

use si::{Metre, Point2, Point3, Second, vec3};
use track::lens::Lens;
use track::pose::Pose;

use crate::random::RandomStream;
use crate::settings;

/// A camera in the CAD frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Its true lens.
    pub lens: Lens,
    /// Its pose: CAD frame → camera frame.
    pub pose: Pose,
    /// px.
    pub width: usize,
    /// px.
    pub height: usize,
    /// From the first row's time to the last one's, s.
    pub readout: Second,
}

impl Camera {
    /// The camera of the settings, with focal length, lens and pose drawn near their nominal values.
    pub(crate) fn draw_camera(set: &settings::Camera, random: &mut RandomStream) -> Self {
        let fx = random.uniform(set.focal);
        let drawn_near = |random: &mut RandomStream, value: f64, spread: f64| value + random.uniform([-spread, spread]);
        let lens = Lens {
            fx,
            fy: fx * set.aspect,
            cx: drawn_near(random, set.centre[0], 3.0),
            cy: drawn_near(random, set.centre[1], 3.0),
            k1: drawn_near(random, set.radial[0], 0.005),
            k2: drawn_near(random, set.radial[1], 0.002),
            p1: drawn_near(random, set.tangential[0], 1e-4),
            p2: drawn_near(random, set.tangential[1], 1e-4),
            k3: set.radial[2],
            ..Lens::default()
        };
        let position = set.above.map(|x| drawn_near(random, x, 0.001));
        let tilt = set.tilt.map(|angle| drawn_near(random, angle, 0.3).to_radians());
        Self { lens, pose: pose_at(position, tilt), width: set.width, height: set.height, readout: set.readout }
    }

    /// The same camera with a small random translation and rotation: starting a recording by hand moves it.
    pub fn perturbed_camera(&self, perturbation: &settings::PosePerturbation, random: &mut RandomStream) -> Self {
        let mut within = |limit: f64| [(); 3].map(|()| random.uniform([-limit, limit]));
        let (shift, turn) = (within(perturbation.shift), within(perturbation.turn.to_radians()));
        let turn = Pose::from_vector(turn, shift);
        let rows = self.pose.rotation;
        let column = |j: usize| turn.apply(rows.map(|row| row[j]));
        let columns = [0, 1, 2].map(|j| vec3::sub(column(j), shift));
        let rotation = [0, 1, 2].map(|i| columns.map(|column| column[i]));
        Self { pose: Pose { rotation, translation: turn.apply(self.pose.translation) }, ..*self }
    }

    /// The pixel of a point in space (m, CAD frame); none outside the lens model.
    pub fn pixel(&self, point: Point3) -> Option<Point2> {
        self.lens.project(self.pose.apply(point))
    }

    /// Delay of row `v` (px) after the frame's time, which is the middle row's, s.
    pub(crate) fn row_delay(&self, v: f64) -> Second {
        let last = self.height as f64 - 1.0;
        self.readout * (v.clamp(0.0, last) / last - 0.5)
    }

    /// Its centre of projection, m, CAD frame.
    pub(crate) fn centre_of_projection(&self) -> Point3 {
        self.pose.centre()
    }

    /// Depth of a point (m, CAD frame) in front of the camera, m.
    pub(crate) fn depth_of_point(&self, point: Point3) -> Metre {
        self.pose.apply(point)[2]
    }

    /// The outline of a polygon in space (m), px; none if a corner has no pixel.
    pub fn outline(&self, polygon: &[Point3]) -> Option<Vec<Point2>> {
        polygon.iter().map(|p| self.pixel(*p)).collect()
    }
}

/// A camera at `position` (m) that looks along −z with the image axis right along +x, then rotated by `tilt` (rad) about the image axes
/// right, down and view.
fn pose_at(position: Point3, tilt: Point3) -> Pose {
    let upright = Pose { rotation: [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]], translation: [0.0; 3] };
    let turn = Pose::from_vector(tilt, [0.0; 3]);
    let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| turn.apply(upright.apply(axis)));
    let rotation = [0, 1, 2].map(|i| columns.map(|column| column[i]));
    let translation = vec3::scale(rotation.map(|row| vec3::dot(row, position)), -1.0);
    Pose { rotation, translation }
}

/// A horizontal disc of `radius` (m) around `centre` (m) as a polygon of `corners` corners.
pub(crate) fn flat_disc(centre: Point3, radius: Metre, corners: usize) -> Vec<Point3> {
    let angle = |i: usize| std::f64::consts::TAU * i as f64 / corners as f64;
    let corner = |i: usize| vec3::add(centre, [radius * angle(i).cos(), radius * angle(i).sin(), 0.0]);
    (0..corners).map(corner).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;

    #[test]
    fn a_perturbed_camera_stays_within_the_limits_of_translation_and_rotation() {
        let camera = Camera::draw_camera(&Settings::built_in().camera, &mut RandomStream::new(3, "camera"));
        let by = settings::PosePerturbation { shift: 3e-4, turn: 0.05 };
        let perturbed = camera.perturbed_camera(&by, &mut RandomStream::new(3, "nudge"));
        // a rotation about the centre of projection does not move it
        let (was, is) = (camera.pose.centre(), perturbed.pose.centre());
        let moved = vec3::norm(vec3::sub(is, was));
        assert!(moved > 0.0 && moved <= 3e-4 * 3f64.sqrt() + 1e-12, "{moved}");
        let axes = |c: &Camera| c.pose.rotation;
        for (a, b) in axes(&camera).iter().zip(axes(&perturbed)) {
            assert!(vec3::norm(vec3::sub(*a, b)) < 0.05f64.to_radians() * 3f64.sqrt());
            assert!((vec3::norm(b) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_camera_is_at_its_position_and_sees_x_to_the_right_and_y_upwards() {
        let camera = Camera::draw_camera(&Settings::built_in().camera, &mut RandomStream::new(3, "camera"));
        let [x, y, z] = camera.pose.centre();
        assert!((x - 0.058).abs() < 0.0011 && (y - 0.002).abs() < 0.0011 && (z - 0.205).abs() < 0.0011);
        let at = |p| camera.pixel(p).unwrap();
        let (middle, right, left_side) = (at([0.05, 0.0, 0.0]), at([0.06, 0.0, 0.0]), at([0.05, 0.01, 0.0]));
        assert!(right[0] - middle[0] > 40.0 && middle[1] - left_side[1] > 40.0);
    }
}
