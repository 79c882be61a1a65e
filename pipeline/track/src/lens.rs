//! The lens: how a ray becomes a pixel, after Brown and Conrady, and back.
//!
//! Stands on: `si`. Never knows: where the camera stands, a board.

use si::{Point2, Point3};

/// A camera's lens. Focal lengths and centre in px, distortion without unit; all zero but the first four is a pinhole.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Lens {
    /// Focal length along the rows, px.
    pub fx: f64,
    /// Focal length along the columns, px.
    pub fy: f64,
    /// Column of the optical axis, px.
    pub cx: f64,
    /// Row of the optical axis, px.
    pub cy: f64,
    /// Radial, with r².
    pub k1: f64,
    /// Radial, with r⁴.
    pub k2: f64,
    /// Tangential, first.
    pub p1: f64,
    /// Tangential, second.
    pub p2: f64,
    /// Radial, with r⁶.
    pub k3: f64,
}

/// Newton steps for a ray; five are enough where the lens does not fold, more only near its edge.
const NEWTON_STEPS: usize = 30;
/// A ray is found when its distorted place is met to this, no unit (1e-13 × 1500 px is far under any noise).
const RAY_TOLERANCE: f64 = 1e-13;

impl Lens {
    /// A lens without distortion.
    pub fn pinhole(fx: f64, fy: f64, cx: f64, cy: f64) -> Self {
        Self { fx, fy, cx, cy, ..Self::default() }
    }

    /// The pixel of a point in the camera's frame (m), px; none behind the camera or where the distortion has folded over.
    pub fn project(&self, [x, y, z]: Point3) -> Option<Point2> {
        let flat = [x / z, y / z];
        (z > 0.0 && self.unfolded(flat)).then(|| self.pixel(self.distort(flat)))
    }

    /// The undistorted ray [x/z, y/z] of a pixel, no unit; none where no ray of the lens reaches the pixel.
    ///
    /// Newton on the two equations of [`Lens::distort`].
    pub fn unproject(&self, pixel: Point2) -> Option<Point2> {
        let goal = [(pixel[0] - self.cx) / self.fx, (pixel[1] - self.cy) / self.fy];
        let mut ray = goal;
        for _ in 0..NEWTON_STEPS {
            let there = self.distort(ray);
            let miss = [goal[0] - there[0], goal[1] - there[1]];
            if miss[0].hypot(miss[1]) < RAY_TOLERANCE {
                return self.unfolded(ray).then_some(ray);
            }
            let step = solve(self.stretch(ray), miss)?;
            ray = [ray[0] + step[0], ray[1] + step[1]];
        }
        None
    }

    /// Distortion of a normalised place, no unit.
    ///
    /// x' = x (1 + k₁r² + k₂r⁴ + k₃r⁶) + 2p₁xy + p₂(r² + 2x²), y' alike with p₁ and p₂ exchanged    [brown1971]
    pub fn distort(&self, [x, y]: Point2) -> Point2 {
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3));
        [
            x * radial + 2.0 * self.p1 * x * y + self.p2 * (r2 + 2.0 * x * x),
            y * radial + self.p1 * (r2 + 2.0 * y * y) + 2.0 * self.p2 * x * y,
        ]
    }

    /// d(distorted)/d(normalised), 2 × 2, no unit.
    pub(crate) fn stretch(&self, [x, y]: Point2) -> [[f64; 2]; 2] {
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (self.k1 + r2 * (self.k2 + r2 * self.k3));
        let slope = 2.0 * (self.k1 + r2 * (2.0 * self.k2 + r2 * 3.0 * self.k3));
        let cross = slope * x * y + 2.0 * self.p1 * x + 2.0 * self.p2 * y;
        [
            [radial + slope * x * x + 2.0 * self.p1 * y + 6.0 * self.p2 * x, cross],
            [cross, radial + slope * y * y + 6.0 * self.p1 * y + 2.0 * self.p2 * x],
        ]
    }

    /// d(pixel)/d(point of the camera's frame), 2 × 3, px/m.
    pub(crate) fn slope(&self, [x, y, z]: Point3) -> [[f64; 3]; 2] {
        #[allow(non_snake_case)]
        let J = self.stretch([x / z, y / z]);
        let row = |f: f64, [a, b]: [f64; 2]| [f * a / z, f * b / z, -f * (a * x + b * y) / (z * z)];
        [row(self.fx, J[0]), row(self.fy, J[1])]
    }

    /// The pixel of a distorted normalised place.
    pub(crate) fn pixel(&self, [x, y]: Point2) -> Point2 {
        [self.fx * x + self.cx, self.fy * y + self.cy]
    }

    /// Whether rays still spread from the axis up to here: d(r · radial)/dr stays positive all the way.
    fn unfolded(&self, [x, y]: Point2) -> bool {
        let r2 = x * x + y * y;
        let rise = |q: f64| 1.0 + q * (3.0 * self.k1 + q * (5.0 * self.k2 + q * 7.0 * self.k3));
        (1..=FOLD_CHECKS).all(|i| rise(r2 * i as f64 / FOLD_CHECKS as f64) > 0.0)
    }
}

