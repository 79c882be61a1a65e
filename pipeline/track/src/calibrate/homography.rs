//! Homographies, and the pose that a homography of a plane contains; both are initial values for the bundle adjustment.

use crate::pose::Pose;
use nalgebra::{Matrix3, SMatrix, Vector3};
use si::Point2;

/// H with w [u v 1]ᵀ = H [x y 1]ᵀ for places `from` and `onto`, by the normalised direct linear transform.
///
/// The eigenvector of AᵀA to the least eigenvalue, A two rows a pair       [hartley2003, algorithm 4.2]
///
/// None when there are fewer than four pairs, or those of `from` lie on a line.
#[allow(non_snake_case)]
pub(crate) fn homography(from: &[Point2], onto: &[Point2]) -> Option<Matrix3<f64>> {
    if from.len() < 4 || from.len() != onto.len() {
        return None;
    }
    // In pixels the entries of AᵀA would span some twelve decades, products of four coordinates of a thousand beside
    // ones, and the least eigenvector would drown.
    let (S, T) = (normalising_map(from)?, normalising_map(onto)?);
    let mut AtA = SMatrix::<f64, 9, 9>::zeros();
    for (a, b) in from.iter().zip(onto) {
        let p = S * Vector3::new(a[0], a[1], 1.0);
        let q = T * Vector3::new(b[0], b[1], 1.0);
        let (z, u, v) = ([0.0; 3], p * -q.x, p * -q.y);
        for row in [[p.x, p.y, p.z, z[0], z[1], z[2], u.x, u.y, u.z], [z[0], z[1], z[2], p.x, p.y, p.z, v.x, v.y, v.z]]
        {
            let row = SMatrix::<f64, 9, 1>::from_row_slice(&row);
            AtA += row * row.transpose();
        }
    }
    let eigen = AtA.symmetric_eigen();
    let mut order: Vec<usize> = (0..9).collect();
    order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
    // a second vanishing direction: the points lie on a line and fix no map
    if eigen.eigenvalues[order[1]] < 1e-10 * eigen.eigenvalues[order[8]] {
        return None;
    }
    let h = eigen.eigenvectors.column(order[0]);
    let H = T.try_inverse()? * Matrix3::from_row_iterator(h.iter().copied()) * S;
    Some(H / H.norm())
}

/// The place that a map takes a point to.
#[allow(non_snake_case)]
pub(crate) fn map_point(H: &Matrix3<f64>, point: Point2) -> Point2 {
    let image = H * Vector3::new(point[0], point[1], 1.0);
    [image.x / image.z, image.y / image.z]
}

/// Moves the middle of the points to 0 and their mean distance from it to √2.
fn normalising_map(points: &[Point2]) -> Option<Matrix3<f64>> {
    let n = points.len() as f64;
    let middle = points.iter().fold([0.0; 2], |m, p| [m[0] + p[0] / n, m[1] + p[1] / n]);
    let spread: f64 = points.iter().map(|p| (p[0] - middle[0]).hypot(p[1] - middle[1]) / n).sum();
    let s = std::f64::consts::SQRT_2 / spread;
    s.is_finite().then(|| Matrix3::new(s, 0.0, -s * middle[0], 0.0, s, -s * middle[1], 0.0, 0.0, 1.0))
}

/// The pose in a map from the plane z = 0 (m) to normalised rays: H ∝ [r₁ r₂ t], the plane in front of the camera.
#[allow(non_snake_case)]
pub(super) fn pose_of_homography(H: &Matrix3<f64>) -> Pose {
    let (h1, h2, t) = (H.column(0).into_owned(), H.column(1).into_owned(), H.column(2).into_owned());
    let scale = t.z.signum() * 2.0 / (h1.norm() + h2.norm());
    let (r1, r2, t) = (h1 * scale, h2 * scale, t * scale);
    Pose::from_matrix(&Matrix3::from_columns(&[r1, r2, r1.cross(&r2)]), t)
}

/// The other pose from which a plane looks much the same when far away: its tilt against the line of sight reversed.
#[allow(non_snake_case)]
pub(super) fn mirrored_pose(pose: &Pose, middle: si::Point3) -> Pose {
    let R = pose.rotation_matrix();
    let middle_in_camera = Vector3::from(pose.apply(middle));
    let line_of_sight = middle_in_camera.normalize();
    let normal = R.column(2).into_owned();
    let mirrored_normal = 2.0 * line_of_sight.dot(&normal) * line_of_sight - normal;
    let turn = nalgebra::Rotation3::rotation_between(&normal, &mirrored_normal)
        .map_or(Matrix3::identity(), |r| r.into_inner());
    let R = turn * R;
    Pose::from_matrix(&R, middle_in_camera - R * Vector3::from(middle))
}

#[cfg(test)]
mod tests {
    use super::*;
    use si::vec3;

    #[test]
    fn the_pose_of_a_plane_is_in_its_map() {
        let truth = Pose::from_vector([2.9, 0.2, -0.3], [0.02, -0.04, 0.6]);
        let plane: Vec<Point2> = (0..12).map(|i| [0.03 * f64::from(i % 4), 0.03 * f64::from(i / 4)]).collect();
        let ray = |p: &Point2| {
            let [x, y, z] = truth.apply([p[0], p[1], 0.0]);
            [x / z, y / z]
        };
        let found = pose_of_homography(&homography(&plane, &plane.iter().map(ray).collect::<Vec<_>>()).unwrap());
        assert!(vec3::norm(vec3::sub(found.rotation_vector(), truth.rotation_vector())) < 1e-9);
        assert!(vec3::norm(vec3::sub(found.translation, truth.translation)) < 1e-9);
    }

    #[test]
    fn points_on_a_line_fix_no_map() {
        let line: Vec<Point2> = (0..8).map(|i| [f64::from(i), 2.0 * f64::from(i)]).collect();
        assert!(homography(&line, &line).is_none());
    }

    #[test]
    fn a_mirrored_pose_keeps_the_middle_and_mirrors_back() {
        let pose = Pose::from_vector([2.9, 0.2, -0.3], [0.02, -0.04, 0.6]);
        let middle = [0.05, 0.03, 0.0];
        let other = mirrored_pose(&pose, middle);
        assert!(vec3::norm(vec3::sub(other.apply(middle), pose.apply(middle))) < 1e-12);
        let back = mirrored_pose(&other, middle);
        assert!(vec3::norm(vec3::sub(back.rotation_vector(), pose.rotation_vector())) < 1e-9);
    }
}
