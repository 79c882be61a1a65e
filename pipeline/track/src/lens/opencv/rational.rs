//! The rational, thin-prism and tilted distortion of OpenCV, and the lens of ours that comes nearest to it.

use crate::lens::{Distortion, Lens};
use nalgebra::{DMatrix, DVector};
use si::Point2;

/// Columns and rows of pixels at which both are compared.
const GRID: [usize; 2] = [33, 25];
/// Numbers that are fitted: scale and centre each way, k₁ k₂ k₃ p₁ p₂, each times the scale.
const UNKNOWNS: usize = 8;

/// Distortion with up to fourteen numbers: k₁ k₂ p₁ p₂ k₃, k₄ k₅ k₆, s₁ … s₄, τₓ τᵧ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rational {
    pub numbers: [f64; 14],
}

impl Rational {
    /// x' = x (1 + k₁r² + k₂r⁴ + k₃r⁶)/(1 + k₄r² + k₅r⁴ + k₆r⁶) + 2p₁xy + p₂(r² + 2x²) + s₁r² + s₂r⁴, y' alike, then the tilt of the sensor
    /// (OpenCV, "Camera Calibration and 3D Reconstruction").
    fn distort(&self, [x, y]: Point2) -> Point2 {
        let [k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4, tilt_x, tilt_y] = self.numbers;
        let r2 = x * x + y * y;
        let radial = (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1.0 + r2 * (k4 + r2 * (k5 + r2 * k6)));
        let bent = [
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x) + r2 * (s1 + r2 * s2),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y + r2 * (s3 + r2 * s4),
        ];
        tilt_point(bent, tilt_x, tilt_y)
    }

    /// The ray of a distorted place, by Newton with differences; none where there is none.
    fn ray_of(&self, goal: Point2) -> Option<Point2> {
        const STEP: f64 = 1e-7;
        let mut ray = goal;
        for _ in 0..50 {
            let distorted = self.distort(ray);
            let miss = [goal[0] - distorted[0], goal[1] - distorted[1]];
            if miss[0].hypot(miss[1]) < 1e-12 {
                return Some(ray);
            }
            let column = |k: usize| {
                let mut perturbed = ray;
                perturbed[k] += STEP;
                let perturbed_image = self.distort(perturbed);
                [0, 1].map(|row| (perturbed_image[row] - distorted[row]) / STEP)
            };
            let [[a, c], [b, d]] = [column(0), column(1)];
            let step = crate::lens::solve([[a, b], [c, d]], miss)?;
            ray = [ray[0] + step[0], ray[1] + step[1]];
        }
        None
    }

    /// The lens of five numbers that is nearest to this one with focal lengths and centre `[fx, fy, cx, cy]` over a picture of `size` (px), and the
    /// root of their mean squared distance, px. None where rays of the picture are not determined.
    pub(super) fn nearest_lens(&self, [fx, fy, cx, cy]: [f64; 4], size: [f64; 2]) -> Option<(Lens, f64)> {
        let pixel = |i: usize, k: usize| size[k] * i as f64 / (GRID[k] - 1) as f64;
        let mut rays = Vec::new();
        for (i, j) in (0..GRID[0]).flat_map(|i| (0..GRID[1]).map(move |j| (i, j))) {
            let normalised = [(pixel(i, 0) - cx) / fx, (pixel(j, 1) - cy) / fy];
            rays.push((self.ray_of(normalised)?, normalised));
        }
        // linear in the scale, in scale times each number, and in the shift of the centre, all in focal lengths
        let row = |[x, y]: Point2, k: usize| -> [f64; UNKNOWNS] {
            let (r2, coordinate) = (x * x + y * y, [x, y][k]);
            let tangential = [[2.0 * x * y, r2 + 2.0 * x * x], [r2 + 2.0 * y * y, 2.0 * x * y]][k];
            let shift = [f64::from(k == 0), f64::from(k == 1)];
            [
                coordinate,
                coordinate * r2,
                coordinate * r2 * r2,
                coordinate * r2.powi(3),
                tangential[0],
                tangential[1],
                shift[0],
                shift[1],
            ]
        };
        let count = 2 * rays.len();
        let table = DMatrix::from_fn(count, UNKNOWNS, |i, u| row(rays[i / 2].0, i % 2)[u]);
        let goal = DVector::from_fn(count, |i, _| rays[i / 2].1[i % 2]);
        let fit = table.clone().svd(true, true).solve(&goal, 1e-14).ok()?;
        let residual = table * &fit - goal;
        let square = residual.iter().enumerate().map(|(i, residual)| ([fx, fy][i % 2] * residual).powi(2)).sum::<f64>();
        let scale = fit[0];
        let [k1, k2, k3, p1, p2] = [1, 2, 3, 4, 5].map(|u| fit[u] / scale);
        let lens = Lens { distortion: Distortion::BrownConrady, ..Lens::default() };
        let (fx, fy, cx, cy) = (fx * scale, fy * scale, cx + fx * fit[6], cy + fy * fit[7]);
        Some((lens.with_values([fx, fy, cx, cy, k1, k2, p1, p2, k3]), (square / rays.len() as f64).sqrt()))
    }
}

