//! Camera poses: rotation and translation from the world's frame to the camera's.
//!
//! The camera's frame: x to the right of the picture, y down, z along the optical axis.

use nalgebra::{Matrix3, Rotation3, Vector3};
use si::{Point3, vec3};

/// World → camera: p_camera = R p_world + t.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// R, by rows, no unit.
    pub rotation: [[f64; 3]; 3],
    /// t, m.
    pub translation: [f64; 3],
}

impl Pose {
    /// A pose from a rotation vector (axis × angle, rad) and a shift (m).
    pub fn from_vector(turn: Point3, translation: Point3) -> Self {
        let matrix = Rotation3::new(Vector3::from(turn)).into_inner();
        Self { rotation: matrix_rows(&matrix), translation }
    }

    /// The rotation as axis × angle, rad, angle within 0 … π.
    pub fn rotation_vector(&self) -> Point3 {
        Rotation3::from_matrix_unchecked(self.rotation_matrix()).scaled_axis().into()
    }

    /// A point of the world (m) in the camera's frame (m).
    pub fn apply(&self, point: Point3) -> Point3 {
        vec3::add(self.rotation.map(|row| vec3::dot(row, point)), self.translation)
    }

    /// A point of the camera's frame (m) in the world (m).
    pub fn to_world(&self, point: Point3) -> Point3 {
        self.direction_to_world(vec3::sub(point, self.translation))
    }

    /// A direction of the camera's frame as one of the world: Rᵀ d.
    pub(crate) fn direction_to_world(&self, direction: Point3) -> Point3 {
        #[allow(non_snake_case)]
        let R = self.rotation;
        [0, 1, 2].map(|i| R[0][i] * direction[0] + R[1][i] * direction[1] + R[2][i] * direction[2])
    }

    /// The pose turned by a small rotation vector `turn` (rad) of the camera's frame about its own origin, then shifted (m):
    /// R ← exp(turn) R, t ← t + shift.
    pub fn rotated_and_shifted(&self, turn: Point3, shift: Point3) -> Self {
        let turned = Rotation3::new(Vector3::from(turn)).into_inner() * self.rotation_matrix();
        Self::from_matrix(&turned, vec3::add(self.translation, shift).into())
    }

    /// Position of the camera in the world, m.
    pub fn centre(&self) -> Point3 {
        self.to_world([0.0; 3])
    }

    /// R as a matrix.
    pub(crate) fn rotation_matrix(&self) -> Matrix3<f64> {
        Matrix3::from_fn(|i, j| self.rotation[i][j])
    }

    /// A pose from a matrix near a rotation (the nearest one is taken) and a shift (m).
    #[allow(non_snake_case)]
    pub(crate) fn from_matrix(near: &Matrix3<f64>, translation: Vector3<f64>) -> Self {
        let svd = near.svd(true, true);
        let nearest = match (svd.u, svd.v_t) {
            (Some(U), Some(Vt)) => {
                // U Vᵀ alone may be a reflection; the nearest rotation then has the direction of the least singular
                // value reversed.
                let sign = (U * Vt).determinant().signum();
                U * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * Vt
            }
            _ => *near,
        };
        Self { rotation: matrix_rows(&nearest), translation: translation.into() }
    }
}

fn matrix_rows(matrix: &Matrix3<f64>) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| matrix[(i, j)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_undoes_itself() {
        let pose = Pose::from_vector([0.3, -2.0, 0.7], [0.1, -0.2, 0.9]);
        let point = [0.03, -0.11, 0.02];
        assert!(vec3::norm(vec3::sub(pose.to_world(pose.apply(point)), point)) < 1e-15);
        assert!(vec3::norm(pose.apply(pose.centre())) < 1e-15);
    }

    #[test]
    fn a_turn_is_read_back() {
        let turn = [0.3, -2.0, 0.7];
        assert!(vec3::norm(vec3::sub(Pose::from_vector(turn, [0.0; 3]).rotation_vector(), turn)) < 1e-12);
    }
}
