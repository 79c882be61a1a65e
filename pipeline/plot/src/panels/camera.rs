//! Cameras: orthographic projection from space onto the page.

use si::vec3::{cross, dot, norm, scale};
use si::{Point2, Point3};

use crate::canvas::Area;

/// The direction of view, and which direction is up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// From the eye into the scene.
    pub direction: Point3,
    /// The direction that is vertical on the page, after projection.
    pub up: Point3,
}

impl View {
    /// From above, x to the right and y upwards.
    pub const TOP: Self = Self { direction: [0.0, 0.0, -1.0], up: [0.0, 1.0, 0.0] };
    /// From the side, x to the right and z upwards.
    pub const SIDE: Self = Self { direction: [0.0, 1.0, 0.0], up: [0.0, 0.0, 1.0] };
    /// Oblique, from above.
    pub const CORNER: Self = Self { direction: [-0.45, 0.75, -0.5], up: [0.0, 0.0, 1.0] };

    /// Unit vectors to the right, upwards and away from the eye.
    pub(crate) fn basis(&self) -> [Point3; 3] {
        let unit = |v: Point3| scale(v, 1.0 / norm(v));
        let away = unit(self.direction);
        let right = unit(cross(away, self.up));
        [right, cross(right, away), away]
    }
}

/// The projection from space onto the page.
pub(crate) struct Camera {
    /// Unit vectors to the right, upwards and away from the eye.
    pub basis: [Point3; 3],
    /// Points of print in a metre.
    pub zoom: f64,
    middle: Point2,
    centre: Point2,
    /// The rectangle of the page that it fills.
    pub area: Area,
}

impl Camera {
    /// A camera that shows a rectangle of the plane of view (m) as large as a rectangle of the page allows.
    pub fn new(view: &View, [low, high]: [Point2; 2], area: Area) -> Self {
        let [wide, tall] = [high[0] - low[0], high[1] - low[1]];
        let zoom = (area.width() / wide).min(area.height() / tall);
        let middle = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])];
        Self { basis: view.basis(), zoom, middle, centre: area.centre(), area }
    }

    /// Place on the page.
    pub(crate) fn page_place(&self, p: Point3) -> Point2 {
        let [right, up, _] = self.basis;
        [
            self.centre[0] + self.zoom * (dot(p, right) - self.middle[0]),
            self.centre[1] - self.zoom * (dot(p, up) - self.middle[1]),
        ]
    }

    /// Place and depth in the picture, in points of print.
    pub(crate) fn pixel_place(&self, p: Point3) -> Point3 {
        let [x, y] = self.page_place(p);
        [x - self.area.from[0], y - self.area.from[1], self.zoom * dot(p, self.basis[2])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn from_above_x_runs_to_the_right_and_y_upwards() {
        assert_eq!(View::TOP.basis(), [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]]);
        assert_eq!(View::SIDE.basis()[..2], [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    }

    #[test]
    fn what_is_higher_is_nearer_when_seen_from_above() {
        let area = Area { from: [0.0; 2], to: [100.0, 50.0] };
        let camera = Camera::new(&View::TOP, [[0.0, 0.0], [0.1, 0.1]], area);
        let ([x, y, low], [_, _, high]) = (camera.pixel_place([0.05, 0.1, 0.0]), camera.pixel_place([0.05, 0.1, 0.02]));
        assert!((x - 50.0).abs() < 1e-9 && y.abs() < 1e-9 && high < low);
    }
}
