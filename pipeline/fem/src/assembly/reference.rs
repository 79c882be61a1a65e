//! Reference geometry of every element, computed once: gradients and weights at its quadrature points, and integrals of
//! its shape functions.
//!
//! A 10-node tetrahedron (P2) takes 4 points, a 4-node one (P1) a single point, an 8-node hexahedron (Q1) 8. A 20-node hexahedron (Q2) takes
//! two rules at once: the λ part of its energy and most of the μ part at 2³ points, where it does not lock, and a share of the μ part at 3³,
//! without which some modes of the mesh have no energy and paths beyond the buckle of a thin wall end. P2 is recommended: on a
//! hollow body with a thin stiff sheet P1 missed 81 % of the tip deflection at 241k dofs, P2 2.7 % at 39k; one layer of
//! P2 through a sheet bends exactly. P1 remains for comparison and for projective dynamics.
//!
//! **Thin walls.** Half of a tail with walls of 1.55 mm under pressure on one side, without contact (`just bench resolution`); of the angle of its
//! end and of the pressure at which a slack wall has a dent of 1 mm, the difference to the finest row. Graded: cells short along x beside ribs
//! and along the chambers' depth beside the wall.
//!
//! | elements                                  | dofs   | Gflop | at 100, 160, 225 mbar   | dent   |
//! |-------------------------------------------|--------|-------|-------------------------|--------|
//! | 10-node tetrahedra, even cells            | 44 610 | 14.4  | −7.2 %, −21.7 %, −20.6 % | +22.9 % |
//! | the same, graded, mean dilatation         | 52 398 | 13.2  | −4.9 %, −7.7 %, −7.3 %  | −1.7 % |
//! | 20-node hexahedra, graded, a share of ¼   | 29 406 | 6.0   | −0.8 %, −2.6 %, −1.8 %  | +2.2 % |
//! | the same, a share of 0.1                  | 29 406 | 6.0   | −0.8 %, −1.8 %, −1.0 %  | +1.6 % |
//! | longer along the height, a share of ¼      | 34 095 | 6.1   | −0.4 %, −1.9 %, −1.7 %  | +0.9 % |
//! | 20-node hexahedra, finer, a share of 0.1  | 55 056 | 16.2  | 12.98°, 31.76°, 75.03°  | 133.9 mbar |
//!
//! So the silicone's bulging walls lock in tetrahedra, close to incompressibility, long before the sheet does. A mesh of 10-node tetrahedra
//! with edges of 2.8 mm has 25.6 Gflop. In today's elimination order the last two rows have 4.0 and 10.0.

use crate::assembly::quadrature::{
    cube_8, cube_27, cube_125, line_5, repeat_last, square_25, tetrahedron_1, tetrahedron_4, tetrahedron_125,
    triangle_25, wedge_6, wedge_21, wedge_125,
};
use crate::assembly::shape_functions::{element, face, is_triangle, is_wedge, triangle_in_face, wedge};
use crate::mesh::Mesh;
use nalgebra::{Matrix3, Vector3};
use si::Point3;

/// Gradients by reference coordinates and weights, by element and quadrature point.
#[derive(Debug, Clone)]
pub(crate) struct ReferenceElements {
    /// Quadrature points of an element: 1, 4, 8 or 35.
    pub points: usize,
    /// Of each point of an element: the shares of the μ and of the λ part of the energy that are integrated there.
    pub shares: Vec<[f64; 2]>,
    /// elements × points, m³.
    pub weights: Vec<f64>,
    /// elements × points × nodes × axes, 1/m.
    pub gradients: Vec<Point3>,
    /// elements, m³.
    pub volumes: Vec<f64>,
}

/// The share of the μ part of a 20-node hexahedron's energy that is integrated at 3³ points, where no other is asked for.
// 0.05 and 0.1 end at 250 mbar on coarse meshes of a thin tail, 0.15 to 0.25 hold to 300; between 0.05 and 0.25 its angle at 160 mbar falls
// by 1 %. An equilibrium on the way took 4.6 factorisations in the mean with 0.2, 6.1 with 0.25 and 6.9 with 0.15.
pub(crate) const SHEAR_SHARE: f64 = 0.2;

/// Points and weights of an element.
type Rule = Vec<(Point3, f64)>;

/// The shape functions at every point of a rule, and its weight.
pub(crate) type Shapes = Vec<(Vec<(f64, Point3)>, f64)>;

/// The shares of the μ and λ parts at the points of a rule.
type Shares = Vec<[f64; 2]>;

