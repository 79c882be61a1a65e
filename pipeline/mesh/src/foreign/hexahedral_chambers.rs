//! Chambers of a body of hexahedra: the closed cavities of its skin.

use super::raw_mesh::RawMesh;
use crate::cavities::{Cavity, cavity_from_moment, moment_and_volume};
use crate::surface::connected_components;
use si::Point3;
use si::vec3::add;
use std::collections::HashMap;

/// Edges of a cube, in the order of VTK.
pub(super) const EDGES: [[usize; 2]; 12] =
    [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];

/// Corners of the sides of a cube, normals to its outside.
pub(super) const SIDES: [[usize; 4]; 6] =
    [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

/// A cavity with its walls.
#[derive(Debug, Clone, PartialEq)]
pub struct HexahedralChamber {
    /// Volume and centroid, of the polyhedron of its corners.
    pub cavity: Cavity,
    /// Corners of its sides, normals out of the solid.
    pub sides: Vec<[u32; 4]>,
}

impl RawMesh {
    /// Divides the free sides into the outer skin and the walls of cavities, which are ordered by their centroids along x, y, z.
    pub(super) fn divide_skin(
        &self,
        skin: impl Iterator<Item = [u32; 4]>,
        half: bool,
    ) -> (Vec<[u32; 4]>, Vec<HexahedralChamber>) {
        let skin: Vec<[u32; 4]> = skin.collect();
        let (component_of, count) = connected_components(skin.len(), shared_edges(&skin).into_iter());
        let mut parts: Vec<Vec<[u32; 4]>> = vec![Vec::new(); count as usize];
        skin.into_iter().zip(component_of).for_each(|(side, part)| parts[part as usize].push(side));
        let (mut outer, mut chambers) = (Vec::new(), Vec::new());
        for sides in parts {
            let cavity = self.enclosed_cavity(&sides, half);
            match cavity.volume > 0.0 {
                true => chambers.push(HexahedralChamber { cavity, sides }),
                false => outer.extend(sides),
            }
        }
        let centroid_coordinate = |chamber: &HexahedralChamber, axis: usize| chamber.cavity.centroid[axis];
        chambers.sort_by(|a, b| {
            (0..3).fold(std::cmp::Ordering::Equal, |order, k| {
                order.then(centroid_coordinate(a, k).total_cmp(&centroid_coordinate(b, k)))
            })
        });
        (outer, chambers)
    }

    /// What sides enclose on the side to which their normals point; negative for the outer skin.
    fn enclosed_cavity(&self, sides: &[[u32; 4]], half: bool) -> Cavity {
        let (mut moment, mut volume, mut cut) = ([0.0; 3], 0.0, false);
        for side in sides {
            let [a, b, c, d]: [Point3; 4] = side.map(|node| self.nodes[node as usize]);
            for triangle in [[a, b, c], [a, c, d]] {
                let part = moment_and_volume(&triangle);
                (moment, volume) = (add(moment, part.0), volume + part.1);
            }
            cut |= half && [a, b, c, d].iter().any(|place| place[2] == 0.0);
        }
        cavity_from_moment(moment, volume, cut)
    }

    /// Sides of chambers with the nodes between their corners; none of the first order, which a note says.
    pub(super) fn chamber_walls(&self, chambers: &[HexahedralChamber], notes: &mut Vec<String>) -> Vec<Vec<[u32; 8]>> {
        if self.each == 8 {
            let note = "sides of 8-node hexahedra take no pressure; save the mesh with 20 nodes for that";
            notes.extend(chambers.first().map(|_| note.to_owned()));
            return Vec::new();
        }
        let middles = self.edge_middles();
        let eight_nodes = |side: &[u32; 4]| {
            std::array::from_fn(|k| match k {
                0..4 => side[k],
                _ => middles[&in_rising_order([side[k - 4], side[(k - 3) % 4]])],
            })
        };
        chambers.iter().map(|chamber| chamber.sides.iter().map(eight_nodes).collect()).collect()
    }

    /// The node between the two ends of each edge of quadratic elements, by the edge's ends in rising order.
    fn edge_middles(&self) -> HashMap<[u32; 2], u32> {
        let edges = (0..self.len()).flat_map(|element| {
            let nodes = self.element(element);
            EDGES.iter().zip(&nodes[8..]).map(|(&[a, b], &middle)| (in_rising_order([nodes[a], nodes[b]]), middle))
        });
        edges.collect()
    }
}

/// Two node numbers in rising order.
fn in_rising_order([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Pairs of sides with a common edge.
fn shared_edges(sides: &[[u32; 4]]) -> Vec<[u32; 2]> {
    let mut side_at: HashMap<[u32; 2], u32> = HashMap::new();
    let mut pairs = Vec::new();
    for (number, side) in sides.iter().enumerate() {
        for k in 0..4 {
            let shared = side_at.insert(in_rising_order([side[k], side[(k + 1) % 4]]), number as u32);
            pairs.extend(shared.map(|other| [other, number as u32]));
        }
    }
    pairs
}
