//! The lens: projection of a ray to a pixel and back, with one of two distortion models.

mod brown;
mod fisheye;
pub mod opencv;

use si::{Point2, Point3};

/// How a lens coefficients rays away from its axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Distortion {
    /// Radial k1 k2 k3 and tangential p1 p2 \[brown1971\]; k4 is unused.
    #[default]
    BrownConrady,
    /// Equidistant with k1 to k4 in the angle from the axis \[kannala2006\]; p1 and p2 are unused.
    Fisheye,
}

/// A camera's lens. Focal lengths and centre in px, distortion without unit; all zero but the first four is a pinhole
/// or an ideal fisheye.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Lens {
    /// Which of the two ways.
    pub distortion: Distortion,
    /// Focal length along the rows, px.
    pub fx: f64,
    /// Focal length along the columns, px.
    pub fy: f64,
    /// Column of the optical axis, px.
    pub cx: f64,
    /// Row of the optical axis, px.
    pub cy: f64,
    /// Radial, with r² (or the angle's square).
    pub k1: f64,
    /// Radial, with r⁴.
    pub k2: f64,
    /// Tangential, first.
    pub p1: f64,
    /// Tangential, second.
    pub p2: f64,
    /// Radial, with r⁶.
    pub k3: f64,
    /// Radial, with the angle's eighth power; of a fisheye alone.
    pub k4: f64,
}

/// Numbers of a lens: four of the pinhole and five of the distortion.
pub const VALUES: usize = 9;

/// Newton steps for a ray; five are enough where the lens does not fold, more only near its edge.
const NEWTON_STEPS: usize = 30;
/// A ray is found when its distorted place is met to this, no unit (1e-13 × 1500 px is far under any noise).
const RAY_TOLERANCE: f64 = 1e-13;

impl Lens {
    /// A lens without distortion.
    pub(crate) fn pinhole(fx: f64, fy: f64, cx: f64, cy: f64) -> Self {
        Self { fx, fy, cx, cy, ..Self::default() }
    }

    /// The pixel of a point in the camera's frame (m), px; none behind the camera or where the distortion has folded over.
    pub fn project(&self, [x, y, z]: Point3) -> Option<Point2> {
        let flat = [x / z, y / z];
        (z > 0.0 && self.is_invertible(flat)).then(|| self.pixel_at(self.distort(flat)))
    }

