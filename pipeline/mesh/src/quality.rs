//! Element quality: dihedral angles of tetrahedra.

use crate::TetMesh;
use crate::tetrahedra::FACES;
use si::Point3;
use si::vec3::{cross, dot, norm, sub};

/// Smallest and largest dihedral angle of a mesh, degrees.
pub fn dihedral_range(mesh: &TetMesh) -> (f64, f64) {
    let range = |(low, high): (f64, f64), tet| {
        let (l, h) = dihedral_angles(&mesh.corners(tet));
        (low.min(l), high.max(h))
    };
    (0..mesh.tets.len()).fold((180.0, 0.0), range)
}

/// Smallest and largest of the six angles between the faces of one tetrahedron, degrees.
pub(crate) fn dihedral_angles(corners: &[Point3; 4]) -> (f64, f64) {
    let normals = FACES.map(|f| {
        let [a, b, c] = f.map(|i| corners[i]);
        let n = cross(sub(b, a), sub(c, a));
        n.map(|x| x / norm(n))
    });
    let (mut low, mut high) = (180.0f64, 0.0f64);
    for i in 0..4 {
        for j in i + 1..4 {
            let angle = 180.0 - dot(normals[i], normals[j]).clamp(-1.0, 1.0).acos().to_degrees();
            (low, high) = (low.min(angle), high.max(angle));
        }
    }
    (low, high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_regular_tetrahedron_has_six_angles_of_seventy_and_a_half_degrees() {
        let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
        let (low, high) = dihedral_angles(&corners);
        assert!((low - 70.528_779).abs() < 1e-5 && (high - low).abs() < 1e-9);
    }
}