/// Places between the axis and a ray at which the spread is looked at: a cubic in r² cannot hide a fold between eight.
const FOLD_CHECKS: usize = 8;

/// x with A x = b, none when A is singular.
#[allow(non_snake_case)]
pub(crate) fn solve(A: [[f64; 2]; 2], b: Point2) -> Option<Point2> {
    let inverse = invert(A)?;
    Some(inverse.map(|row| row[0] * b[0] + row[1] * b[1]))
}

/// A⁻¹, none when A is singular.
pub(crate) fn invert([[a, b], [c, d]]: [[f64; 2]; 2]) -> Option<[[f64; 2]; 2]> {
    let det = a * d - b * c;
    (det.is_finite() && det != 0.0).then(|| [[d / det, -b / det], [-c / det, a / det]])
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENSES: [Lens; 2] = [
        Lens { fx: 1473.0, fy: 1478.0, cx: 969.0, cy: 541.0, k1: -0.03, k2: 0.01, p1: 2e-4, p2: -3e-4, k3: 1e-3 },
        Lens { fx: 1780.0, fy: 1780.0, cx: 960.0, cy: 540.0, k1: -0.255, k2: -0.07, p1: 1e-3, p2: 5e-4, k3: 0.3 },
    ];

    #[test]
    fn a_pixel_comes_back_through_its_ray() {
        for lens in LENSES {
            for pixel in [[0.0, 0.0], [1919.0, 1079.0], [960.0, 540.0], [30.0, 1000.0]] {
                let [x, y] = lens.unproject(pixel).unwrap();
                let back = lens.project([0.7 * x, 0.7 * y, 0.7]).unwrap();
                assert!((back[0] - pixel[0]).hypot(back[1] - pixel[1]) < 1e-9, "{pixel:?} → {back:?}");
            }
        }
    }

    #[test]
    fn the_slope_of_the_lens_is_its_difference() {
        let (lens, at, h) = (LENSES[1], [0.21, -0.13, 0.8], 1e-6);
        let slope = lens.slope(at);
        for k in 0..3 {
            let moved = |s: f64| {
                let mut p = at;
                p[k] += s;
                lens.project(p).unwrap()
            };
            for (i, row) in slope.iter().enumerate() {
                let difference = (moved(h)[i] - moved(-h)[i]) / (2.0 * h);
                assert!((row[k] - difference).abs() < 1e-5, "{i}{k}: {} {difference}", row[k]);
            }
        }
    }

    #[test]
    fn a_point_behind_the_camera_or_beyond_the_fold_has_no_pixel() {
        assert_eq!(LENSES[0].project([0.0, 0.0, -1.0]), None);
        let folding = Lens { k1: -0.3, ..Lens::pinhole(1000.0, 1000.0, 500.0, 500.0) };
        assert_eq!(folding.project([1.2, 0.0, 1.0]), None);
        assert_eq!(folding.unproject([500.0 + 1000.0, 500.0]), None);
    }
}