/// A place on a sensor that is tilted by two angles (rad), seen from the axis of the lens.
fn tilt_point([x, y]: Point2, tilt_x: f64, tilt_y: f64) -> Point2 {
    if tilt_x == 0.0 && tilt_y == 0.0 {
        return [x, y];
    }
    let ([sx, cx], [sy, cy]) = ([tilt_x.sin(), tilt_x.cos()], [tilt_y.sin(), tilt_y.cos()]);
    // R = R_y R_x, then the projection onto its third axis
    let r = [[cy, sy * sx, -sy * cx], [0.0, cx, sx], [sy, -cy * sx, cy * cx]];
    let turned = r.map(|row| row[0] * x + row[1] * y + row[2]);
    let [a, b, c] = turned;
    [(r[2][2] * a - r[0][2] * c) / c, (r[2][2] * b - r[1][2] * c) / c]
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAMERA: [f64; 4] = [1000.0, 1002.0, 645.0, 358.0];

    fn rational(numbers: &[f64]) -> Rational {
        Rational { numbers: std::array::from_fn(|i| numbers.get(i).copied().unwrap_or(0.0)) }
    }

    #[test]
    fn a_lens_of_five_numbers_comes_back() {
        let (lens, off) = rational(&[-0.11, 0.03, 3e-4, -2e-4, -0.01]).nearest_lens(CAMERA, [1280.0, 720.0]).unwrap();
        let known = [1000.0, 1002.0, 645.0, 358.0, -0.11, 0.03, 3e-4, -2e-4, -0.01];
        assert!(lens.values().iter().zip(known).all(|(a, b)| (a - b).abs() < 1e-6), "{:?}", lens.values());
        assert!(off < 1e-8, "{off}");
    }

    #[test]
    fn rational_thin_prism_and_tilted_lenses_are_met_within_the_residual_that_is_said() {
        for numbers in [
            &[0.4, 0.1, 3e-4, -2e-4, 0.02, 0.52, 0.14, 0.03][..],
            &[-0.1, 0.02, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 1e-3, -2e-4, 5e-4, 1e-4],
            &[-0.1, 0.02, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.001, -0.0008],
        ] {
            let known = rational(numbers);
            let (lens, off) = known.nearest_lens(CAMERA, [1280.0, 720.0]).unwrap();
            assert!(off < 0.1, "{numbers:?}: {off}");
            for at in [[0.3, -0.2], [-0.55, 0.31], [0.0, 0.1]] {
                let [x, y] = known.distort(at);
                let seen = lens.project([at[0], at[1], 1.0]).unwrap();
                let miss = (seen[0] - (1000.0 * x + 645.0)).hypot(seen[1] - (1002.0 * y + 358.0));
                assert!(miss < 6.0 * off + 1e-6, "{numbers:?} at {at:?}: {miss} of {off}");
            }
        }
    }
}
