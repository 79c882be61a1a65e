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

/// The elements with the smallest dihedral angles, the worst first, each with its angle in degrees; `count` at most.
pub fn worst_elements(mesh: &TetMesh, count: usize) -> Vec<(usize, f64)> {
    let angle = |tet| dihedral_angles(&mesh.corners(tet)).0;
    let mut angles: Vec<(usize, f64)> = (0..mesh.tets.len()).map(|tet| (tet, angle(tet))).collect();
    angles.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
    angles.truncate(count);
    angles
}

/// The angle that a share of the elements stays below with its smallest dihedral angle, degrees.
pub(crate) fn dihedral_quantile(mesh: &TetMesh, share: f64) -> f64 {
    let mut angles: Vec<f64> = (0..mesh.tets.len()).map(|tet| dihedral_angles(&mesh.corners(tet)).0).collect();
    angles.sort_by(f64::total_cmp);
    angles.get((share * angles.len() as f64) as usize).copied().unwrap_or(180.0)
}

/// Jacobian at the worst corner of a tetrahedron over the lengths of the edges there, 1 of a regular one.
pub(crate) fn scaled_jacobian(corners: &[Point3; 4]) -> f64 {
    let [a, b, c, d] = *corners;
    let determinant = dot(cross(sub(b, a), sub(c, a)), sub(d, a));
    let product = |tip: Point3| corners.iter().filter(|p| **p != tip).map(|p| norm(sub(*p, tip))).product::<f64>();
    std::f64::consts::SQRT_2 * determinant / corners.iter().map(|tip| product(*tip)).fold(0.0, f64::max)
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
        assert!((scaled_jacobian(&corners).abs() - 1.0).abs() < 1e-12);
    }
}
