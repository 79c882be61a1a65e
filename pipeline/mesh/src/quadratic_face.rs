//! Faces of second order: triangles of six nodes, quadrilaterals of eight.

use crate::Skin;
use si::Point2;

/// A face of the skin of second order; its normal (right hand, in the order of its corners) points out of the solid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct QuadraticFace {
    nodes: [u32; 8],
    count: usize,
    /// What is on the other side.
    pub on: Skin,
}

impl QuadraticFace {
    /// Three corners, then the middles of 01, 12, 20.
    pub fn triangle(nodes: [u32; 6], on: Skin) -> Self {
        Self { nodes: std::array::from_fn(|n| if n < 6 { nodes[n] } else { 0 }), count: 6, on }
    }

    /// Four corners, then the middles of 01, 12, 23, 30.
    pub(crate) fn quadrilateral(nodes: [u32; 8], on: Skin) -> Self {
        Self { nodes, count: 8, on }
    }

    /// From 6 nodes of a triangle, or 8 as `Self::as_side` gives them; none of other numbers.
    pub fn from_row(nodes: &[u32], on: Skin) -> Option<Self> {
        let triangle = nodes.try_into().ok().map(|nodes| Self::triangle(nodes, on));
        triangle.or_else(|| Self::of_side(nodes.try_into().ok()?, on))
    }

    /// A side of a hexahedron or a wedge: a triangle where two of its corners are one, none where it has shrunk to an edge.
    pub(crate) fn of_side(nodes: [u32; 8], on: Skin) -> Option<Self> {
        let corners = &nodes[..4];
        let distinct = (0..4).filter(|&n| !corners[..n].contains(&corners[n])).count();
        let turned = |by: usize| std::array::from_fn(|n| nodes[4 * (n / 4) + (n + by) % 4]);
        match distinct {
            4 => Some(Self::quadrilateral(nodes, on)),
            3 => {
                let side = (0..4).map(turned).find(|side: &[u32; 8]| side[2] == side[3]);
                side.map(|[a, b, c, _, ab, bc, _, ca]| Self::triangle([a, b, c, ab, bc, ca], on))
            }
            _ => None,
        }
    }

    /// Corners, then middles: 6 or 8.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes[..self.count]
    }

    /// Three or four.
    pub fn corners(&self) -> &[u32] {
        &self.nodes[..self.count / 2]
    }

    /// The triangles between its corners, one or two.
    pub fn corner_triangles(&self) -> Vec<[u32; 3]> {
        match *self.corners() {
            [a, b, c, d] => vec![[a, b, c], [a, c, d]],
            _ => vec![[self.nodes[0], self.nodes[1], self.nodes[2]]],
        }
    }

    /// As an 8-node side of a hexahedron: a triangle names its third corner twice, and once more as the middle between.
    pub(crate) fn as_side(&self) -> [u32; 8] {
        let [a, b, c, ab, bc, ca, ..] = self.nodes;
        if self.count == 6 { [a, b, c, c, ab, bc, c, ca] } else { self.nodes }
    }

    /// The straight triangles between its nodes that stand for the face, with the places of their corners on the reference triangle or
    /// square.
    pub fn parts(&self) -> Vec<([u32; 3], [Point2; 3])> {
        let (parts, places): (&[[usize; 3]], &[Point2]) =
            if self.count == 6 { (&IN_TRIANGLE, &TRIANGLE) } else { (&IN_SQUARE, &SQUARE) };
        parts.iter().map(|part| (part.map(|n| self.nodes[n]), part.map(|n| places[n]))).collect()
    }

    /// [`Self::parts`] by their nodes alone.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        self.parts().into_iter().map(|part| part.0).collect()
    }
}

const IN_TRIANGLE: [[usize; 3]; 4] = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]];
const IN_SQUARE: [[usize; 3]; 6] = [[0, 4, 7], [4, 1, 5], [5, 2, 6], [6, 3, 7], [4, 5, 6], [4, 6, 7]];
/// Places of the nodes of the reference triangle.
const TRIANGLE: [Point2; 6] = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]];
/// Places of the nodes of the reference square.
const SQUARE: [Point2; 8] =
    [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.0], [1.0, 0.5], [0.5, 1.0], [0.0, 0.5]];

/// Shape functions of the triangle of six nodes at shares (a, b, c) of its corners: a(2a−1), …, 4ab, 4bc, 4ca.
pub(crate) fn triangle_functions([a, b, c]: [f64; 3]) -> [f64; 6] {
    let corner = |s: f64| s * (2.0 * s - 1.0);
    [corner(a), corner(b), corner(c), 4.0 * a * b, 4.0 * b * c, 4.0 * c * a]
}

/// Shape functions of the face of six nodes on the reference triangle, or of eight on the reference square.
pub(crate) fn shape_functions(nodes: usize, [x, y]: Point2) -> Vec<f64> {
    if nodes == 6 {
        return triangle_functions([1.0 - x - y, x, y]).to_vec();
    }
    let linear = [(1.0 - x) * (1.0 - y), x * (1.0 - y), x * y, (1.0 - x) * y];
    let (bent_x, bent_y) = (4.0 * x * (1.0 - x), 4.0 * y * (1.0 - y));
    let middles = [bent_x * (1.0 - y), bent_y * x, bent_x * y, bent_y * (1.0 - x)];
    let corner = |n: usize| linear[n] - 0.5 * (middles[n] + middles[(n + 3) % 4]);
    (0..4).map(corner).chain(middles).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shape_functions_are_one_at_their_own_node_and_parts_cover_the_face() {
        let faces = [
            QuadraticFace::triangle([0, 1, 2, 3, 4, 5], Skin::Outer),
            QuadraticFace::quadrilateral([0, 1, 2, 3, 4, 5, 6, 7], Skin::Outer),
        ];
        for (face, whole, places) in [(faces[0], 0.5, &TRIANGLE[..]), (faces[1], 1.0, &SQUARE[..])] {
            for (node, at) in places.iter().enumerate() {
                let values = shape_functions(places.len(), *at);
                assert!(values.iter().enumerate().all(|(n, v)| (v - f64::from(u8::from(n == node))).abs() < 1e-15));
            }
            let area = |[a, b, c]: [Point2; 3]| crate::frame::doubled_area(a, b, c) / 2.0;
            let sum: f64 = face.parts().into_iter().map(|part| area(part.1)).sum();
            assert!((sum - whole).abs() < 1e-15 && face.parts().into_iter().all(|part| area(part.1) > 0.0));
        }
        assert_eq!(faces[0].as_side(), [0, 1, 2, 2, 3, 4, 2, 5]);
    }
}
