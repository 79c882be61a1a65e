//! Properties of a system beside its mesh: regions, options of the discretisation, attached masses.

use crate::assembly::reference::triangle_shape_products;
use crate::material::Material;
use crate::mesh::Mesh;
use si::{KilogramPerCubicMetre, Pascal};
use std::collections::BTreeMap;

/// Law and constants of one region.
#[derive(Debug, Clone, Copy)]
pub struct RegionProperties {
    /// The law.
    pub material: &'static dyn Material,
    /// E, Pa.
    pub youngs_modulus: Pascal,
    /// ν, no unit, below 0.5.
    pub poissons_ratio: f64,
    /// kg/m³.
    pub density: KilogramPerCubicMetre,
}

/// Options of the discretisation; the default is none of them.
///
/// What may change from solve to solve (moduli, densities, forces, gravity, sealed gas) is set on the [`crate::Solver`]
/// instead.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Options {
    /// Lumped (diagonal) instead of consistent mass.
    pub lumped_mass: bool,
    /// By region: mean dilatation \[hughes1980\]. The λ part of the energy takes each element's mean deformation instead
    /// of each point's, against volumetric locking of 10-node elements close to ν = 0.5. It has no effect on 4-node
    /// elements, which have a single point. Regions beyond the list do without.
    pub mean_dilatation: Vec<bool>,
    /// Attached masses.
    pub masses: Masses,
}

/// Attached masses: weights, sensors and magnets that move with nodes, kg.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Masses {
    by_node: BTreeMap<u32, f64>,
}

impl Masses {
    /// Nothing attached.
    pub fn none() -> Self {
        Self::default()
    }

    /// Adds `mass` (kg) at `node`.
    pub fn on_node(mut self, node: u32, mass: f64) -> Self {
        *self.by_node.entry(node).or_insert(0.0) += mass;
        self
    }

    /// Adds a layer of `per_area` (kg/m²) on a side of an element, 3 or 6 nodes of `mesh`, lumped by the diagonal of
    /// its own mass matrix, so that every nodal mass is positive.
    ///
    /// # Panics
    /// When a node does not exist.
    pub fn on_face(mut self, mesh: &Mesh, face: &[u32], per_area: f64) -> Self {
        let products = triangle_shape_products(mesh, face);
        let count = face.len();
        let area: f64 = products.iter().sum();
        let trace: f64 = (0..count).map(|a| products[a * count + a]).sum();
        for (a, &node) in face.iter().enumerate() {
            self = self.on_node(node, per_area * area * products[a * count + a] / trace);
        }
        self
    }

    /// Nodes with an attached mass, in ascending order, each with its mass in kg.
    pub fn iter(&self) -> impl Iterator<Item = (u32, f64)> + '_ {
        self.by_node.iter().map(|(&node, &mass)| (node, mass))
    }
}
