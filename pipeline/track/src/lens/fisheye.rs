//! Fisheye distortion \[kannala2006\]: the distance from the axis is a polynomial of the angle, not of its tangent.
//!
//! θ' = θ (1 + k₁θ² + k₂θ⁴ + k₃θ⁶ + k₄θ⁸), θ = atan r; the point is moved along its own direction.

use si::{Point2, Radian};

/// Nearer to the axis than this, no unit, angle and tangent are one number to 1e-16.
const AXIS: f64 = 1e-8;
/// Angle at which the search for a ray starts at most, rad: tangents beyond are too steep for Newton.
const STEEPEST: Radian = 1.4;

/// Distorted angle over the tangent, and d(distorted angle)/d(angle), at r.
fn distorted_angle(k: &[f64; 5], r: f64) -> (f64, f64) {
    let t = r.atan();
    let q = t * t;
    let bent = t * (1.0 + q * (k[0] + q * (k[1] + q * (k[2] + q * k[3]))));
    (bent / r, 1.0 + q * (3.0 * k[0] + q * (5.0 * k[1] + q * (7.0 * k[2] + q * 9.0 * k[3]))))
}

/// The distorted place.
pub(super) fn distort(k: &[f64; 5], [x, y]: Point2) -> Point2 {
    let r = (x * x + y * y).sqrt();
    let share = if r < AXIS { 1.0 } else { distorted_angle(k, r).0 };
    [share * x, share * y]
}

/// d(distorted)/d(normalised), 2 × 2, no unit.
pub(super) fn distortion_jacobian(k: &[f64; 5], [x, y]: Point2) -> [[f64; 2]; 2] {
    let r = (x * x + y * y).sqrt();
    if r < AXIS {
        return [[1.0, 0.0], [0.0, 1.0]];
    }
    let (share, rise) = distorted_angle(k, r);
    let jacobian = (rise / (1.0 + r * r) - share) / (r * r);
    [[share + jacobian * x * x, jacobian * x * y], [jacobian * x * y, share + jacobian * y * y]]
}

/// d(distorted)/d(k₁ k₂ k₃ k₄ and nothing), 2 × 5, no unit.
pub(super) fn by_coefficients([x, y]: Point2) -> [[f64; 5]; 2] {
    let r = (x * x + y * y).sqrt().max(AXIS);
    let t = r.atan();
    let powers = [t.powi(3), t.powi(5), t.powi(7), t.powi(9), 0.0];
    [powers.map(|p| p * x / r), powers.map(|p| p * y / r)]
}

/// d(distorted angle)/d(angle) at r²: positive while rays spread.
pub(super) fn rise(k: &[f64; 5], r2: f64) -> f64 {
    distorted_angle(k, r2.sqrt().max(AXIS)).1
}

/// A ray near the one whose distorted place is `goal`: as if the lens were an ideal fisheye.
pub(super) fn initial_ray([x, y]: Point2) -> Point2 {
    let angle = (x * x + y * y).sqrt();
    let share = if angle < AXIS { 1.0 } else { angle.min(STEEPEST).tan() / angle };
    [share * x, share * y]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_of_an_ideal_fisheye_is_found_from_its_angle() {
        for goal in [[0.3, -0.4], [1.0, 0.2], [0.0, 0.0]] {
            let [x, y] = initial_ray(goal);
            // the distance from the axis is the tangent of the angle, which is the distance of the distorted place
            let (angle, distance) = (goal[0].hypot(goal[1]), x.hypot(y));
            assert!((distance - angle.tan()).abs() < 1e-12 && (x * goal[1] - y * goal[0]).abs() < 1e-12, "{goal:?}");
            assert!(x * goal[0] + y * goal[1] >= 0.0);
        }
    }
}
