//! Mass: what each element's shape functions share, the matrix M summed from it, and the weight of every node.
//!
//! Consistent: M_ab = ∫ ρ N_a N_b dV. Lumped: the diagonal of each element's matrix, raised to the element's mass
//! [hinton1976]; it stays positive for 10-node elements, where row sums do not. The same along each axis.
//!
//! Stands on: `rest`, `sparse`, `attached`. Never knows: a motion, a time step.

use crate::algebra::sparse::{HELD, Pattern};
use crate::attached::Masses;
use crate::body::rest::{overlap_rule, overlaps};
use crate::mesh::Mesh;
use nalgebra::Matrix3;

/// ∫ N_a N_b dV of every element: what no density changes.
#[derive(Debug)]
pub(crate) struct Overlaps {
    /// elements × pairs (a ≥ b), m³.
    pairs: Vec<f64>,
    /// Pairs of one element.
    each: usize,
}

impl Overlaps {
    /// Of every element of `mesh`; with `lumped`, all of it on the diagonal.
    pub fn new(mesh: &Mesh, lumped: bool) -> Self {
        let nodes = mesh.elements.nodes_each();
        let rule = overlap_rule(nodes);
        let each = nodes * (nodes + 1) / 2;
        let mut pairs = Vec::with_capacity(each * mesh.elements.len());
        for element in 0..mesh.elements.len() {
            let mut full = overlaps(mesh, element, &rule);
            if lumped {
                lump(&mut full, nodes);
            }
            pairs.extend((0..nodes).flat_map(|a| (0..=a).map(move |b| a * nodes + b)).map(|at| full[at]));
        }
        Self { pairs, each }
    }

    /// Hands (element, a, b, ∫ N_a N_b) to `visit` for all pairs a ≥ b of each element's own nodes.
    fn each_pair(&self, mesh: &Mesh, mut visit: impl FnMut(usize, u32, u32, f64)) {
        for (element, pairs) in self.pairs.chunks_exact(self.each).enumerate() {
            let nodes = mesh.elements.nodes(element);
            let mut pairs = pairs.iter();
            for (a, &left) in nodes.iter().enumerate() {
                for (&right, &overlap) in nodes[..=a].iter().zip(&mut pairs) {
                    visit(element, left, right, overlap);
                }
            }
        }
    }

    /// By region, ∫ (Σ_a N_a x_a) · (Σ_b N_b y_b) dV; x and y hold 3 a node.
    pub fn products(&self, mesh: &Mesh, regions: usize, x: &[f64], y: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; regions];
        let inner = |a: u32, b: u32| {
            let (a, b) = (3 * a as usize, 3 * b as usize);
            x[a] * y[b] + x[a + 1] * y[b + 1] + x[a + 2] * y[b + 2]
        };
        self.each_pair(mesh, |element, a, b, overlap| {
            let both = if a == b { 0.0 } else { inner(b, a) };
            sums[mesh.regions[element] as usize] += overlap * (inner(a, b) + both);
        });
        sums
    }

    /// Adds Σ_b ∫ N_a N_b dV x_b over the elements of `region` to `image`; both hold 3 a node.
    pub fn add_product(&self, mesh: &Mesh, region: usize, x: &[f64], image: &mut [f64]) {
        self.each_pair(mesh, |element, a, b, overlap| {
            if mesh.regions[element] as usize == region {
                for axis in 0..3 {
                    let (row, column) = (3 * a as usize + axis, 3 * b as usize + axis);
                    image[row] += overlap * x[column];
                    image[column] += if a == b { 0.0 } else { overlap * x[row] };
                }
            }
        });
    }

    /// Adds `density` ∫ N_a dV over the elements of `region` to `weights`, one a node.
    pub fn add_weights(&self, mesh: &Mesh, region: usize, density: f64, weights: &mut [f64]) {
        self.each_pair(mesh, |element, a, b, overlap| {
            if mesh.regions[element] as usize == region {
                weights[a as usize] += density * overlap;
                weights[b as usize] += if a == b { 0.0 } else { density * overlap };
            }
        });
    }
}

/// Moves all of an element's mass to its diagonal, in the proportions that the diagonal has.
fn lump(overlap: &mut [f64], nodes: usize) {
    let volume: f64 = overlap.iter().sum();
    let trace: f64 = (0..nodes).map(|a| overlap[a * nodes + a]).sum();
    for a in 0..nodes {
        for b in 0..nodes {
            overlap[a * nodes + b] *= if a == b { volume / trace } else { 0.0 };
        }
    }
}

/// Mass between free nodes, kg; held nodes carry theirs to the clamp.
#[derive(Debug)]
pub(crate) struct Mass {
    /// Lower triangle in the pattern of the stiffness matrix.
    values: Vec<f64>,
    /// Mass that gravity pulls at each node, kg.
    pub weights: Vec<f64>,
}

impl Mass {
    /// From the density of each region, kg/m³, and what is attached to nodes.
    pub fn new(
        mesh: &Mesh,
        pattern: &Pattern,
        places: &[u32],
        overlaps: &Overlaps,
        densities: &[f64],
        attached: &Masses,
    ) -> Self {
        let mut values = vec![0.0; pattern.entries()];
        let mut place = places.iter();
        overlaps.each_pair(mesh, |element, a, b, overlap| {
            let place = *place.next().unwrap_or(&HELD);
            let mass = densities[mesh.regions[element] as usize] * overlap;
            if mass != 0.0 {
                pattern.add(&mut values, place, (a, b), &(Matrix3::identity() * mass));
            }
        });
        let mut weights = vec![0.0; mesh.nodes.len()];
        for (region, &density) in densities.iter().enumerate() {
            overlaps.add_weights(mesh, region, density, &mut weights);
        }
        for (node, mass) in attached.iter() {
            let place = pattern.place(node, node).unwrap_or(HELD);
            pattern.add(&mut values, place, (node, node), &(Matrix3::identity() * mass));
            weights[node as usize] += mass;
        }
        Self { values, weights }
    }

    /// y = M x, both in elimination order.
    pub fn multiply(&self, pattern: &Pattern, x: &[f64], y: &mut [f64]) {
        pattern.multiply(&self.values, x, y);
    }

    /// Adds `scale` M to a matrix of the same pattern.
    pub fn add_to(&self, scale: f64, values: &mut [f64]) {
        values.iter_mut().zip(&self.values).for_each(|(value, mass)| *value += scale * mass);
    }
}
