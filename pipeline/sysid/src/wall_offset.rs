//! Fields that move a mesh with its walls: the offset of some walls, extended smoothly into the solid.
//!
//! A constant offset along the normals would invert the short edges beside a chamber's corners. Here each wall moves by one along its normal
//! and slides along itself: the field minimises the differences between neighbouring corners of elements,
//! Σ w_ab |V_a − V_b|² + k Σ (n · V_a − t)², with t = 1 on walls that are offset and 0 on all others.

use std::collections::BTreeMap;

use mesh::{QuadraticElements, Skin, Solid};
use nalgebra::{Matrix3, Vector3};
use si::Point3;

/// Edges of a ten-node tetrahedron and of a twenty-node hexahedron, in the order of their middles (VTK's).
const TETRAHEDRON_EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];
const HEXAHEDRON_EDGES: [[usize; 2]; 12] =
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];
/// Normals of a node's faces that differ by less than this angle are those of one smooth wall; its cosine.
const SMOOTH: f64 = 0.87;
/// k over the sum of a node's w: walls are then offset to a thousandth.
const STIFF: f64 = 1e4;
/// Residual of the conjugate gradients, and their iterations at most.
const TOLERANCE: f64 = 1e-9;
const ITERATIONS: usize = 3000;

/// What holds a node: directions, with the offset along each.
#[derive(Debug, Clone, Default)]
struct Held {
    /// Sums of normals weighted by area, and offsets.
    walls: Vec<(Vector3<f64>, f64)>,
}

/// The velocity of every node (3 entries per node, m per m of offset) where the faces of the skin that `is_offset` names by what they touch
/// and their centre (m) move out of the solid along their normals, so that the solid grows. Nodes of walls that are all at rest do not move.
pub(crate) fn wall_offset(solid: &Solid, is_offset: impl Fn(Skin, Point3) -> bool) -> Vec<f64> {
    let held = held_nodes(solid, is_offset);
    let edges = corner_edges(solid);
    let field = Smoothing::new(solid, &held, &edges).solve();
    let mut velocity: Vec<f64> = field.iter().flat_map(|v| v.iter().copied()).collect();
    for element in 0..solid.len() {
        for (middle, [a, b]) in edge_middles(solid, element) {
            for axis in 0..3 {
                velocity[3 * middle + axis] = 0.5 * (velocity[3 * a + axis] + velocity[3 * b + axis]);
            }
        }
    }
    velocity
}

/// Of an element of second order: each middle with its two corners.
fn edge_middles(solid: &Solid, element: usize) -> Vec<(usize, [usize; 2])> {
    let nodes = solid.element(element);
    let edges: &[[usize; 2]] = match solid {
        Solid::Linear(_) => &[],
        Solid::Quadratic(mesh) => match mesh.elements {
            QuadraticElements::Tetrahedra(_) => &TETRAHEDRON_EDGES,
            QuadraticElements::Hexahedra(_) => &HEXAHEDRON_EDGES,
        },
    };
    let corners = nodes.len() - edges.len();
    let middle =
        |(k, [a, b]): (usize, &[usize; 2])| (nodes[corners + k] as usize, [nodes[*a] as usize, nodes[*b] as usize]);
    // a wedge names an edge that has shrunk to a corner
    edges.iter().enumerate().map(middle).filter(|(_, [a, b])| a != b).collect()
}

/// Edges between the corners of all elements, with 1 over their length.
fn corner_edges(solid: &Solid) -> Vec<([usize; 2], f64)> {
    let mut edges = BTreeMap::new();
    for element in 0..solid.len() {
        let pairs: Vec<[usize; 2]> = match edge_middles(solid, element) {
            middles if middles.is_empty() => {
                let nodes = solid.element(element);
                TETRAHEDRON_EDGES.iter().map(|[a, b]| [nodes[*a] as usize, nodes[*b] as usize]).collect()
            }
            middles => middles.into_iter().map(|(_, pair)| pair).collect(),
        };
        for [a, b] in pairs {
            let length = (node_position(solid, a) - node_position(solid, b)).norm();
            // Springs in series: along a line of edges of unlike lengths the field is linear.
            edges.insert([a.min(b), a.max(b)], 1.0 / length);
        }
    }
    edges.into_iter().collect()
}

