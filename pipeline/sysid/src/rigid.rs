//! Rigid motions between two sets of points, by least squares [kabsch1976].

use nalgebra::{Matrix3, Vector3};

/// The mean of points, in their unit.
pub(crate) fn mean_point(points: &[Vector3<f64>]) -> Vector3<f64> {
    points.iter().sum::<Vector3<f64>>() / points.len() as f64
}

/// The rotation of least squares that takes the points `reference` to the points `target`, both about their means [kabsch1976].
pub(crate) fn best_rotation(reference: &[Vector3<f64>], target: &[Vector3<f64>]) -> Matrix3<f64> {
    let (a, b) = (mean_point(reference), mean_point(target));
    let spread: Matrix3<f64> = reference.iter().zip(target).map(|(s, w)| (w - b) * (s - a).transpose()).sum();
    let svd = spread.svd(true, true);
    let (Some(u), Some(v)) = (svd.u, svd.v_t) else { return Matrix3::identity() };
    // a rotation, not a reflection
    u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, (u * v).determinant().signum())) * v
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_is_found_and_a_mirror_image_is_not_made() {
        let at = [[0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1], [0.05, 0.02, 0.0]].map(Vector3::from);
        let turned = nalgebra::Rotation3::from_euler_angles(0.3, -1.0, 2.0);
        let seen = at.map(|p| turned * p + Vector3::new(1.0, 2.0, 3.0));
        assert!((best_rotation(&seen, &at) * turned.matrix() - Matrix3::identity()).norm() < 1e-12);
        let mirrored = at.map(|p| Vector3::new(p.x, p.y, -p.z));
        assert!((best_rotation(&at, &mirrored).determinant() - 1.0).abs() < 1e-12);
    }
}