/// Points and weights of an element with so many nodes, and the shares of the μ and λ parts at each.
fn element_rule(nodes: usize, shear_share: f64) -> (Rule, Shares) {
    match nodes {
        4 => full_shares(tetrahedron_1()),
        8 => full_shares(cube_8()),
        20 => split_shares([cube_27(), cube_8()], shear_share),
        _ => full_shares(tetrahedron_4()),
    }
}

fn full_shares(points: Rule) -> (Rule, Shares) {
    let shares = vec![[1.0; 2]; points.len()];
    (points, shares)
}

/// The share of the μ part at the points of a finer rule, the rest and the λ part at those of a coarser one.
fn split_shares([fine, coarse]: [Rule; 2], share: f64) -> (Rule, Shares) {
    if share == 0.0 {
        return full_shares(coarse);
    }
    let shares = [vec![[share, 0.0]; fine.len()], vec![[1.0 - share, 1.0]; coarse.len()]].concat();
    ([fine, coarse].concat(), shares)
}

/// The rule of a wedge among 20-node hexahedra: as many points as theirs, so that every element has as many.
// Repeated points cost time and no accuracy; wedges are a few per cent of a mesh.
fn wedge_rule(shear_share: f64) -> Rule {
    split_shares([repeat_last(wedge_21(), 27), repeat_last(wedge_6(), 8)], shear_share).0
}

impl ReferenceElements {
    /// From node positions, with the share of the μ part at the finer points of 20-node hexahedra; the weights of an inverted element are
    /// negative.
    pub fn new(mesh: &Mesh, shear_share: f64) -> Self {
        let nodes = mesh.elements.nodes_each();
        let (rule, shares) = element_rule(nodes, shear_share);
        let points = rule.len();
        let [elements, wedges] = ElementShapes { elements: rule, wedges: wedge_rule(shear_share) }.of_elements(nodes);
        let count = mesh.elements.len();
        let mut reference = Self {
            points,
            shares,
            weights: Vec::with_capacity(count * points),
            gradients: Vec::with_capacity(count * points * nodes),
            volumes: Vec::with_capacity(count),
        };
        for number in 0..count {
            let corners = mesh.elements.nodes(number);
            let first = reference.weights.len();
            for (shape, weight) in if is_wedge(corners) { &wedges } else { &elements } {
                let jacobian = jacobian(mesh, corners, shape);
                let inverse = jacobian.try_inverse().unwrap_or_else(Matrix3::zeros);
                reference.weights.push(weight * jacobian.determinant());
                reference.gradients.extend(shape.iter().map(|(_, derivative)| by_reference(&inverse, derivative)));
            }
            // of one rule where there are two: that of the λ part
            let volume =
                reference.weights[first..].iter().zip(&reference.shares).map(|(weight, shares)| weight * shares[1]);
            reference.volumes.push(volume.sum());
        }
        reference
    }
}

/// ∂X/∂ξ: column k holds the derivative of position by reference axis k.
fn jacobian(mesh: &Mesh, nodes: &[u32], shape: &[(f64, Point3)]) -> Matrix3<f64> {
    let mut jacobian = Matrix3::zeros();
    for (&node, (_, derivative)) in nodes.iter().zip(shape) {
        for axis in 0..3 {
            for k in 0..3 {
                jacobian[(axis, k)] += mesh.nodes[node as usize][axis] * derivative[k];
            }
        }
    }
    jacobian
}

/// ∂N/∂X = (∂ξ/∂X)ᵀ ∂N/∂ξ.
fn by_reference(inverse: &Matrix3<f64>, derivative: &Point3) -> Point3 {
    std::array::from_fn(|axis| (0..3).map(|k| inverse[(k, axis)] * derivative[k]).sum())
}

/// The rules of the elements of a mesh, and of the wedges among its hexahedra.
struct ElementShapes {
    elements: Rule,
    wedges: Rule,
}

impl ElementShapes {
    /// The shape functions of elements with so many nodes, and of wedges.
    fn of_elements(self, nodes: usize) -> [Shapes; 2] {
        let elements = self.elements.into_iter().map(|(at, weight)| (element(nodes, at), weight)).collect();
        [elements, self.wedges.into_iter().map(|(at, weight)| (wedge(at), weight)).collect()]
    }
}

/// ∫ N_a N_b dV of one element, m³, row by row: nodes × nodes.
pub(crate) fn shape_products(mesh: &Mesh, element: usize, [elements, wedges]: &[Shapes; 2]) -> Vec<f64> {
    let nodes = mesh.elements.nodes(element);
    let mut products = vec![0.0; nodes.len() * nodes.len()];
    for (shape, weight) in if is_wedge(nodes) { wedges } else { elements } {
        let volume = weight * jacobian(mesh, nodes, shape).determinant();
        for (a, (left, _)) in shape.iter().enumerate() {
            for (b, (right, _)) in shape.iter().enumerate() {
                products[a * nodes.len() + b] += volume * left * right;
            }
        }
    }
    products
}