fn node_position(solid: &Solid, node: usize) -> Vector3<f64> {
    Vector3::from(solid.nodes()[node])
}

/// Every node of the skin with the walls that hold it.
fn held_nodes(solid: &Solid, is_offset: impl Fn(Skin, Point3) -> bool) -> BTreeMap<usize, Held> {
    let mut held: BTreeMap<usize, Held> = BTreeMap::new();
    for (nodes, on) in solid.faces() {
        let corners = if nodes.len() > 4 { &nodes[..nodes.len() / 2] } else { nodes };
        let places: Vec<Vector3<f64>> = corners.iter().map(|node| node_position(solid, *node as usize)).collect();
        let centre = places.iter().sum::<Vector3<f64>>() / places.len() as f64;
        let area = (1..places.len() - 1)
            .map(|k| (places[k] - places[0]).cross(&(places[k + 1] - places[0])))
            .sum::<Vector3<f64>>();
        let offset = f64::from(u8::from(on != Skin::Symmetry && is_offset(on, centre.into())));
        for node in corners {
            held.entry(*node as usize).or_default().add(area, offset);
        }
    }
    held
}

impl Held {
    /// Adds a face: to the wall that it continues smoothly, or as another one.
    fn add(&mut self, area: Vector3<f64>, offset: f64) {
        let continues =
            |(wall, t): &&mut (Vector3<f64>, f64)| *t == offset && wall.dot(&area) > SMOOTH * wall.norm() * area.norm();
        match self.walls.iter_mut().find(continues) {
            Some((wall, _)) => *wall += area,
            None => self.walls.push((area, offset)),
        }
    }

    /// Whether it touches no wall that is offset; the plane of symmetry alone lets nodes slide.
    fn is_at_rest(&self) -> bool {
        self.walls.iter().all(|(_, offset)| *offset == 0.0)
    }
}

/// The quadratic problem at the corners.
struct Smoothing<'a> {
    edges: &'a [([usize; 2], f64)],
    /// k Σ n nᵀ and its right side, by node.
    walls: Vec<Matrix3<f64>>,
    right: Vec<Vector3<f64>>,
    /// Σ w of each node.
    sums: Vec<f64>,
    fixed: Vec<bool>,
}

impl<'a> Smoothing<'a> {
    fn new(solid: &Solid, held: &BTreeMap<usize, Held>, edges: &'a [([usize; 2], f64)]) -> Self {
        let count = solid.nodes().len();
        let mut sums = vec![0.0; count];
        for ([a, b], weight) in edges {
            sums[*a] += weight;
            sums[*b] += weight;
        }
        let mirrored = symmetry_nodes(solid);
        let (mut walls, mut right) = (vec![Matrix3::zeros(); count], vec![Vector3::zeros(); count]);
        let mut fixed: Vec<bool> = sums.iter().map(|sum| *sum == 0.0).collect();
        for (node, held) in held {
            let only_mirrored = mirrored.get(node).is_some_and(|only| *only);
            fixed[*node] |= held.is_at_rest() && !only_mirrored;
            for (area, offset) in &held.walls {
                let normal = area.normalize();
                // Penalties and not constraints: a node of more than three walls has more conditions than components,
                // and they may contradict each other.
                walls[*node] += normal * normal.transpose() * (STIFF * sums[*node]);
                right[*node] += normal * (STIFF * sums[*node] * offset);
            }
        }
        Self { edges, walls, right, sums, fixed }
    }

    fn multiply(&self, x: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let mut image: Vec<Vector3<f64>> = x.iter().zip(&self.walls).map(|(x, wall)| wall * x).collect();
        for ([a, b], weight) in self.edges {
            let difference = (x[*a] - x[*b]) * *weight;
            image[*a] += difference;
            image[*b] -= difference;
        }
        self.with_rest(image)
    }

    fn with_rest(&self, mut field: Vec<Vector3<f64>>) -> Vec<Vector3<f64>> {
        field.iter_mut().zip(&self.fixed).filter(|(_, fixed)| **fixed).for_each(|(v, _)| *v = Vector3::zeros());
        field
    }

