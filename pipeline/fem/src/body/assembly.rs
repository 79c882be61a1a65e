//! Elastic energy, forces and stiffness of the whole mesh, summed element by element in their order.
//!
//! Ψ(u) = Σ_e Σ_q w ψ(F),  F = I + Σ_a u_a ⊗ ∇N_a,  f_a = Σ w P ∇N_a,  K_ab = Σ w ∇N_aᵀ (∂P/∂F) ∇N_b
//!
//! Stands on: `rest`, `bend`, `kernels`, `material`, `sparse`. Never knows: a pressure, a time step, a factor.

use crate::algebra::sparse::Pattern;
use crate::body::bend::Bend;
use crate::body::kernels::{add_blocks, add_force, corners, deformation, scatter};
use crate::body::rest::Rest;
use crate::material::{Lame, Material};
use crate::mesh::{Elements, Mesh};
use nalgebra::Matrix3;
use si::{Joule, Point3};

/// The law and the constants of one region, as a solver sees them now.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Elastic {
    /// The law.
    pub material: &'static dyn Material,
    /// Its constants.
    pub lame: Lame,
    /// Whether λ weighs the element's mean deformation.
    pub mean_dilatation: bool,
}

impl Elastic {
    /// The constants that count at each point, and those that count at the element's mean deformation.
    fn shared(&self, lame: Lame) -> (Lame, Option<Lame>) {
        if self.mean_dilatation { (Lame { lambda: 0.0, ..lame }, Some(Lame { mu: 0.0, ..lame })) } else { (lame, None) }
    }
}

/// What is assembled over: all of it immutable.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Body<'a> {
    pub mesh: &'a Mesh,
    pub rest: &'a Rest,
    pub pattern: &'a Pattern,
    /// elements × pairs (a ≥ b): the place of each block in the matrix.
    pub places: &'a [u32],
}