/// The quadrature of [`shape_products`]: products of two quadratic functions on a curved element.
pub(crate) fn shape_product_rule(nodes: usize) -> [Shapes; 2] {
    let elements = if matches!(nodes, 8 | 20) { cube_125() } else { tetrahedron_125() };
    ElementShapes { elements, wedges: wedge_125() }.of_elements(nodes)
}

/// ∫ N_a N_b dA of one face at rest, m², row by row: 3 × 3, 4 × 4, 6 × 6 or 8 × 8.
pub(crate) fn face_shape_products(mesh: &Mesh, nodes: &[u32]) -> Vec<f64> {
    let mut products = vec![0.0; nodes.len() * nodes.len()];
    let square = matches!(nodes.len(), 4 | 8) && !is_triangle(nodes);
    for (point, weight) in if square { square_25() } else { triangle_25() } {
        let shape = if is_triangle(nodes) { triangle_in_face(point) } else { face(nodes.len(), point) };
        let tangent_vector = |k: usize| -> Vector3<f64> {
            nodes.iter().zip(&shape).map(|(&node, (_, derivative))| rest_position(mesh, node) * derivative[k]).sum()
        };
        let area = weight * tangent_vector(0).cross(&tangent_vector(1)).norm();
        for (a, (left, _)) in shape.iter().enumerate() {
            for (b, (right, _)) in shape.iter().enumerate() {
                products[a * nodes.len() + b] += area * left * right;
            }
        }
    }
    products
}

/// ∫ N_a dA of one face at rest, m²: one per node.
pub(crate) fn face_integrals(mesh: &Mesh, face: &[u32]) -> Vec<f64> {
    face_shape_products(mesh, face).chunks_exact(face.len()).map(|row| row.iter().sum()).collect()
}

/// ∫ N_a ds along one edge at rest, m: ends first, then the mid-edge node where there is one.
pub(crate) fn edge_integrals(mesh: &Mesh, edge: &[u32]) -> Vec<f64> {
    let mut integrals = vec![0.0; edge.len()];
    for (t, weight) in line_5() {
        let (values, derivatives): (Vec<f64>, Vec<f64>) = if edge.len() == 2 {
            (vec![1.0 - t, t], vec![-1.0, 1.0])
        } else {
            let values = vec![(1.0 - t) * (1.0 - 2.0 * t), t * (2.0 * t - 1.0), 4.0 * t * (1.0 - t)];
            (values, vec![4.0 * t - 3.0, 4.0 * t - 1.0, 4.0 - 8.0 * t])
        };
        let tangent_vector: Vector3<f64> =
            edge.iter().zip(&derivatives).map(|(&node, derivative)| rest_position(mesh, node) * *derivative).sum();
        integrals.iter_mut().zip(&values).for_each(|(sum, value)| *sum += weight * tangent_vector.norm() * value);
    }
    integrals
}

fn rest_position(mesh: &Mesh, node: u32) -> Vector3<f64> {
    Vector3::from(mesh.nodes[node as usize])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::box_mesh;

    #[test]
    fn volumes_of_a_box_sum_to_the_box() {
        let place = |at: Point3| [0.1 * at[0], 0.02 * at[1], 0.03 * at[2]];
        let cubes = box_mesh::quadratic_hexahedra([3, 2, 2], false, place, |_| Some(0));
        let [linear, quadratic] = [box_mesh::linear, box_mesh::quadratic].map(|of| of([0.1, 0.02, 0.03], [3, 2, 2]));
        for mesh in [linear, quadratic, cubes] {
            let volume: f64 = ReferenceElements::new(&mesh, SHEAR_SHARE).volumes.iter().sum();
            assert!((volume - 6e-5).abs() < 1e-18);
        }
    }

    #[test]
    fn shape_products_of_an_element_sum_to_its_volume() {
        for mesh in [box_mesh::linear([0.1; 3], [1, 1, 1]), box_mesh::quadratic([0.1; 3], [1, 1, 1])] {
            let reference = ReferenceElements::new(&mesh, SHEAR_SHARE);
            let products = shape_products(&mesh, 2, &shape_product_rule(mesh.elements.nodes_each()));
            assert!((products.iter().sum::<f64>() - reference.volumes[2]).abs() < 1e-18);
        }
    }
}