    /// Preconditioned conjugate gradients, with the 3 × 3 block of each node.
    fn solve(&self) -> Vec<Vector3<f64>> {
        let block = |(wall, sum): (&Matrix3<f64>, &f64)| {
            // Middles have no edges: their block is singular, and any that is finite serves, as they are fixed at zero.
            (wall + Matrix3::identity() * sum.max(f64::MIN_POSITIVE)).try_inverse().unwrap_or_else(Matrix3::identity)
        };
        let blocks: Vec<Matrix3<f64>> = self.walls.iter().zip(&self.sums).map(block).collect();
        let precondition =
            |r: &[Vector3<f64>]| -> Vec<Vector3<f64>> { r.iter().zip(&blocks).map(|(r, b)| b * r).collect() };
        let dot = |a: &[Vector3<f64>], b: &[Vector3<f64>]| a.iter().zip(b).map(|(a, b)| a.dot(b)).sum::<f64>();
        let mut x = vec![Vector3::zeros(); self.right.len()];
        let mut residual = self.with_rest(self.right.clone());
        let mut z = precondition(&residual);
        let mut direction = z.clone();
        let mut size = dot(&residual, &z);
        let enough = TOLERANCE * TOLERANCE * size;
        for _ in 0..ITERATIONS {
            if size <= enough {
                break;
            }
            let image = self.multiply(&direction);
            let part = size / dot(&direction, &image);
            x.iter_mut().zip(&direction).for_each(|(x, d)| *x += d * part);
            residual.iter_mut().zip(&image).for_each(|(r, image)| *r -= image * part);
            z = precondition(&residual);
            let next = dot(&residual, &z);
            direction.iter_mut().zip(&z).for_each(|(d, z)| *d = z + *d * (next / size));
            size = next;
        }
        x
    }
}

/// Nodes on the plane of symmetry, and whether they touch no other skin.
fn symmetry_nodes(solid: &Solid) -> BTreeMap<usize, bool> {
    let mut only: BTreeMap<usize, bool> = BTreeMap::new();
    for (nodes, on) in solid.faces() {
        for node in nodes {
            let only = only.entry(*node as usize).or_insert(true);
            *only &= on == Skin::Symmetry;
        }
    }
    only
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inflation_test::tests::{CASE, hollow};

    fn solid() -> Solid {
        let folder =
            std::env::temp_dir().join(format!("offset-{}-{:?}", std::process::id(), std::thread::current().id()));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("box.stl"), mesh::stl::write(&hollow(), 1e-3, "box")).unwrap();
        std::fs::write(folder.join("case.toml"), CASE).unwrap();
        let case = simulate::case::read(&folder.join("case.toml")).unwrap();
        let loaded = simulate::load(&case, &folder).unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        loaded.solid
    }

    /// The cavity of 40 × 6 × 12 mm becomes one whose sides are nearer by the offset, and the outside stays.
    #[test]
    fn every_wall_of_a_chamber_moves_by_the_offset_along_its_normal() {
        let solid = solid();
        let velocity = wall_offset(&solid, |on, _| matches!(on, Skin::Chamber(_)));
        for (nodes, on) in solid.faces() {
            let corners: Vec<Vector3<f64>> =
                nodes[..3].iter().map(|node| node_position(&solid, *node as usize)).collect();
            let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).normalize();
            let expected = if matches!(on, Skin::Chamber(_)) { 1.0 } else { 0.0 };
            for node in nodes {
                let v = Vector3::from_column_slice(&velocity[3 * *node as usize..3 * *node as usize + 3]);
                assert!((v.dot(&normal) - expected).abs() < 2e-3, "{on:?} {v:?} {normal:?}");
            }
        }
    }

    #[test]
    fn named_walls_move_alone() {
        let solid = solid();
        // the one at y = 9 mm
        let velocity = wall_offset(&solid, |on, centre| matches!(on, Skin::Chamber(_)) && centre[1] > 0.0089);
        for (node, [x, y, _]) in solid.nodes().iter().enumerate() {
            let v = &velocity[3 * node..3 * node + 3];
            if (y - 0.003).abs() < 1e-9 && (0.011..0.049).contains(x) {
                assert!(v[1].abs() < 1e-9, "the wall opposite is at rest");
            }
        }
        let largest = velocity.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        assert!((largest - 1.0).abs() < 2e-3, "{largest}");
    }

    #[test]
    fn nothing_moves_where_no_wall_is_named() {
        assert!(wall_offset(&solid(), |_, _| false).iter().all(|v| *v == 0.0));
    }
}
