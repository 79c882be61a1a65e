//! Immutable data of a system, shared by all its solvers.

use crate::assembly::elastic::{Body, Elastic};
use crate::assembly::mass::{Mass, MassAssembly, ShapeProducts};
use crate::assembly::reference::ReferenceElements;
use crate::loads::ChamberPressure;
use crate::mesh::Mesh;
use crate::properties::{Options, RegionProperties};
use si::Metre;
use sparse::{Pattern, Symbolic};
use std::sync::Arc;

/// A validated mesh with everything that no solve changes.
#[derive(Debug)]
pub(crate) struct SystemData {
    pub mesh: Mesh,
    pub regions: Vec<RegionProperties>,
    pub reference: ReferenceElements,
    /// By region, m³.
    pub volumes: Vec<f64>,
    pub pattern: Pattern,
    /// elements × pairs (a ≥ b): position of each block in the matrix.
    pub block_positions: Vec<u32>,
    pub symbolic: Symbolic,
    pub options: Options,
    pub products: ShapeProducts,
    /// With the densities of `regions`.
    pub mass: Arc<Mass>,
    pub chambers: Vec<ChamberPressure>,
    /// Largest side of the bounding box: the length that tolerances are relative to.
    pub size: Metre,
}

impl SystemData {
    /// The domain of assembly with the laws and constants `elastic`.
    pub fn body<'a>(&'a self, elastic: &'a [Elastic]) -> Body<'a> {
        Body {
            mesh: &self.mesh,
            reference: &self.reference,
            pattern: &self.pattern,
            block_positions: &self.block_positions,
            elastic,
            factors: &[],
            held: &[],
            held_factor: 0.0,
        }
    }

    /// What mass matrices are assembled over.
    pub(crate) fn mass_assembly(&self) -> MassAssembly<'_> {
        MassAssembly {
            mesh: &self.mesh,
            pattern: &self.pattern,
            block_positions: &self.block_positions,
            products: &self.products,
        }
    }

    /// Length of a vector with 3 entries per node.
    pub(crate) fn full_length(&self) -> usize {
        3 * self.mesh.nodes.len()
    }
}

/// elements × pairs (a ≥ b): positions of the blocks in the matrix.
pub(crate) fn block_positions(mesh: &Mesh, pattern: &Pattern) -> Vec<u32> {
    let mut positions = Vec::new();
    for element in 0..mesh.elements.len() {
        let nodes = mesh.elements.nodes(element);
        for a in 0..nodes.len() {
            for b in 0..=a {
                positions
                    .push(pattern.block_position(nodes[a], nodes[b]).expect("nodes of one element are neighbours"));
            }
        }
    }
    positions
}
