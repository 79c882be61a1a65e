//! Properties of a system beside its mesh: regions, options of the discretisation, attached masses.

use crate::assembly::reference::face_shape_products;
use crate::contact::Contact;
use crate::mesh::Mesh;
use crate::setup_error::SetupError;
use materials::Relaxation;
use materials::material::{Material, Moduli};
use si::{KilogramPerCubicMetre, Pascal};
use std::collections::BTreeMap;

/// Law and constants of one region.
#[derive(Debug, Clone)]
pub struct RegionProperties {
    /// The law.
    pub material: &'static dyn Material,
    /// E, Pa: the long-term modulus, which is left when all branches of `relaxation` have relaxed.
    pub youngs_modulus: Pascal,
    /// ν, no unit, below 0.5.
    pub poissons_ratio: f64,
    /// kg/m³.
    pub density: KilogramPerCubicMetre,
    /// C₂₀ and C₃₀ over C₁₀ = μ/2, no unit; without effect on laws that do not stiffen.
    pub stiffening: [f64; 2],
    /// Relaxation of the shear part.
    pub relaxation: Relaxation,
}

impl RegionProperties {
    /// A region of `material` with E (Pa), ν and density, without stiffening and relaxation.
    pub fn elastic(
        material: &'static dyn Material,
        youngs_modulus: Pascal,
        poissons_ratio: f64,
        density: KilogramPerCubicMetre,
    ) -> Self {
        let relaxation = Relaxation::default();
        Self { material, youngs_modulus, poissons_ratio, density, stiffening: [0.0; 2], relaxation }
    }

    /// The long-term moduli.
    pub fn moduli(&self) -> Moduli {
        Moduli::of(self.youngs_modulus, self.poissons_ratio).with_stiffening(self.stiffening)
    }

    /// The derivative of the long-term moduli by E, at constant ratios of stiffening; no unit.
    pub(crate) fn moduli_by_youngs_modulus(&self) -> Moduli {
        Moduli::by_youngs_modulus(self.youngs_modulus, self.poissons_ratio).with_stiffening(self.stiffening)
    }

    /// The derivative of the long-term moduli by ν, Pa.
    pub(crate) fn moduli_by_poissons_ratio(&self) -> Moduli {
        Moduli::by_poissons_ratio(self.youngs_modulus, self.poissons_ratio).with_stiffening(self.stiffening)
    }

    /// The derivative of the long-term moduli by C₂₀/C₁₀ (0) or C₃₀/C₁₀ (1), Pa.
    pub(crate) fn moduli_by_stiffening(&self, which: usize) -> Moduli {
        Moduli::unit_modulus(2 + which).scaled(0.5 * self.moduli().mu)
    }
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
    /// Of hexahedra of second order: the share of the μ part of the energy that is integrated at 3³ points instead of 2³; 0.2 where none is
    /// given. Without any, the mesh has modes that cost no energy.
    pub shear_share: Option<f64>,
    /// Attached masses.
    pub masses: Masses,
    /// Self-contact of chamber walls; without it they pass through each other.
    pub contact: Option<Contact>,
}

/// Attached masses: weights, sensors and magnets that move with nodes, kg.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Masses {
    by_node: BTreeMap<u32, f64>,
    /// Masses on threads, by node, and the axis along which each hangs.
    hanging: BTreeMap<u32, (f64, usize)>,
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

    /// Hangs `mass` (kg) on a thread along `axis` (0, 1, 2: x, y, z) from `node`, in the place of what hung there: its
    /// weight acts in full, its inertia along the thread alone. Swings across it are far slower than the body's.
    pub fn hanging(mut self, node: u32, mass: f64, axis: usize) -> Self {
        self.hanging.insert(node, (mass, axis.min(2)));
        self
    }

    /// Adds a layer of `per_area` (kg/m²) on a side of an element, 3, 4, 6 or 8 nodes of `mesh`, lumped by the diagonal of
    /// its own mass matrix, so that every nodal mass is positive.
    ///
    /// # Errors
    /// [`SetupError::NoSuchNode`], or [`SetupError::Side`] when the face has another number of nodes.
    pub fn on_face(mut self, mesh: &Mesh, face: &[u32], per_area: f64) -> Result<Self, SetupError> {
        mesh.check_side("face", face, &[3, 4, 6, 8])?;
        let products = face_shape_products(mesh, face);
        let count = face.len();
        let area: f64 = products.iter().sum();
        let trace: f64 = (0..count).map(|a| products[a * count + a]).sum();
        for (a, &node) in face.iter().enumerate() {
            self = self.on_node(node, per_area * area * products[a * count + a] / trace);
        }
        Ok(self)
    }

    /// Nodes with an attached mass, in ascending order, each with its mass in kg; those with a hanging one follow.
    pub fn iter(&self) -> impl Iterator<Item = (u32, f64)> + '_ {
        self.with_inertia().map(|(node, mass, _)| (node, mass))
    }

    /// The same with the axes along which each has inertia.
    pub(crate) fn with_inertia(&self) -> impl Iterator<Item = (u32, f64, [bool; 3])> + '_ {
        let attached = self.by_node.iter().map(|(&node, &mass)| (node, mass, [true; 3]));
        let hanging = self.hanging.iter().map(|(&node, &(mass, axis))| (node, mass, [0, 1, 2].map(|n| n == axis)));
        attached.chain(hanging)
    }
}
