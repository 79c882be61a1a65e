//! Elastic energy, forces and stiffness of the mesh, summed element by element in a fixed order.
//!
//! Ψ(u) = Σ_e Σ_q w ψ(F),  F = I + Σ_a u_a ⊗ ∇N_a,  f_a = Σ w P ∇N_a,  K_ab = Σ w ∇N_aᵀ (∂P/∂F) ∇N_b

use crate::assembly::kernels::{
    add_blocks, add_force, deformation_gradient, displacement_gradient, element_values, scatter_forces,
};
use crate::assembly::reference::ReferenceElements;
use crate::mesh::Mesh;
use materials::material::{Material, Moduli};
use materials::symmetric::{Symmetric, full_tensor};
use materials::tangent::{PointState, TangentKind};
use nalgebra::{Matrix3, SVector};
use si::{Joule, Point3};
use sparse::Pattern;

/// The law and the constants of one region.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Elastic {
    /// The law.
    pub material: &'static dyn Material,
    /// Its constants.
    pub moduli: Moduli,
    /// Whether the λ part of the energy takes the element's mean deformation [hughes1980].
    pub mean_dilatation: bool,
}

impl Elastic {
    /// The constants that act at each quadrature point, and those that act at the element's mean deformation.
    // Mean dilatation averages the deformation of the λ part alone. Every law is linear in μ and λ, so energy, forces
    // and tangent remain those of one potential, for every law alike, and the tangent stays symmetric.
    fn split_moduli(&self, moduli: Moduli) -> (Moduli, Option<Moduli>) {
        if self.mean_dilatation { (moduli.deviatoric(), Some(moduli.volumetric())) } else { (moduli, None) }
    }
}

/// Pairs of nodes (a ≥ b) of the largest element.
const MAX_PAIRS: usize = 20 * 21 / 2;

/// The domain of assembly, and the laws and constants on it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Body<'a> {
    pub mesh: &'a Mesh,
    pub reference: &'a ReferenceElements,
    pub pattern: &'a Pattern,
    /// elements × pairs (a ≥ b): position of each block in the matrix.
    pub block_positions: &'a [u32],
    /// One per region.
    pub elastic: &'a [Elastic],
    /// Factor of the moduli of each element; empty: 1.
    pub factors: &'a [f64],
    /// H, the second Piola–Kirchhoff stress that relaxation holds in this step, of every quadrature point, Pa (see
    /// `viscoelastic`); empty: none.
    pub held: &'a [Symmetric],
    /// Factor of H in load stepping.
    pub held_factor: f64,
}

/// One sample of an element's energy.
struct Sample<'a, const N: usize> {
    /// 1/m.
    gradients: &'a [Point3; N],
    /// m³.
    weight: f64,
    /// The moduli that act here.
    moduli: Moduli,
    /// H, Pa.
    held: Option<Matrix3<f64>>,
}

/// Calls the method for the order of the elements, with the number of nodes as a constant.
macro_rules! by_order {
    ($body:ident.$method:ident($($argument:expr),*)) => {
        match $body.mesh.elements.nodes_each() {
            4 => $body.$method::<4>($($argument),*),
            8 => $body.$method::<8>($($argument),*),
            20 => $body.$method::<20>($($argument),*),
            _ => $body.$method::<10>($($argument),*),
        }
    };
}