impl Body<'_> {
    /// Ψ (J); infinite when an element is turned inside out and its law forbids it. Adds `scale` f to `forces`
    /// (3 a node, N).
    pub fn energy(&self, elastic: &[Elastic], u: &[f64], scale: f64, forces: &mut [f64]) -> Joule {
        match &self.mesh.elements {
            Elements::Linear(tets) => self.energy_of(tets, elastic, u, scale, forces),
            Elements::Quadratic(tets) => self.energy_of(tets, elastic, u, scale, forces),
        }
    }

    /// Adds `scale` K to the matrix `values`.
    pub fn stiffness(&self, elastic: &[Elastic], u: &[f64], scale: f64, bend: Bend, values: &mut [f64]) {
        match &self.mesh.elements {
            Elements::Linear(tets) => self.stiffness_of(tets, elastic, u, scale, bend, values),
            Elements::Quadratic(tets) => self.stiffness_of(tets, elastic, u, scale, bend, values),
        }
    }

    /// Adds ∂f to `forces` when the constants of `region` change by `change` at fixed u.
    pub fn force_change(&self, elastic: &[Elastic], u: &[f64], region: usize, change: Lame, forces: &mut [f64]) {
        match &self.mesh.elements {
            Elements::Linear(tets) => self.force_change_of(tets, elastic, u, region, change, forces),
            Elements::Quadratic(tets) => self.force_change_of(tets, elastic, u, region, change, forces),
        }
    }

    /// By region, how the elastic forces work along `along` per unit of μ and of λ, and along `other` as they are:
    /// (∂f/∂μ · along, ∂f/∂λ · along, f · other). All hold 3 a node.
    pub fn powers(&self, elastic: &[Elastic], u: &[f64], along: &[f64], other: &[f64]) -> Vec<[f64; 3]> {
        match &self.mesh.elements {
            Elements::Linear(tets) => self.powers_of(tets, elastic, u, along, other),
            Elements::Quadratic(tets) => self.powers_of(tets, elastic, u, along, other),
        }
    }

    /// Hands the nodes of each element and Σ w μ F over its quadrature points to `visit`.
    pub fn each_gradient(&self, elastic: &[Elastic], u: &[f64], visit: &mut dyn FnMut(&[u32], Matrix3<f64>)) {
        match &self.mesh.elements {
            Elements::Linear(tets) => self.each_gradient_of(tets, elastic, u, visit),
            Elements::Quadratic(tets) => self.each_gradient_of(tets, elastic, u, visit),
        }
    }

    fn each_gradient_of<const N: usize>(
        &self,
        tets: &[[u32; N]],
        elastic: &[Elastic],
        u: &[f64],
        visit: &mut dyn FnMut(&[u32], Matrix3<f64>),
    ) {
        for (element, nodes) in tets.iter().enumerate() {
            let moved = corners(nodes, u);
            let sum: Matrix3<f64> =
                self.points::<N>(element).map(|(gradients, weight)| deformation(gradients, &moved) * weight).sum();
            visit(nodes, sum * elastic[self.mesh.regions[element] as usize].lame.mu);
        }
    }

    /// Gradients and weight at each quadrature point of `element`.
    fn points<const N: usize>(&self, element: usize) -> impl Iterator<Item = (&[Point3; N], f64)> {
        let first = element * self.rest.points;
        let (gradients, _) = self.rest.gradients[first * N..(first + self.rest.points) * N].as_chunks::<N>();
        gradients.iter().zip(self.rest.weights[first..].iter().copied())
    }

    /// Gradients averaged over `element`, and its volume.
    fn mean<const N: usize>(&self, element: usize) -> ([Point3; N], f64) {
        let volume = self.rest.volumes[element];
        let mut mean = [[0.0; 3]; N];
        for (gradients, weight) in self.points::<N>(element) {
            for (mean, gradient) in mean.iter_mut().zip(gradients) {
                (0..3).for_each(|axis| mean[axis] += weight / volume * gradient[axis]);
            }
        }
        (mean, volume)
    }

    /// Hands every sample of `element` to `visit`: gradients, weight, and which of the constants `lame` count there.
    fn each_sample<const N: usize>(
        &self,
        element: usize,
        elastic: &Elastic,
        lame: Lame,
        mut visit: impl FnMut(&[Point3; N], f64, Lame),
    ) {
        let (pointwise, mean) = elastic.shared(lame);
        for (gradients, weight) in self.points::<N>(element) {
            visit(gradients, weight, pointwise);
        }
        if let Some(lame) = mean {
            let (gradients, volume) = self.mean::<N>(element);
            visit(&gradients, volume, lame);
        }
    }

    fn energy_of<const N: usize>(
        &self,
        tets: &[[u32; N]],
        elastic: &[Elastic],
        u: &[f64],
        scale: f64,
        forces: &mut [f64],
    ) -> Joule {
        let mut total = 0.0;
        for (element, nodes) in tets.iter().enumerate() {
            let elastic = &elastic[self.mesh.regions[element] as usize];
            let moved = corners(nodes, u);
            let mut force = [[0.0; 3]; N];
            self.each_sample::<N>(element, elastic, elastic.lame, |gradients, weight, lame| {
                let (energy, stress) = elastic.material.stress(&deformation(gradients, &moved), lame);
                total += weight * energy;
                add_force(&mut force, gradients, &stress, weight * scale);
            });
            scatter(nodes, &force, forces);
        }
        total
    }

    fn powers_of<const N: usize>(
        &self,
        tets: &[[u32; N]],
        elastic: &[Elastic],
        u: &[f64],
        along: &[f64],
        other: &[f64],
    ) -> Vec<[f64; 3]> {
        let mut sums = vec![[0.0; 3]; elastic.len()];
        for (element, nodes) in tets.iter().enumerate() {
            let region = self.mesh.regions[element] as usize;
            let of = &elastic[region];
            let (moved, along, other) = (corners(nodes, u), corners(nodes, along), corners(nodes, other));
            let mut add = |gradients: &[Point3; N], weight: f64, counts: Lame| {
                let [by_mu, by_lambda] = of.material.stress_slopes(&deformation(gradients, &moved));
                let (by_mu, by_lambda) = (by_mu * (counts.mu * weight), by_lambda * (counts.lambda * weight));
                let rate = deformation(gradients, &along) - Matrix3::identity();
                sums[region][0] += by_mu.component_mul(&rate).sum();
                sums[region][1] += by_lambda.component_mul(&rate).sum();
                let rate = deformation(gradients, &other) - Matrix3::identity();
                sums[region][2] += (by_mu * of.lame.mu + by_lambda * of.lame.lambda).component_mul(&rate).sum();
            };
            self.each_sample::<N>(element, of, Lame { mu: 1.0, lambda: 1.0 }, &mut add);
        }
        sums
    }

    fn force_change_of<const N: usize>(
        &self,
        tets: &[[u32; N]],
        elastic: &[Elastic],
        u: &[f64],
        region: usize,
        change: Lame,
        forces: &mut [f64],
    ) {
        for (element, nodes) in tets.iter().enumerate().filter(|&(at, _)| self.mesh.regions[at] as usize == region) {
            let elastic = &elastic[region];
            let moved = corners(nodes, u);
            let mut force = [[0.0; 3]; N];
            self.each_sample::<N>(element, elastic, change, |gradients, weight, change| {
                let stress = elastic.material.stress(&deformation(gradients, &moved), change).1;
                add_force(&mut force, gradients, &stress, weight);
            });
            scatter(nodes, &force, forces);
        }
    }

    fn stiffness_of<const N: usize>(
        &self,
        tets: &[[u32; N]],
        elastic: &[Elastic],
        u: &[f64],
        scale: f64,
        bend: Bend,
        values: &mut [f64],
    ) {
        let pairs = N * (N + 1) / 2;
        for (element, nodes) in tets.iter().enumerate() {
            let elastic = &elastic[self.mesh.regions[element] as usize];
            let material = elastic.material;
            let moved = corners(nodes, u);
            let mut blocks = [[0.0; 9]; 55];
            self.each_sample::<N>(element, elastic, elastic.lame, |gradients, weight, lame| {
                let now = deformation(gradients, &moved);
                let tangent = bend.tangent(material, lame, &now, |u| deformation(gradients, &corners(nodes, u)));
                add_blocks(&mut blocks, gradients, &(tangent * (weight * scale)));
            });
            let places = &self.places[element * pairs..(element + 1) * pairs];
            let mut pair = 0;
            for a in 0..N {
                for b in 0..=a {
                    let block = Matrix3::from_row_slice(&blocks[pair]);
                    self.pattern.add(values, places[pair], (nodes[a], nodes[b]), &block);
                    pair += 1;
                }
            }
        }
    }
}
