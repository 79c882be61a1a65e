//! Shape functions of the 4- and 10-node tetrahedron, the 8- and 20-node hexahedron, the 3- and 6-node triangle and the 4- and 8-node
//! quadrilateral, with their derivatives.
//!
//! Node order as in [`crate::Elements`] and [`crate::Faces`]: corners, then mid-edge nodes.
//!
//! A wedge stands among 20-node hexahedra, and a triangle among 8-node quadrilaterals, as one of which a side has shrunk to a point: the shape
//! functions are those of the 15-node wedge and the 6-node triangle, and zero at the nodes that are named again. So every loop over 20 nodes
//! serves both; the shape functions of the hexahedron itself, shrunk, are not quadratic around that point.

use si::{Point2, Point3};

/// Edges of a tetrahedron in the order of their mid-edge nodes.
pub(crate) const EDGES: [(usize, usize); 6] = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)];

/// Edges of a triangle in the order of their mid-edge nodes.
pub(crate) const SIDES: [(usize, usize); 3] = [(0, 1), (1, 2), (2, 0)];

/// Value and derivative by (ξ, η, ζ) of each shape function of a tetrahedron with 4 or 10 `nodes`.
pub(crate) fn tetrahedron(nodes: usize, at: Point3) -> Vec<(f64, Point3)> {
    let barycentric = [1.0 - at[0] - at[1] - at[2], at[0], at[1], at[2]];
    let derivative = [[-1.0, -1.0, -1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    simplex_shapes(nodes == 10, &barycentric, &derivative, &EDGES)
}

/// Value and derivative by (ξ, η) of each shape function of a triangle with 3 or 6 `nodes`.
pub(crate) fn triangle(nodes: usize, at: Point2) -> Vec<(f64, Point2)> {
    let barycentric = [1.0 - at[0] - at[1], at[0], at[1]];
    let derivative = [[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]];
    simplex_shapes(nodes == 6, &barycentric, &derivative, &SIDES)
}

/// Corners of the reference cube and square in the order of their nodes.
const CORNERS: [[f64; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
];

/// Edges of a hexahedron.
pub(crate) const CUBE_EDGES: [(usize, usize); 12] =
    [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)];

/// Edges of a quadrilateral.
pub(crate) const QUADRILATERAL_SIDES: [(usize, usize); 4] = [(0, 1), (1, 2), (2, 3), (3, 0)];

/// Value and derivative by (ξ, η, ζ) of each shape function of the element with 4, 8, 10 or 20 `nodes`.
pub(crate) fn element(nodes: usize, at: Point3) -> Vec<(f64, Point3)> {
    match nodes {
        8 => linear_products(&CORNERS, at),
        20 => serendipity(&CORNERS, &CUBE_EDGES, at),
        _ => tetrahedron(nodes, at),
    }
}

/// Whether a 20-node hexahedron is a wedge: its corners 2 and 3, and 6 and 7, are one node each.
pub(crate) fn is_wedge(nodes: &[u32]) -> bool {
    nodes.len() == 20 && nodes[2] == nodes[3] && nodes[6] == nodes[7]
}

/// Whether an 8-node face is a triangle: its corners 2 and 3 are one node.
pub(crate) fn is_triangle(nodes: &[u32]) -> bool {
    nodes.len() == 8 && nodes[2] == nodes[3]
}

/// The nodes of a 6-node triangle among those of an 8-node face.
pub(crate) const TRIANGLE_IN_FACE: [usize; 6] = [0, 1, 2, 4, 5, 7];

/// The shape functions of the 15-node wedge over the reference triangle (ξ, η) and ζ from 0 to 1, as those of a hexahedron: 4 L_i L_j times
/// the linear function of ζ on the edges of the triangles, 4 ζ (1 − ζ) L_i on the edges between them; at a corner the linear function less half
/// of those of the edges that meet there.
pub(crate) fn wedge(at: Point3) -> Vec<(f64, Point3)> {
    let plane = triangle(6, [at[0], at[1]]);
    let corner = triangle(3, [at[0], at[1]]);
    let mut shapes = vec![(0.0, [0.0; 3]); 20];
    let times = |(value, [by_xi, by_eta]): (f64, Point2), (factor, slope): (f64, f64)| {
        (value * factor, [by_xi * factor, by_eta * factor, value * slope])
    };
    let ends = [(1.0 - at[2], -1.0), (at[2], 1.0)];
    let lateral_function = (4.0 * at[2] * (1.0 - at[2]), 4.0 - 8.0 * at[2]);
    for (end, along) in ends.into_iter().enumerate() {
        for n in 0..3 {
            shapes[4 * end + n] = times(corner[n], along);
            shapes[8 + 4 * end + [0, 1, 3][n]] = times(plane[3 + n], along);
        }
    }
    (0..3).for_each(|n| shapes[16 + n] = times(corner[n], lateral_function));
    for (edge, &(from, to)) in CUBE_EDGES.iter().enumerate() {
        // zero on the edges that have shrunk
        let middle = shapes[8 + edge];
        for node in [from, to].map(|node| if node % 4 == 3 { node - 1 } else { node }) {
            let shape = &mut shapes[node];
            shape.0 -= 0.5 * middle.0;
            (0..3).for_each(|axis| shape.1[axis] -= 0.5 * middle.1[axis]);
        }
    }
    shapes
}

/// [`triangle`] with 6 nodes, as the shape functions of an 8-node face.
pub(crate) fn triangle_in_face(at: Point2) -> Vec<(f64, Point2)> {
    let mut shapes = vec![(0.0, [0.0; 2]); 8];
    TRIANGLE_IN_FACE.into_iter().zip(triangle(6, at)).for_each(|(node, shape)| shapes[node] = shape);
    shapes
}

/// Value and derivative by (ξ, η) of each shape function of the face with 3, 4, 6 or 8 `nodes`.
pub(crate) fn face(nodes: usize, at: Point2) -> Vec<(f64, Point2)> {
    let corners: [Point2; 4] = std::array::from_fn(|n| [CORNERS[n][0], CORNERS[n][1]]);
    match nodes {
        4 => linear_products(&corners, at),
        8 => serendipity(&corners, &QUADRILATERAL_SIDES, at),
        _ => triangle(nodes, at),
    }
}

/// The serendipity functions of second order on the unit square or cube: at the middle of an edge 4 ξ (1 − ξ) along
/// it times the linear functions across it; at a corner the linear function less half of those of the edges that meet there.
fn serendipity<const D: usize>(corners: &[[f64; D]], edges: &[(usize, usize)], at: [f64; D]) -> Vec<(f64, [f64; D])> {
    let mut shapes = linear_products(corners, at);
    for &(from, to) in edges {
        let edge_axis = (0..D).find(|&axis| corners[from][axis] != corners[to][axis]).unwrap_or(0);
        let (x, linear) =
            (at[edge_axis], |axis: usize| if corners[from][axis] == 1.0 { at[axis] } else { 1.0 - at[axis] });
        let slope = |axis: usize| if corners[from][axis] == 1.0 { 1.0 } else { -1.0 };
        let linear_across =
            |skipped: usize| (0..D).filter(|&axis| axis != edge_axis && axis != skipped).map(linear).product::<f64>();
        let derivative = std::array::from_fn(|axis| match axis == edge_axis {
            true => 4.0 * (1.0 - 2.0 * x) * linear_across(D),
            false => 4.0 * x * (1.0 - x) * slope(axis) * linear_across(axis),
        });
        let middle: (f64, [f64; D]) = (4.0 * x * (1.0 - x) * linear_across(D), derivative);
        for corner in [from, to] {
            shapes[corner].0 -= 0.5 * middle.0;
            (0..D).for_each(|axis| shapes[corner].1[axis] -= 0.5 * middle.1[axis]);
        }
        shapes.push(middle);
    }
    shapes
}

/// Π (ξ or 1 − ξ) over the axes: 1 at its own corner, 0 at the others.
fn linear_products<const D: usize>(corners: &[[f64; D]], at: [f64; D]) -> Vec<(f64, [f64; D])> {
    let shape = |corner: &[f64; D]| {
        let factor: [f64; D] = std::array::from_fn(|k| if corner[k] == 1.0 { at[k] } else { 1.0 - at[k] });
        let slope = |k: usize| if corner[k] == 1.0 { 1.0 } else { -1.0 };
        let other_factors = |k: usize| (0..D).filter(|&other| other != k).map(|other| factor[other]).product::<f64>();
        (factor.iter().product(), std::array::from_fn(|k| slope(k) * other_factors(k)))
    };
    corners.iter().map(shape).collect()
}

/// Linear: L_i. Quadratic: L_i (2 L_i − 1) at corners, 4 L_i L_j at mid-edge node ij.
fn simplex_shapes<const D: usize>(
    quadratic: bool,
    barycentric: &[f64],
    derivative: &[[f64; D]],
    edges: &[(usize, usize)],
) -> Vec<(f64, [f64; D])> {
    let scaled = |s: f64, v: &[f64; D]| std::array::from_fn(|axis| s * v[axis]);
    if !quadratic {
        return barycentric.iter().zip(derivative).map(|(&p, s)| (p, *s)).collect();
    }
    let corners = barycentric.iter().zip(derivative).map(|(&p, s)| (p * (2.0 * p - 1.0), scaled(4.0 * p - 1.0, s)));
    let middles = edges.iter().map(|&(i, j)| {
        let derivative = std::array::from_fn(|axis| {
            4.0 * (barycentric[i] * derivative[j][axis] + barycentric[j] * derivative[i][axis])
        });
        (4.0 * barycentric[i] * barycentric[j], derivative)
    });
    corners.chain(middles).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shape_functions_sum_to_one_and_their_derivatives_to_zero() {
        for nodes in [4, 8, 10, 20] {
            let all = element(nodes, [0.13, 0.29, 0.41]);
            assert!((all.iter().map(|(n, _)| n).sum::<f64>() - 1.0).abs() < 1e-15);
            assert!((0..3).all(|axis| all.iter().map(|(_, d)| d[axis]).sum::<f64>().abs() < 1e-14));
        }
    }

    #[test]
    fn each_shape_function_is_one_at_its_own_node_and_zero_at_the_others() {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let middle = |(i, j): (usize, usize)| std::array::from_fn(|axis| 0.5 * (corners[i][axis] + corners[j][axis]));
        for (node, at) in corners.into_iter().chain(EDGES.into_iter().map(middle)).enumerate() {
            let all = tetrahedron(10, at);
            assert!((0..10).all(|other| (all[other].0 - f64::from(u8::from(other == node))).abs() < 1e-15));
        }
    }

    #[test]
    fn each_shape_function_of_a_cube_is_one_at_its_own_corner() {
        for (node, at) in CORNERS.into_iter().enumerate() {
            assert!(element(8, at).iter().enumerate().all(|(other, shape)| (shape.0 == 1.0) == (other == node)));
        }
    }

    #[test]
    fn each_shape_function_of_a_quadratic_cube_is_one_at_its_own_node_and_derivatives_agree_with_differences() {
        let middle = |(i, j): (usize, usize)| std::array::from_fn(|axis| 0.5 * (CORNERS[i][axis] + CORNERS[j][axis]));
        for (node, at) in CORNERS.into_iter().chain(CUBE_EDGES.into_iter().map(middle)).enumerate() {
            let values = element(20, at);
            assert!(
                (0..20).all(|other| (values[other].0 - f64::from(u8::from(other == node))).abs() < 1e-15),
                "{node}"
            );
        }
        let (at, h) = ([0.2, 0.7, 0.4], 1e-6);
        for axis in 0..3 {
            let (mut above, mut below) = (at, at);
            above[axis] += h;
            below[axis] -= h;
            for (node, (_, derivative)) in element(20, at).iter().enumerate() {
                let difference = (element(20, above)[node].0 - element(20, below)[node].0) / (2.0 * h);
                assert!((derivative[axis] - difference).abs() < 1e-9, "{node} {axis}");
            }
        }
    }

    #[test]
    fn each_shape_function_of_a_wedge_is_one_at_its_own_node_and_derivatives_agree_with_differences() {
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 1.0]];
        let corner = |n: usize| [corners[n % 4][0], corners[n % 4][1], if n < 4 { 0.0 } else { 1.0 }];
        let middle = |(i, j): (usize, usize)| std::array::from_fn(|axis| 0.5 * (corner(i)[axis] + corner(j)[axis]));
        let repeated = [3, 7, 10, 14, 19];
        for (node, at) in (0..8).map(corner).chain(CUBE_EDGES.into_iter().map(middle)).enumerate() {
            let own = match node {
                3 | 10 => 2,
                7 | 14 => 6,
                19 => 18,
                _ => node,
            };
            let values = wedge(at);
            assert!((0..20).all(|other| (values[other].0 - f64::from(u8::from(other == own))).abs() < 1e-15), "{node}");
            assert!(repeated.iter().all(|&other| values[other] == (0.0, [0.0; 3])));
        }
        let (at, h) = ([0.2, 0.3, 0.4], 1e-6);
        for axis in 0..3 {
            let (mut above, mut below) = (at, at);
            above[axis] += h;
            below[axis] -= h;
            for (node, (_, derivative)) in wedge(at).iter().enumerate() {
                let difference = (wedge(above)[node].0 - wedge(below)[node].0) / (2.0 * h);
                assert!((derivative[axis] - difference).abs() < 1e-9, "{node} {axis}");
            }
        }
    }

    #[test]
    fn derivatives_agree_with_central_differences() {
        let (at, h) = ([0.2, 0.3], 1e-6);
        for nodes in [3, 4, 6, 8] {
            for axis in 0..2 {
                let (mut above, mut below) = (at, at);
                above[axis] += h;
                below[axis] -= h;
                for node in 0..nodes {
                    let difference = (face(nodes, above)[node].0 - face(nodes, below)[node].0) / (2.0 * h);
                    assert!((face(nodes, at)[node].1[axis] - difference).abs() < 1e-9);
                }
            }
        }
    }
}