impl Body<'_> {
    /// Ψ (J); infinite when an element is inverted and its law forbids it. Adds f to `forces` (3 per node, N).
    pub fn energy(&self, u: &[f64], forces: &mut [f64]) -> Joule {
        by_order!(self.energy_of(u, forces))
    }

    /// Adds K to the matrix `values`.
    pub fn stiffness(&self, u: &[f64], kind: TangentKind, values: &mut [f64]) {
        by_order!(self.stiffness_of(u, kind, values));
    }

    /// Adds ∂f to `forces` when the constants of `region` change by `change` at fixed u.
    pub(crate) fn force_derivative(&self, u: &[f64], region: usize, change: Moduli, forces: &mut [f64]) {
        by_order!(self.force_derivative_of(u, region, change, forces));
    }

    /// Adds the forces of one element with a factor of 1 to `forces`.
    pub(crate) fn add_element_force(&self, u: &[f64], element: usize, forces: &mut [f64]) {
        by_order!(self.add_element_force_of(u, element, forces));
    }

    /// Adds ∂f to `forces` when the nodes of the undeformed mesh move with `velocity` (3 entries per node) at fixed u.
    pub(crate) fn shape_derivative(&self, u: &[f64], velocity: &[f64], forces: &mut [f64]) {
        by_order!(self.shape_derivative_of(u, velocity, forces));
    }

    /// By element, the virtual work along `along` (3 entries per node) of ∂f at `u` by μ, λ, C₂₀ and C₃₀, with a factor
    /// of 1.
    pub(crate) fn element_work(&self, u: &[f64], along: &[f64]) -> Vec<[f64; 4]> {
        by_order!(self.element_work_of(u, along))
    }

    /// By region, the virtual work of the elastic forces: of ∂f by μ, λ, C₂₀ and C₃₀ along `along`, and of f along
    /// `other`. All vectors hold 3 entries per node.
    pub(crate) fn virtual_work(&self, u: &[f64], along: &[f64], other: &[f64]) -> Vec<([f64; 4], f64)> {
        by_order!(self.virtual_work_of(u, along, other))
    }

    /// Calls `visit` with the nodes of each element and Σ w μ F over its quadrature points.
    pub(crate) fn for_each_mean_gradient(&self, u: &[f64], visit: &mut dyn FnMut(&[u32], Matrix3<f64>)) {
        by_order!(self.for_each_mean_gradient_of(u, visit));
    }

    /// Each element with its nodes and its law.
    fn elements_with_law<const N: usize>(&self) -> impl Iterator<Item = (usize, &[u32; N], Elastic)> {
        let each = self.mesh.elements.of_order::<N>().iter().zip(&self.mesh.regions).enumerate();
        each.map(|(element, (nodes, &region))| {
            let elastic = self.elastic[region as usize];
            (element, nodes, Elastic { moduli: elastic.moduli.scaled(self.modulus_factor(element)), ..elastic })
        })
    }

    /// The factor of an element's moduli.
    fn modulus_factor(&self, element: usize) -> f64 {
        self.factors.get(element).copied().unwrap_or(1.0)
    }

    fn for_each_mean_gradient_of<const N: usize>(&self, u: &[f64], visit: &mut dyn FnMut(&[u32], Matrix3<f64>)) {
        for (element, nodes, elastic) in self.elements_with_law::<N>() {
            let displacements = element_values(nodes, u);
            let points = self.quadrature_points::<N>(element).zip(&self.reference.shares);
            let sum: Matrix3<f64> = points
                .map(|((gradients, weight), shares)| {
                    deformation_gradient(gradients, &displacements) * (weight * shares[0])
                })
                .sum();
            visit(nodes, sum * elastic.moduli.mu);
        }
    }

    /// Gradients and weight at each quadrature point of `element`.
    fn quadrature_points<const N: usize>(&self, element: usize) -> impl Iterator<Item = (&[Point3; N], f64)> {
        let first = element * self.reference.points;
        let (gradients, _) = self.reference.gradients[first * N..(first + self.reference.points) * N].as_chunks::<N>();
        gradients.iter().zip(self.reference.weights[first..].iter().copied())
    }

    /// Gradients averaged over `element`, and its volume: the sample of mean dilatation.
    fn mean_gradients<const N: usize>(&self, element: usize) -> ([Point3; N], f64) {
        let volume = self.reference.volumes[element];
        let mut mean = [[0.0; 3]; N];
        for ((gradients, weight), shares) in self.quadrature_points::<N>(element).zip(&self.reference.shares) {
            for (mean, gradient) in mean.iter_mut().zip(gradients) {
                (0..3).for_each(|axis| mean[axis] += weight * shares[1] / volume * gradient[axis]);
            }
        }
        (mean, volume)
    }

    /// Calls `visit` at every sample of `element` with the part of `moduli` that acts there.
    fn for_each_sample<const N: usize>(
        &self,
        element: usize,
        elastic: Elastic,
        moduli: Moduli,
        mut visit: impl FnMut(Sample<N>),
    ) {
        let (pointwise, mean) = elastic.split_moduli(moduli);
        let first = element * self.reference.points;
        for (point, (gradients, weight)) in self.quadrature_points::<N>(element).enumerate() {
            let [shear, bulk] = self.reference.shares[point];
            // what the past holds is of the μ part
            let held_stress =
                self.held.get(first + point).map(|held_stress| full_tensor(held_stress) * (self.held_factor * shear));
            visit(Sample { gradients, weight, moduli: pointwise.shared(shear, bulk), held: held_stress });
        }
        if let Some(moduli) = mean {
            let (gradients, weight) = self.mean_gradients::<N>(element);
            visit(Sample { gradients: &gradients, weight, moduli, held: None });
        }
    }

    fn energy_of<const N: usize>(&self, u: &[f64], forces: &mut [f64]) -> Joule {
        let mut total = 0.0;
        for (element, nodes, elastic) in self.elements_with_law::<N>() {
            let displacements = element_values(nodes, u);
            let mut force = [[0.0; 3]; N];
            self.for_each_sample::<N>(
                element,
                elastic,
                elastic.moduli,
                |Sample { gradients, weight, moduli, held }| {
                    let now = deformation_gradient(gradients, &displacements);
                    let (mut energy, mut stress) = elastic.material.energy_and_stress(&now, moduli);
                    if let Some(held) = held {
                        // The potential of the held stress, whose derivative by F is F H: a line search needs the
                        // energy, and the tangent stays symmetric.
                        energy += 0.5 * held.component_mul(&(now.tr_mul(&now) - Matrix3::identity())).sum();
                        stress += now * held;
                    }
                    total += weight * energy;
                    add_force(&mut force, gradients, &stress, weight);
                },
            );
            scatter_forces(nodes, &force, forces);
        }
        total
    }

    fn virtual_work_of<const N: usize>(
        &self,
        u: &[f64],
        virtual_field: &[f64],
        other_field: &[f64],
    ) -> Vec<([f64; 4], f64)> {
        let mut sums = vec![([0.0; 4], 0.0); self.elastic.len()];
        for (element, nodes, elastic) in self.elements_with_law::<N>() {
            let (by_moduli, by_force) = &mut sums[self.mesh.regions[element] as usize];
            let (displacements, virtual_field, other_field) =
                (element_values(nodes, u), element_values(nodes, virtual_field), element_values(nodes, other_field));
            let factor = self.modulus_factor(element);
            let every = Moduli { mu: 1.0, lambda: 1.0, stiffening: [1.0; 2] };
            self.for_each_sample::<N>(
                element,
                elastic,
                every,
                |Sample { gradients, weight, moduli: acting, .. }| {
                    let stress = elastic.material.stress_by_moduli(&deformation_gradient(gradients, &displacements));
                    let virtual_field = displacement_gradient(gradients, &virtual_field);
                    let other_field = displacement_gradient(gradients, &other_field);
                    let each =
                        stress.iter().zip(acting.to_array()).zip(elastic.moduli.to_array()).zip(by_moduli.iter_mut());
                    for (((stress, acts), modulus), sum) in each.filter(|(((_, acts), _), _)| *acts != 0.0) {
                        let stress = stress * (acts * weight);
                        *sum += factor * stress.component_mul(&virtual_field).sum();
                        *by_force += modulus * stress.component_mul(&other_field).sum();
                    }
                },
            );
        }
        sums
    }

    fn add_element_force_of<const N: usize>(&self, u: &[f64], element: usize, forces: &mut [f64]) {
        let elastic = self.elastic[self.mesh.regions[element] as usize];
        let nodes = &self.mesh.elements.of_order::<N>()[element];
        let (displacements, mut force) = (element_values(nodes, u), [[0.0; 3]; N]);
        self.for_each_sample::<N>(element, elastic, elastic.moduli, |Sample { gradients, weight, moduli, .. }| {
            let stress = elastic.material.energy_and_stress(&deformation_gradient(gradients, &displacements), moduli).1;
            add_force(&mut force, gradients, &stress, weight);
        });
        scatter_forces(nodes, &force, forces);
    }

    fn element_work_of<const N: usize>(&self, u: &[f64], virtual_field: &[f64]) -> Vec<[f64; 4]> {
        let every = Moduli { mu: 1.0, lambda: 1.0, stiffening: [1.0; 2] };
        let work = |(element, nodes, elastic): (usize, &[u32; N], Elastic)| {
            let (displacements, virtual_field) = (element_values(nodes, u), element_values(nodes, virtual_field));
            let mut sums = [0.0; 4];
            self.for_each_sample::<N>(element, elastic, every, |Sample { gradients, weight, moduli, .. }| {
                let stress = elastic.material.stress_by_moduli(&deformation_gradient(gradients, &displacements));
                let virtual_field = displacement_gradient(gradients, &virtual_field);
                for ((sum, stress), acts) in sums.iter_mut().zip(stress).zip(moduli.to_array()) {
                    *sum += acts * weight * stress.dot(&virtual_field);
                }
            });
            sums
        };
        self.elements_with_law::<N>().map(work).collect()
    }

    fn force_derivative_of<const N: usize>(&self, u: &[f64], region: usize, change: Moduli, forces: &mut [f64]) {
        let inside = |element: usize| self.mesh.regions[element] as usize == region;
        for (element, nodes, elastic) in self.elements_with_law::<N>().filter(|&(element, ..)| inside(element)) {
            let displacements = element_values(nodes, u);
            let mut force = [[0.0; 3]; N];
            let change = change.scaled(self.modulus_factor(element));
            self.for_each_sample::<N>(element, elastic, change, |Sample { gradients, weight, moduli, .. }| {
                let stress =
                    elastic.material.energy_and_stress(&deformation_gradient(gradients, &displacements), moduli).1;
                add_force(&mut force, gradients, &stress, weight);
            });
            scatter_forces(nodes, &force, forces);
        }
    }

    #[allow(non_snake_case)]
    fn shape_derivative_of<const N: usize>(&self, u: &[f64], velocity: &[f64], forces: &mut [f64]) {
        for (element, nodes, elastic) in self.elements_with_law::<N>() {
            let (displacements, velocities) = (element_values(nodes, u), element_values(nodes, velocity));
            let mut force = [[0.0; 3]; N];
            self.for_each_sample::<N>(
                element,
                elastic,
                elastic.moduli,
                |Sample { gradients, weight, moduli, .. }| {
                    let F = deformation_gradient(gradients, &displacements);
                    let L = deformation_gradient(gradients, &velocities) - Matrix3::identity();
                    let response = elastic.material.constitutive_response(&F, moduli);
                    let dF = (Matrix3::identity() - F) * L;
                    let dP = response.tangent * SVector::<f64, 9>::from_column_slice(dF.as_slice());
                    let P = response.stress;
                    let change = Matrix3::from_column_slice(dP.as_slice()) + P * L.trace() - P * L.transpose();
                    add_force(&mut force, gradients, &change, weight);
                },
            );
            scatter_forces(nodes, &force, forces);
        }
    }

    fn stiffness_of<const N: usize>(&self, u: &[f64], kind: TangentKind, values: &mut [f64]) {
        let pairs = N * (N + 1) / 2;
        for (element, nodes, elastic) in self.elements_with_law::<N>() {
            let material = elastic.material;
            let displacements = element_values(nodes, u);
            let mut blocks = [[0.0; 9]; MAX_PAIRS];
            self.for_each_sample::<N>(element, elastic, elastic.moduli, |sample| {
                let Sample { gradients, weight, moduli, held } = sample;
                let now = deformation_gradient(gradients, &displacements);
                let deformation_at = |u: &[f64]| deformation_gradient(gradients, &element_values(nodes, u));
                let state = PointState { material, moduli, F: &now, held: held.as_ref() };
                let tangent = kind.tangent(&state, deformation_at);
                add_blocks(&mut blocks[..pairs], gradients, &(tangent * weight));
            });
            let positions = &self.block_positions[element * pairs..(element + 1) * pairs];
            let mut pair = 0;
            for a in 0..N {
                for b in 0..=a {
                    let block = Matrix3::from_row_slice(&blocks[pair]);
                    self.pattern.add(values, positions[pair], (nodes[a], nodes[b]), &block);
                    pair += 1;
                }
            }
        }
    }
}
