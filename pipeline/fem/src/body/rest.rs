//! The rest state of every element, worked out once: gradients and weights at its quadrature points, and its mass.
//!
//! Stands on: `mesh`, `elements`, `quadrature`. Never knows: a material, a displacement, a matrix.

use crate::body::elements::{tetrahedron, triangle};
use crate::body::quadrature::{line_5, tetrahedron_1, tetrahedron_4, tetrahedron_125, triangle_25};
use crate::mesh::Mesh;
use nalgebra::{Matrix3, Vector3};
use si::Point3;

/// Gradients by rest coordinates and weights, element by element, point by point.
#[derive(Debug)]
pub(crate) struct Rest {
    /// Quadrature points of an element: 1 or 4.
    pub points: usize,
    /// elements × points, m³.
    pub weights: Vec<f64>,
    /// elements × points × nodes × axes, 1/m.
    pub gradients: Vec<Point3>,
    /// elements, m³.
    pub volumes: Vec<f64>,
}

impl Rest {
    /// From node positions; weights come out as they are, negative where an element is inverted.
    pub fn new(mesh: &Mesh) -> Self {
        let nodes = mesh.elements.nodes_each();
        let rule = if nodes == 4 { tetrahedron_1() } else { tetrahedron_4() };
        let shapes: Vec<_> = rule.iter().map(|&(at, weight)| (tetrahedron(nodes, at), weight)).collect();
        let count = mesh.elements.len();
        let mut rest = Self {
            points: rule.len(),
            weights: Vec::with_capacity(count * rule.len()),
            gradients: Vec::with_capacity(count * rule.len() * nodes),
            volumes: Vec::with_capacity(count),
        };
        for element in 0..count {
            let corners = mesh.elements.nodes(element);
            let first = rest.weights.len();
            for (shape, weight) in &shapes {
                let jacobian = jacobian(mesh, corners, shape);
                let inverse = jacobian.try_inverse().unwrap_or_else(Matrix3::zeros);
                rest.weights.push(weight * jacobian.determinant());
                rest.gradients.extend(shape.iter().map(|(_, slope)| by_rest(&inverse, slope)));
            }
            rest.volumes.push(rest.weights[first..].iter().sum());
        }
        rest
    }
}

/// ∂X/∂ξ: column k holds the derivative of position by reference axis k.
fn jacobian(mesh: &Mesh, nodes: &[u32], shape: &[(f64, Point3)]) -> Matrix3<f64> {
    let mut jacobian = Matrix3::zeros();
    for (&node, (_, slope)) in nodes.iter().zip(shape) {
        for axis in 0..3 {
            for k in 0..3 {
                jacobian[(axis, k)] += mesh.nodes[node as usize][axis] * slope[k];
            }
        }
    }
    jacobian
}

/// ∂N/∂X = (∂ξ/∂X)ᵀ ∂N/∂ξ.
fn by_rest(inverse: &Matrix3<f64>, slope: &Point3) -> Point3 {
    std::array::from_fn(|axis| (0..3).map(|k| inverse[(k, axis)] * slope[k]).sum())
}

/// ∫ N_a N_b dV of one element, m³, row by row: nodes × nodes.
pub(crate) fn overlaps(mesh: &Mesh, element: usize, rule: &[(Vec<(f64, Point3)>, f64)]) -> Vec<f64> {
    let nodes = mesh.elements.nodes(element);
    let mut overlap = vec![0.0; nodes.len() * nodes.len()];
    for (shape, weight) in rule {
        let volume = weight * jacobian(mesh, nodes, shape).determinant();
        for (a, (left, _)) in shape.iter().enumerate() {
            for (b, (right, _)) in shape.iter().enumerate() {
                overlap[a * nodes.len() + b] += volume * left * right;
            }
        }
    }
    overlap
}

/// The rule that [`overlaps`] needs: products of two quadratic functions on a curved element.
pub(crate) fn overlap_rule(nodes: usize) -> Vec<(Vec<(f64, Point3)>, f64)> {
    tetrahedron_125().into_iter().map(|(at, weight)| (tetrahedron(nodes, at), weight)).collect()
}

/// ∫ N_a N_b dA of one triangle at rest, m², row by row: 3 × 3 or 6 × 6.
pub(crate) fn triangle_overlaps(mesh: &Mesh, face: &[u32]) -> Vec<f64> {
    let mut overlap = vec![0.0; face.len() * face.len()];
    for (at, weight) in triangle_25() {
        let shape = triangle(face.len(), at);
        let along = |k: usize| -> Vector3<f64> {
            face.iter().zip(&shape).map(|(&node, (_, slope))| place(mesh, node) * slope[k]).sum()
        };
        let area = weight * along(0).cross(&along(1)).norm();
        for (a, (left, _)) in shape.iter().enumerate() {
            for (b, (right, _)) in shape.iter().enumerate() {
                overlap[a * face.len() + b] += area * left * right;
            }
        }
    }
    overlap
}

/// ∫ N_a dA of one triangle at rest, m²: one a node.
pub(crate) fn triangle_shares(mesh: &Mesh, face: &[u32]) -> Vec<f64> {
    triangle_overlaps(mesh, face).chunks_exact(face.len()).map(|row| row.iter().sum()).collect()
}

/// ∫ N_a ds along one edge at rest, m: ends first, then the middle where there is one.
pub(crate) fn edge_shares(mesh: &Mesh, edge: &[u32]) -> Vec<f64> {
    let mut shares = vec![0.0; edge.len()];
    for (t, weight) in line_5() {
        let (values, slopes): (Vec<f64>, Vec<f64>) = if edge.len() == 2 {
            (vec![1.0 - t, t], vec![-1.0, 1.0])
        } else {
            let values = vec![(1.0 - t) * (1.0 - 2.0 * t), t * (2.0 * t - 1.0), 4.0 * t * (1.0 - t)];
            (values, vec![4.0 * t - 3.0, 4.0 * t - 1.0, 4.0 - 8.0 * t])
        };
        let along: Vector3<f64> = edge.iter().zip(&slopes).map(|(&node, slope)| place(mesh, node) * *slope).sum();
        shares.iter_mut().zip(&values).for_each(|(share, value)| *share += weight * along.norm() * value);
    }
    shares
}

fn place(mesh: &Mesh, node: u32) -> Vector3<f64> {
    Vector3::from(mesh.nodes[node as usize])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boxes;

    #[test]
    fn volumes_of_a_box_sum_to_the_box() {
        for mesh in [boxes::linear([0.1, 0.02, 0.03], [3, 2, 2]), boxes::quadratic([0.1, 0.02, 0.03], [3, 2, 2])] {
            let volume: f64 = Rest::new(&mesh).volumes.iter().sum();
            assert!((volume - 6e-5).abs() < 1e-18);
        }
    }

    #[test]
    fn overlaps_of_an_element_sum_to_its_volume() {
        for mesh in [boxes::linear([0.1; 3], [1, 1, 1]), boxes::quadratic([0.1; 3], [1, 1, 1])] {
            let rest = Rest::new(&mesh);
            let overlap = overlaps(&mesh, 2, &overlap_rule(mesh.elements.nodes_each()));
            assert!((overlap.iter().sum::<f64>() - rest.volumes[2]).abs() < 1e-18);
        }
    }
}
