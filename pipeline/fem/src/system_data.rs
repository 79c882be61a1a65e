//! Immutable data of a system, shared by all its solvers.

use crate::assembly::elastic::{Body, Elastic};
use crate::assembly::mass::{Mass, MassAssembly, ShapeProducts};
use crate::assembly::reference::ReferenceElements;
use crate::contact::SelfContact;
use crate::loads::ChamberPressure;
use crate::mesh::Mesh;
use crate::properties::{Options, RegionProperties};
use si::Metre;
use sparse::{FactorError, Pattern, Symbolic};
use std::collections::BTreeSet;
use std::sync::Arc;

/// A validated mesh with everything that no solve changes.
#[derive(Debug, Clone)]
pub(crate) struct SystemData {
    pub mesh: Mesh,
    pub regions: Vec<RegionProperties>,
    pub reference: ReferenceElements,
    /// By region, m³.
    pub volumes: Vec<f64>,
    pub pattern: Pattern,
    /// elements × pairs (a ≥ b): position of each block in the matrix.
    pub block_positions: Vec<u32>,
    pub symbolic: Arc<Symbolic>,
    pub options: Options,
    pub products: ShapeProducts,
    /// With the densities of `regions`.
    pub mass: Arc<Mass>,
    pub chambers: Vec<ChamberPressure>,
    pub contact: Option<Arc<SelfContact>>,
    /// Axes along which each node is constrained.
    pub constrained: Vec<[bool; 3]>,
    /// Pairs of nodes that contact couples.
    pub couplings: BTreeSet<(u32, u32)>,
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

    /// The same system with the pairs of nodes `further` coupled in the tangent as well: pattern, elimination order and symbolic
    /// factorisation are new, and so is every vector in elimination order.
    ///
    /// # Errors
    /// [`FactorError::Symbolic`]
    pub(crate) fn with_couplings(&self, further: &BTreeSet<(u32, u32)>) -> Result<Self, FactorError> {
        let couplings: BTreeSet<(u32, u32)> = self.couplings.union(further).copied().collect();
        let graph = self.mesh.graph().with_edges(&couplings);
        let pattern = Pattern::new(&self.mesh.nodes, &graph, &self.constrained);
        let (block_positions, symbolic) = (block_positions(&self.mesh, &pattern), Arc::new(Symbolic::new(&pattern)?));
        let mut coupled = Self { pattern, block_positions, symbolic, couplings, ..self.clone() };
        let densities: Vec<f64> = self.regions.iter().map(|region| region.density).collect();
        coupled.mass = Arc::new(Mass::new(&coupled.mass_assembly(), &densities, &self.options.masses));
        Ok(coupled)
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
