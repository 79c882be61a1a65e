//! Mass matrix: integrals of shape-function products, the matrix M of their sum, and the mass of every node.
//!
//! Consistent: M_ab = ∫ ρ N_a N_b dV. Lumped: the diagonal of each element's matrix, scaled to the element's mass
//! [hinton1976]; it stays positive for 10-node elements, where row sums do not. M is the same along each axis.

use crate::assembly::reference::{shape_product_rule, shape_products};
use crate::mesh::Mesh;
use crate::properties::Masses;
use nalgebra::{Matrix3, Vector3};
use sparse::{CONSTRAINED, Pattern};

/// ∫ N_a N_b dV of every element: the part of the mass that does not depend on densities.
#[derive(Debug, Clone)]
pub(crate) struct ShapeProducts {
    /// elements × pairs (a ≥ b), m³.
    pairs: Vec<f64>,
    /// Pairs of one element.
    each: usize,
}

impl ShapeProducts {
    /// Of every element of `mesh`; with `lumped`, on the diagonal alone.
    pub fn new(mesh: &Mesh, lumped: bool) -> Self {
        let nodes = mesh.elements.nodes_each();
        let rule = shape_product_rule(nodes);
        let each = nodes * (nodes + 1) / 2;
        let mut pairs = Vec::with_capacity(each * mesh.elements.len());
        for element in 0..mesh.elements.len() {
            let mut full = shape_products(mesh, element, &rule);
            if lumped {
                lump_mass(&mut full, nodes);
            }
            pairs.extend((0..nodes).flat_map(|a| (0..=a).map(move |b| a * nodes + b)).map(|at| full[at]));
        }
        Self { pairs, each }
    }

    /// Calls `visit` with (element, a, b, ∫ N_a N_b) for all pairs a ≥ b of each element's nodes.
    fn for_each_pair(&self, mesh: &Mesh, mut visit: impl FnMut(usize, u32, u32, f64)) {
        for (element, pairs) in self.pairs.chunks_exact(self.each).enumerate() {
            let nodes = mesh.elements.nodes(element);
            let mut pairs = pairs.iter();
            for (a, &left) in nodes.iter().enumerate() {
                for (&right, &product) in nodes[..=a].iter().zip(&mut pairs) {
                    visit(element, left, right, product);
                }
            }
        }
    }

    /// By region, ∫ (Σ_a N_a x_a) · (Σ_b N_b y_b) dV; x and y hold 3 entries per node.
    pub(crate) fn region_products(&self, mesh: &Mesh, regions: usize, x: &[f64], y: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; regions];
        let inner = |a: u32, b: u32| {
            let (a, b) = (3 * a as usize, 3 * b as usize);
            x[a] * y[b] + x[a + 1] * y[b + 1] + x[a + 2] * y[b + 2]
        };
        self.for_each_pair(mesh, |element, a, b, product| {
            let both = if a == b { 0.0 } else { inner(b, a) };
            sums[mesh.regions[element] as usize] += product * (inner(a, b) + both);
        });
        sums
    }

    /// Adds Σ_b ∫ N_a N_b dV x_b over the elements of `region` to `image`; both hold 3 entries per node.
    pub(crate) fn add_product(&self, mesh: &Mesh, region: usize, x: &[f64], image: &mut [f64]) {
        self.for_each_pair(mesh, |element, a, b, product| {
            if mesh.regions[element] as usize == region {
                for axis in 0..3 {
                    let (row, column) = (3 * a as usize + axis, 3 * b as usize + axis);
                    image[row] += product * x[column];
                    image[column] += if a == b { 0.0 } else { product * x[row] };
                }
            }
        });
    }

    /// Adds `density` ∫ N_a dV over the elements of `region` to `nodal`, one per node.
    pub(crate) fn add_nodal_mass(&self, mesh: &Mesh, region: usize, density: f64, nodal: &mut [f64]) {
        self.for_each_pair(mesh, |element, a, b, product| {
            if mesh.regions[element] as usize == region {
                nodal[a as usize] += density * product;
                nodal[b as usize] += if a == b { 0.0 } else { density * product };
            }
        });
    }
}

/// Moves all of an element's mass to its diagonal, in proportion to the diagonal.
fn lump_mass(products: &mut [f64], nodes: usize) {
    let volume: f64 = products.iter().sum();
    let trace: f64 = (0..nodes).map(|a| products[a * nodes + a]).sum();
    for a in 0..nodes {
        for b in 0..nodes {
            products[a * nodes + b] *= if a == b { volume / trace } else { 0.0 };
        }
    }
}

/// What a mass matrix is assembled over.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MassAssembly<'a> {
    pub mesh: &'a Mesh,
    pub pattern: &'a Pattern,
    /// elements × pairs (a ≥ b): position of each block in the matrix.
    pub block_positions: &'a [u32],
    pub products: &'a ShapeProducts,
}

/// Mass matrix of the free dofs, kg; the mass of constrained dofs moves with the clamp.
#[derive(Debug)]
pub(crate) struct Mass {
    /// Lower triangle in the pattern of the stiffness matrix.
    values: Vec<f64>,
    /// Mass of each node, kg: the factor of gravity in its dead force.
    pub nodal: Vec<f64>,
}

impl Mass {
    /// From the density of each region, kg/m³, and the attached masses.
    pub fn new(on: &MassAssembly, densities: &[f64], attached: &Masses) -> Self {
        let MassAssembly { mesh, pattern, block_positions, products } = *on;
        let mut values = vec![0.0; pattern.entries()];
        let mut position = block_positions.iter();
        products.for_each_pair(mesh, |element, a, b, product| {
            let position = *position.next().unwrap_or(&CONSTRAINED);
            let mass = densities[mesh.regions[element] as usize] * product;
            if mass != 0.0 {
                pattern.add(&mut values, position, (a, b), &(Matrix3::identity() * mass));
            }
        });
        let mut nodal = vec![0.0; mesh.nodes.len()];
        for (region, &density) in densities.iter().enumerate() {
            products.add_nodal_mass(mesh, region, density, &mut nodal);
        }
        for (node, mass, axes) in attached.with_inertia() {
            let position = pattern.block_position(node, node).unwrap_or(CONSTRAINED);
            let inertia = Vector3::from(axes.map(|acts| if acts { mass } else { 0.0 }));
            pattern.add(&mut values, position, (node, node), &Matrix3::from_diagonal(&inertia));
            nodal[node as usize] += mass;
        }
        Self { values, nodal }
    }

    /// y = M x, both in elimination order.
    pub(crate) fn multiply(&self, pattern: &Pattern, x: &[f64], y: &mut [f64]) {
        pattern.multiply(&self.values, x, y);
    }

    /// Adds `scale` M to a matrix of the same pattern.
    pub(crate) fn add_to(&self, scale: f64, values: &mut [f64]) {
        values.iter_mut().zip(&self.values).for_each(|(value, mass)| *value += scale * mass);
    }
}
