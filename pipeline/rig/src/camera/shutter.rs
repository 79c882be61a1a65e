//! A rolling shutter: rows are read one after the other, and each shows the scene at its own time.
//!
//! A frame's time is that of its middle row. Around it a moving point is interpolated by a parabola through its positions one frame before,
//! at, and one frame after that time.

use si::{Point2, Point3, Second};

use super::Camera;
use super::water::Water;

/// Fixed-point iterations between a point's row and its time; each reduces the error to a few per cent.
const ITERATIONS: usize = 6;
/// The iteration stops at this change of the row, px.
const TOLERANCE: f64 = 1e-6;

/// The camera in one recording, in air or above the water of that recording.
#[derive(Debug, Clone)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// The water; none in air.
    pub water: Option<Water>,
}

/// The motion around one frame: node positions one step before, at, and one step after its time.
#[derive(Debug, Clone)]
pub struct FrameMotion {
    /// The frame's time, s.
    pub time: Second,
    /// s.
    pub step: Second,
    /// m, one list for each of the three times.
    pub nodes: [Vec<Point3>; 3],
}

impl FrameMotion {
    /// Samples `nodes` (m, at any time in s) around the frame at `time`, `step` (s) apart.
    pub fn sample(time: Second, step: Second, nodes: &dyn Fn(Second) -> Vec<Point3>) -> Self {
        Self { time, step, nodes: [-1.0, 0.0, 1.0].map(|k| nodes(time + k * step)) }
    }

    /// Nodes at the frame's time, m.
    pub fn current_nodes(&self) -> &[Point3] {
        &self.nodes[1]
    }

    /// Position `delay` (s) after the frame's time of a point with the given positions at the three times.
    pub(crate) fn interpolate(&self, [before, now, after]: [Point3; 3], delay: Second) -> Point3 {
        let s = delay / self.step;
        let curvature = |k: usize| 0.5 * (before[k] + after[k]) - now[k];
        [0, 1, 2].map(|k| now[k] + s * (0.5 * (after[k] - before[k]) + s * curvature(k)))
    }
}

impl View {
    /// The pixel of a point (m) at time `t` (s).
    pub fn pixel(&self, point: Point3, t: Second) -> Option<Point2> {
        match &self.water {
            Some(water) => self.camera.pixel(water.apparent_point(self.camera.centre_of_projection(), point, t)),
            None => self.camera.pixel(point),
        }
    }

    /// The pixel of a moving point, given by its positions at the three times of `motion`, at the time of its own row.
    pub(crate) fn project_moving(&self, motion: &FrameMotion, places: [Point3; 3]) -> Option<Point2> {
        let mut pixel = self.pixel(places[1], motion.time)?;
        for _ in 0..ITERATIONS {
            let delay = self.camera.row_delay(pixel[1]);
            let next = self.pixel(motion.interpolate(places, delay), motion.time + delay)?;
            let row_change = (next[1] - pixel[1]).abs();
            pixel = next;
            if row_change < TOLERANCE {
                break;
            }
        }
        Some(pixel)
    }

    /// The same for a point of the skin, approximately, with the point's position. The row is that in air without distortion, which is
    /// wrong by tens of rows at most (some tenths of a millisecond), and the refraction is [`Water::apparent_approx`]: the skin has
    /// thousands of points a frame and no track is compared with it.
    pub(crate) fn project_skin(&self, motion: &FrameMotion, places: [Point3; 3]) -> Option<(Point2, Point3)> {
        let [_, y, z] = self.camera.pose.apply(places[1]);
        let delay = self.camera.row_delay(self.camera.lens.cy + self.camera.lens.fy * y / z);
        let position = motion.interpolate(places, delay);
        let apparent = self
            .water
            .as_ref()
            .map_or(position, |w| w.apparent_approx(self.camera.centre_of_projection(), position, motion.time + delay));
        self.camera.pixel(apparent).map(|pixel| (pixel, position))
    }

    /// The pixel of a fixed point without ripples.
    pub(crate) fn project_static(&self, at: Point3) -> Option<Point2> {
        let apparent = self
            .water
            .as_ref()
            .map_or(at, |w| w.without_ripples().apparent_point(self.camera.centre_of_projection(), at, 0.0));
        self.camera.pixel(apparent)
    }

    /// The outline of a fixed polygon (m), px; none if a corner has no pixel.
    pub fn outline(&self, polygon: &[Point3]) -> Option<Vec<Point2>> {
        polygon.iter().map(|p| self.project_static(*p)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::RandomStream;
    use crate::settings::Settings;

    fn camera() -> Camera {
        Camera::draw_camera(&Settings::built_in().camera, &mut RandomStream::new(3, "camera"))
    }

    /// A point that moves fast enough to cross 90 rows during one readout.
    fn oscillation(t: Second) -> Vec<Point3> {
        let turn = 25.0 * t;
        vec![[0.06 + 0.004 * turn.cos(), 0.03 * turn.sin(), 0.02]]
    }

    #[test]
    fn a_moving_point_is_projected_at_its_position_at_the_time_of_its_row() {
        let camera = camera();
        let water =
            Water::at_rest(0.05, 1.333).rippled(&Settings::built_in().water, &mut RandomStream::new(4, "ripples"));
        for view in [View { camera, water: None }, View { camera, water: Some(water) }] {
            let motion = FrameMotion::sample(0.02, 1.0 / 60.0, &oscillation);
            let places = motion.nodes.clone().map(|nodes| nodes[0]);
            let pixel = view.project_moving(&motion, places).unwrap();
            let delay = camera.row_delay(pixel[1]);
            let there = view.pixel(motion.interpolate(places, delay), motion.time + delay).unwrap();
            assert!((there[0] - pixel[0]).hypot(there[1] - pixel[1]) < 1e-4);
            let (approx, _) = view.project_skin(&motion, places).unwrap();
            assert!((approx[0] - pixel[0]).hypot(approx[1] - pixel[1]) < 2.0);
        }
    }

    #[test]
    fn a_parabola_interpolates_an_oscillation_of_4_hz_to_70_micrometres_within_a_readout() {
        let (motion, most) =
            (FrameMotion::sample(0.02, 1.0 / 60.0, &oscillation), Settings::built_in().camera.readout / 2.0);
        let places = motion.nodes.clone().map(|nodes| nodes[0]);
        for delay in [-most, -0.5 * most, 0.5 * most, most] {
            let (found, there) = (motion.interpolate(places, delay), oscillation(motion.time + delay)[0]);
            let off = (0..3).map(|k| (found[k] - there[k]).powi(2)).sum::<f64>().sqrt();
            // a third of s (1 − s²) of (ω h)³ / 3 × 30 mm at s = 0.18 for an amplitude of 30 mm
            assert!(off < 7e-5, "{off}");
        }
    }
}
