//! Hexahedra of a file as the solid that cases are simulated on: twenty nodes an element, a skin of quadrilaterals.

use super::check::ForeignMesh;
use super::defect::MeshDefect;
use super::hexahedra::HexahedralMesh;
use super::hexahedral_chambers::EDGES;
use super::raw_mesh::RawMesh;
use crate::cavities::cavities;
use crate::{QuadraticElements, QuadraticFace, QuadraticMesh, Skin, Solid};
use si::Metre;
use si::vec3::{add, scale};
use std::collections::HashMap;

const RAISED: &str = "the file's hexahedra of 8 nodes get 20, in the middles of their straight edges: with 8 thin walls lock, and take no pressure";

impl RawMesh {
    /// [`RawMesh::check`] of hexahedra.
    pub(super) fn check_hexahedral_solid(mut self, unit: Metre, half: bool) -> Result<ForeignMesh, MeshDefect> {
        let nodes_in_file = self.nodes.len();
        let raised = (self.each == 8).then(|| self.add_middles());
        let surfaces = self.named_surfaces();
        let mut mesh = self.check_hexahedra(unit, half)?;
        mesh.numbering.truncate(nodes_in_file);
        mesh.notes.extend(raised.map(|()| RAISED.to_owned()));
        let elements = QuadraticElements::Hexahedra(mesh.twenty_nodes().collect());
        let skin = mesh.skin_of(&elements);
        let HexahedralMesh { nodes, numbers, regions, half, numbering, notes, .. } = mesh;
        let solid = Solid::Quadratic(QuadraticMesh { nodes, elements, regions: numbers, skin, half });
        Ok(ForeignMesh { cavities: cavities(&solid), solid, regions, surfaces, numbering, notes })
    }

    /// Gives elements of eight nodes the twelve between their corners, which follow the nodes of the file.
    fn add_middles(&mut self) {
        let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
        let mut corners = Vec::with_capacity(20 * self.len());
        let first_label = self.node_labels.iter().max().map_or(0, |label| label + 1);
        for nodes in std::mem::take(&mut self.corners).chunks_exact(8) {
            corners.extend(nodes);
            for [a, b] in EDGES.map(|edge| edge.map(|corner| nodes[corner])) {
                corners.push(*middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                    self.node_labels.push(first_label + self.nodes.len() as u64);
                    self.nodes.push(scale(add(self.nodes[a as usize], self.nodes[b as usize]), 0.5));
                    self.nodes.len() as u32 - 1
                }));
            }
        }
        (self.corners, self.each) = (corners, 20);
    }
}

impl HexahedralMesh {
    /// The nodes of each quadratic element; none of the first order.
    pub fn twenty_nodes(&self) -> impl Iterator<Item = [u32; 20]> {
        self.hexahedra.iter().zip(&self.middles).map(|(corners, middles)| {
            std::array::from_fn(|node| if node < 8 { corners[node] } else { middles[node - 8] })
        })
    }

    /// The sides that belong to one element alone: in the plane of a half model, of a chamber, or outer.
    fn skin_of(&self, elements: &QuadraticElements) -> Vec<QuadraticFace> {
        let mut chamber_by_side = HashMap::new();
        for (number, chamber) in self.chambers.iter().enumerate() {
            chamber_by_side.extend(chamber.sides.iter().map(|side| (in_rising_order(side), number as u16)));
        }
        let on_plane = |corners: &[u32]| self.half && corners.iter().all(|&node| self.nodes[node as usize][2] == 0.0);
        let other_side = |corners: &[u32]| match chamber_by_side.get(&in_rising_order(corners)) {
            Some(number) => Skin::Chamber(*number),
            None if on_plane(corners) => Skin::Symmetry,
            None => Skin::Outer,
        };
        let sides: Vec<QuadraticFace> = (0..elements.len()).flat_map(|element| elements.sides(element)).collect();
        let mut uses: HashMap<Vec<u32>, usize> = HashMap::new();
        sides.iter().for_each(|side| *uses.entry(in_rising_order(side.corners())).or_default() += 1);
        let mut free: Vec<QuadraticFace> =
            sides.into_iter().filter(|side| uses[&in_rising_order(side.corners())] == 1).collect();
        free.iter_mut().for_each(|side| side.on = other_side(side.corners()));
        free
    }
}

fn in_rising_order(corners: &[u32]) -> Vec<u32> {
    let mut sorted = corners.to_vec();
    sorted.sort_unstable();
    sorted
}