    /// The part of a picture of `size` (px) in which points of the camera's frame (m) lie: left, top, right, bottom, px.
    pub fn window(&self, points: impl IntoIterator<Item = Point3>, size: [usize; 2]) -> [usize; 4] {
        let pixels: Vec<Point2> = points.into_iter().filter_map(|p| self.project(p)).collect();
        let ends = |k: usize| {
            let low = pixels.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min).max(0.0);
            let high = pixels.iter().map(|p| p[k]).fold(0.0, f64::max).min(size[k] as f64);
            [low.min(high) as usize, high as usize]
        };
        let ([left, right], [top, bottom]) = (ends(0), ends(1));
        [left, top, right, bottom]
    }

    /// The undistorted ray [x/z, y/z] of a pixel, no unit; none where no ray of the lens reaches the pixel.
    ///
    /// Newton on the two equations of [`Lens::distort`].
    pub(crate) fn unproject(&self, pixel: Point2) -> Option<Point2> {
        let goal = [(pixel[0] - self.cx) / self.fx, (pixel[1] - self.cy) / self.fy];
        let mut ray = match self.distortion {
            Distortion::BrownConrady => goal,
            Distortion::Fisheye => fisheye::initial_ray(goal),
        };
        for _ in 0..NEWTON_STEPS {
            let distorted = self.distort(ray);
            let miss = [goal[0] - distorted[0], goal[1] - distorted[1]];
            if miss[0].hypot(miss[1]) < RAY_TOLERANCE {
                // Beyond the fold of a distortion a second ray has the same pixel, and Newton's method may end there.
                return self.is_invertible(ray).then_some(ray);
            }
            let step = solve(self.distortion_jacobian(ray), miss)?;
            ray = [ray[0] + step[0], ray[1] + step[1]];
        }
        None
    }

    /// Distortion of a normalised place, no unit: see the two ways.
    pub(crate) fn distort(&self, place: Point2) -> Point2 {
        match self.distortion {
            Distortion::BrownConrady => brown::distort(&self.coefficients(), place),
            Distortion::Fisheye => fisheye::distort(&self.coefficients(), place),
        }
    }

    /// d(distorted)/d(normalised), 2 × 2, no unit.
    pub(crate) fn distortion_jacobian(&self, place: Point2) -> [[f64; 2]; 2] {
        match self.distortion {
            Distortion::BrownConrady => brown::distortion_jacobian(&self.coefficients(), place),
            Distortion::Fisheye => fisheye::distortion_jacobian(&self.coefficients(), place),
        }
    }

    /// d(distorted)/d(the five numbers of the distortion), 2 × 5, no unit.
    pub(crate) fn by_coefficients(&self, place: Point2) -> [[f64; 5]; 2] {
        match self.distortion {
            Distortion::BrownConrady => brown::by_coefficients(place),
            Distortion::Fisheye => fisheye::by_coefficients(place),
        }
    }

    /// The numbers of the distortion in its own order: k₁ k₂ p₁ p₂ k₃, or k₁ k₂ k₃ k₄ and nothing.
    fn coefficients(&self) -> [f64; 5] {
        match self.distortion {
            Distortion::BrownConrady => [self.k1, self.k2, self.p1, self.p2, self.k3],
            Distortion::Fisheye => [self.k1, self.k2, self.k3, self.k4, 0.0],
        }
    }

    /// Its numbers: fx fy cx cy, then those of the distortion.
    pub fn values(&self) -> [f64; VALUES] {
        let [a, b, c, d, e] = self.coefficients();
        [self.fx, self.fy, self.cx, self.cy, a, b, c, d, e]
    }

    /// The same kind of lens with other numbers.
    pub fn with_values(&self, [fx, fy, cx, cy, a, b, c, d, e]: [f64; VALUES]) -> Self {
        let new = Self { distortion: self.distortion, fx, fy, cx, cy, k1: a, k2: b, ..Self::default() };
        match self.distortion {
            Distortion::BrownConrady => Self { p1: c, p2: d, k3: e, ..new },
            Distortion::Fisheye => Self { k3: c, k4: d, ..new },
        }
    }

    /// How many of [`Lens::values`] count.
    pub fn count(&self) -> usize {
        match self.distortion {
            Distortion::BrownConrady => VALUES,
            Distortion::Fisheye => VALUES - 1,
        }
    }

    /// d(pixel)/d(point of the camera's frame), 2 × 3, px/m.
    pub(crate) fn jacobian(&self, [x, y, z]: Point3) -> [[f64; 3]; 2] {
        #[allow(non_snake_case)]
        let J = self.distortion_jacobian([x / z, y / z]);
        let row = |f: f64, [a, b]: [f64; 2]| [f * a / z, f * b / z, -f * (a * x + b * y) / (z * z)];
        [row(self.fx, J[0]), row(self.fy, J[1])]
    }

    /// The pixel of a distorted normalised place.
    pub(crate) fn pixel_at(&self, [x, y]: Point2) -> Point2 {
        [self.fx * x + self.cx, self.fy * y + self.cy]
    }

    /// Whether rays still spread from the axis up to here, all the way.
    fn is_invertible(&self, [x, y]: Point2) -> bool {
        let r2 = x * x + y * y;
        let rise = |share: f64| match self.distortion {
            Distortion::BrownConrady => brown::rise(&self.coefficients(), r2 * share),
            Distortion::Fisheye => fisheye::rise(&self.coefficients(), r2 * share),
        };
        (1..=FOLD_CHECKS).all(|i| rise(i as f64 / FOLD_CHECKS as f64) > 0.0)
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

    fn lenses() -> [Lens; 3] {
        let plain = Lens::default();
        let fisheye = Lens { distortion: Distortion::Fisheye, ..plain };
        [
            plain.with_values([1473.0, 1478.0, 969.0, 541.0, -0.03, 0.01, 2e-4, -3e-4, 1e-3]),
            plain.with_values([1780.0, 1780.0, 960.0, 540.0, -0.255, -0.07, 1e-3, 5e-4, 0.3]),
            fisheye.with_values([880.0, 882.0, 961.0, 538.0, 0.05, -0.02, 4e-3, -1e-3, 0.0]),
        ]
    }

    #[test]
    fn the_window_of_points_is_the_least_that_holds_them_within_the_picture() {
        let lens = Lens::pinhole(500.0, 500.0, 320.0, 180.0);
        let points = [[0.1, -0.05, 1.0], [0.2, 0.0, 0.5], [0.0, 0.1, -1.0]];
        assert_eq!(lens.window(points, [640, 360]), [370, 155, 520, 180]);
        assert_eq!(lens.window(points, [400, 360]), [370, 155, 400, 180]);
    }

    #[test]
    fn a_pixel_comes_back_through_its_ray() {
        for lens in lenses() {
            for pixel in [[0.0, 0.0], [1919.0, 1079.0], [960.0, 540.0], [30.0, 1000.0]] {
                let [x, y] = lens.unproject(pixel).unwrap();
                let back = lens.project([0.7 * x, 0.7 * y, 0.7]).unwrap();
                assert!((back[0] - pixel[0]).hypot(back[1] - pixel[1]) < 1e-9, "{pixel:?} → {back:?}");
            }
        }
    }

    #[test]
    fn the_slope_of_the_lens_is_its_difference() {
        let (at, h) = ([0.21, -0.13, 0.8], 1e-6);
        for lens in lenses() {
            let jacobian = lens.jacobian(at);
            for k in 0..3 {
                let moved = |s: f64| {
                    let mut p = at;
                    p[k] += s;
                    lens.project(p).unwrap()
                };
                for (i, row) in jacobian.iter().enumerate() {
                    let difference = (moved(h)[i] - moved(-h)[i]) / (2.0 * h);
                    assert!((row[k] - difference).abs() < 1e-5, "{i}{k}: {} {difference}", row[k]);
                }
            }
        }
    }

    #[test]
    fn the_slope_by_the_bends_is_its_difference_for_either_kind() {
        let (place, h) = ([0.4, -0.3], 1e-6);
        for lens in lenses() {
            let jacobian = lens.by_coefficients(place);
            for k in 0..lens.count() - 4 {
                let moved = |s: f64| {
                    let mut values = lens.values();
                    values[4 + k] += s;
                    lens.with_values(values).distort(place)
                };
                for (i, row) in jacobian.iter().enumerate() {
                    let difference = (moved(h)[i] - moved(-h)[i]) / (2.0 * h);
                    assert!((row[k] - difference).abs() < 1e-9, "{i}{k}: {} {difference}", row[k]);
                }
            }
        }
    }

    #[test]
    fn a_fisheye_without_bends_maps_angles_evenly() {
        let lens = Lens { distortion: Distortion::Fisheye, ..Lens::pinhole(500.0, 500.0, 640.0, 360.0) };
        for degrees in [10.0_f64, 40.0, 70.0] {
            let angle = degrees.to_radians();
            let seen = lens.project([angle.sin(), 0.0, angle.cos()]).unwrap();
            assert!((seen[0] - 640.0 - 500.0 * angle).abs() < 1e-9);
        }
    }

    #[test]
    fn a_point_behind_the_camera_or_beyond_the_fold_has_no_pixel() {
        assert_eq!(lenses()[0].project([0.0, 0.0, -1.0]), None);
        let folding = Lens { k1: -0.3, ..Lens::pinhole(1000.0, 1000.0, 500.0, 500.0) };
        assert_eq!(folding.project([1.2, 0.0, 1.0]), None);
        assert_eq!(folding.unproject([500.0 + 1000.0, 500.0]), None);
    }
}
