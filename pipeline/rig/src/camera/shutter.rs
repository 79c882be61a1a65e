//! A rolling shutter: rows are read one after the other, and each shows the bench at its own time.
//!
//! A frame's time is that of its middle row. Between the frames around it a body is followed by a parabola in time, which
//! no row leaves by more than a tenth of a frame.
//!
//! Stands on: the camera, the water. Never knows: a lens, what is filmed.

use si::{Point2, Point3, Second};

use super::Camera;
use super::water::Water;

/// Rounds until a point's row and its time agree: each leaves a few hundredths of the last one's miss.
const ROUNDS: usize = 6;
/// Rows are agreed on to this, px.
const AGREED: f64 = 1e-6;

/// The camera in one recording: through air, or through the water of that recording.
#[derive(Debug, Clone)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// The water over the bench; none in air.
    pub water: Option<Water>,
}

/// Everything that moves, around one frame: nodes a step before, at and a step after its time.
#[derive(Debug, Clone)]
pub struct Passing {
    /// The frame's time, s.
    pub time: Second,
    /// s.
    pub step: Second,
    /// m, one list for each of the three times.
    pub nodes: [Vec<Point3>; 3],
}

impl Passing {
    /// The body whose nodes (m) at any time (s) are `nodes`, around the frame at `time`; `step` s parts the three.
    pub fn around(time: Second, step: Second, nodes: &dyn Fn(Second) -> Vec<Point3>) -> Self {
        Self { time, step, nodes: [-1.0, 0.0, 1.0].map(|k| nodes(time + k * step)) }
    }

    /// Nodes at the frame's time, m.
    pub fn now(&self) -> &[Point3] {
        &self.nodes[1]
    }

    /// Where a point is `late` s after the frame's time when it is at these three places at the three times.
    pub fn at(&self, [before, now, after]: [Point3; 3], late: Second) -> Point3 {
        let s = late / self.step;
        let bend = |k: usize| 0.5 * (before[k] + after[k]) - now[k];
        [0, 1, 2].map(|k| now[k] + s * (0.5 * (after[k] - before[k]) + s * bend(k)))
    }
}

impl View {
    /// The pixel of a point (m) at time `t` (s).
    pub fn pixel(&self, at: Point3, t: Second) -> Option<Point2> {
        match &self.water {
            Some(water) => self.camera.pixel(water.apparent(self.camera.eye(), at, t)),
            None => self.camera.pixel(at),
        }
    }

    /// The pixel of a point that passes these three places, at its own row's time.
    pub fn passing(&self, by: &Passing, places: [Point3; 3]) -> Option<Point2> {
        let mut pixel = self.pixel(places[1], by.time)?;
        for _ in 0..ROUNDS {
            let late = self.camera.late(pixel[1]);
            let next = self.pixel(by.at(places, late), by.time + late)?;
            let moved = (next[1] - pixel[1]).abs();
            pixel = next;
            if moved < AGREED {
                break;
            }
        }
        Some(pixel)
    }

    /// The same for a point of the skin, whose row is guessed from where it would be seen through air without distortion.
    ///
    /// The guess is off by tens of rows at most, some tenths of a millisecond; the water is looked through roughly.
    pub fn glimpse(&self, by: &Passing, places: [Point3; 3]) -> Option<(Point2, Point3)> {
        let [_, y, z] = self.camera.pose.apply(places[1]);
        let late = self.camera.late(self.camera.lens.cy + self.camera.lens.fy * y / z);
        let there = by.at(places, late);
        let seen = self.water.as_ref().map_or(there, |w| w.roughly(self.camera.eye(), there, by.time + late));
        self.camera.pixel(seen).map(|pixel| (pixel, there))
    }

    /// Where a still point is seen when nothing ripples, px.
    pub fn still(&self, at: Point3) -> Option<Point2> {
        let seen = self.water.as_ref().map_or(at, |w| w.flat().apparent(self.camera.eye(), at, 0.0));
        self.camera.pixel(seen)
    }

    /// The outline of a still polygon (m), px, point by point; none when a corner has no pixel.
    pub fn outline(&self, polygon: &[Point3]) -> Option<Vec<Point2>> {
        polygon.iter().map(|p| self.still(*p)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::Draw;
    use crate::settings::Settings;

    fn camera() -> Camera {
        Camera::drawn(&Settings::built_in().camera, &mut Draw::new(3, "camera"))
    }

    /// A point that swings fast enough to cross 90 rows in a read-out.
    fn swing(t: Second) -> Vec<Point3> {
        let turn = 25.0 * t;
        vec![[0.06 + 0.004 * turn.cos(), 0.03 * turn.sin(), 0.02]]
    }

    #[test]
    fn a_passing_point_is_drawn_where_it_is_at_the_time_of_its_row() {
        let camera = camera();
        let water = Water::still(0.05, 1.333).rippled(&Settings::built_in().water, &mut Draw::new(4, "ripples"));
        for view in [View { camera, water: None }, View { camera, water: Some(water) }] {
            let by = Passing::around(0.02, 1.0 / 60.0, &swing);
            let places = by.nodes.clone().map(|nodes| nodes[0]);
            let seen = view.passing(&by, places).unwrap();
            let late = camera.late(seen[1]);
            let there = view.pixel(by.at(places, late), by.time + late).unwrap();
            assert!((there[0] - seen[0]).hypot(there[1] - seen[1]) < 1e-4);
            let (roughly, _) = view.glimpse(&by, places).unwrap();
            assert!((roughly[0] - seen[0]).hypot(roughly[1] - seen[1]) < 2.0);
        }
    }

    #[test]
    fn a_parabola_follows_a_swing_of_4_hz_to_a_hundredth_of_a_millimetre_within_a_read_out() {
        let (by, most) = (Passing::around(0.02, 1.0 / 60.0, &swing), Settings::built_in().camera.readout / 2.0);
        let places = by.nodes.clone().map(|nodes| nodes[0]);
        for late in [-most, -0.5 * most, 0.5 * most, most] {
            let (found, there) = (by.at(places, late), swing(by.time + late)[0]);
            let off = (0..3).map(|k| (found[k] - there[k]).powi(2)).sum::<f64>().sqrt();
            // a third of s (1 − s²) of (ω h)³ / 3 × 30 mm at s = 0.18, and the swing is 30 mm where markers move 8
            assert!(off < 7e-5, "{off}");
        }
    }
}
