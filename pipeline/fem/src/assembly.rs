//! Elastic energy, forces and stiffness of the whole mesh, summed element by element in their order.
//!
//! Ψ(u) = Σ_e Σ_q w ψ(F),  F = I + Σ_a u_a ⊗ ∇N_a,  f_a = Σ w P ∇N_a,  K_ab = Σ w ∇N_aᵀ (∂P/∂F) ∇N_b
//!
//! Stands on: `rest`, `material`, `sparse`. Never knows: a pressure, a time step, a factor.

use crate::material::{Lame, Material, Tangent};
use crate::mesh::{Elements, Mesh};
use crate::rest::Rest;
use crate::sparse::Pattern;
use nalgebra::{Matrix3, SVector, SymmetricEigen};
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

/// In what the assembled tangent departs from K.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Bend<'a> {
    /// In nothing.
    Straight,
    /// Each point's tangent loses its negative eigenvalues.
    Convex,
    /// The stress that acts on turning edges is the one foreseen by the linear step that led here from this displacement.
    Foreseen(&'a [f64]),
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

    #[allow(non_snake_case)]
    fn powers_of<const N: usize>(
        &self,
        tets: &[[u32; N]],
        elastic: &[Elastic],
        u: &[f64],
        along: &[f64],
        other: &[f64],
    ) -> Vec<[f64; 3]> {
        let mut sums = vec![[0.0; 3]; elastic.len()];
        let (by_mu, by_lambda) = (Lame { mu: 1.0, lambda: 0.0 }, Lame { mu: 0.0, lambda: 1.0 });
        for (element, nodes) in tets.iter().enumerate() {
            let region = self.mesh.regions[element] as usize;
            let of = &elastic[region];
            let (moved, along, other) = (corners(nodes, u), corners(nodes, along), corners(nodes, other));
            let mut add = |gradients: &[Point3; N], weight: f64, counts: Lame| {
                let F = deformation(gradients, &moved);
                let mut power = |place: usize, scale: f64, change: Lame, rate: &Matrix3<f64>| {
                    if scale != 0.0 {
                        let stress = of.material.stress_change(&F, of.lame, change);
                        sums[region][place] += weight * stress.component_mul(rate).sum();
                    }
                };
                let rate = deformation(gradients, &along) - Matrix3::identity();
                power(0, counts.mu, by_mu, &rate);
                power(1, counts.lambda, by_lambda, &rate);
                let rate = deformation(gradients, &other) - Matrix3::identity();
                sums[region][2] += weight * of.material.stress(&F, counts).1.component_mul(&rate).sum();
            };
            self.each_sample::<N>(element, of, of.lame, &mut add);
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
                let stress = elastic.material.stress_change(&deformation(gradients, &moved), elastic.lame, change);
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
                let tangent = match bend {
                    Bend::Straight => material.response(&deformation(gradients, &moved), lame).tangent,
                    Bend::Convex => {
                        without_negative_part(material.response(&deformation(gradients, &moved), lame).tangent)
                    }
                    Bend::Foreseen(before) => {
                        let before = deformation(gradients, &corners(nodes, before));
                        with_foreseen_stress(material, lame, &before, &deformation(gradients, &moved))
                    }
                };
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

fn corners<const N: usize>(nodes: &[u32; N], u: &[f64]) -> [Point3; N] {
    std::array::from_fn(|a| {
        let at = 3 * nodes[a] as usize;
        [u[at], u[at + 1], u[at + 2]]
    })
}

fn deformation<const N: usize>(gradients: &[Point3; N], moved: &[Point3; N]) -> Matrix3<f64> {
    let mut columns = [[0.0; 3]; 3];
    for (gradient, moved) in gradients.iter().zip(moved) {
        for (column, slope) in columns.iter_mut().zip(gradient) {
            (0..3).for_each(|i| column[i] += moved[i] * slope);
        }
    }
    (0..3).for_each(|axis| columns[axis][axis] += 1.0);
    Matrix3::from_column_slice(columns.as_flattened())
}

fn add_force<const N: usize>(force: &mut [Point3; N], gradients: &[Point3; N], stress: &Matrix3<f64>, weight: f64) {
    let stress = stress * weight;
    for (force, gradient) in force.iter_mut().zip(gradients) {
        for (axis, slope) in gradient.iter().enumerate() {
            (0..3).for_each(|i| force[i] += stress[(i, axis)] * slope);
        }
    }
}

fn scatter<const N: usize>(nodes: &[u32; N], force: &[Point3; N], forces: &mut [f64]) {
    for (&node, force) in nodes.iter().zip(force) {
        (0..3).for_each(|axis| forces[3 * node as usize + axis] += force[axis]);
    }
}

/// Adds ∇N_aᵀ C ∇N_b for all a ≥ b; each block row by row. The inner loops run over 27 and 9 neighbouring numbers.
#[allow(non_snake_case)]
fn add_blocks<const N: usize>(blocks: &mut [[f64; 9]; 55], gradients: &[Point3; N], tangent: &Tangent) {
    let mut C = [[0.0; 27]; 3];
    for (L, C) in C.iter_mut().enumerate() {
        for (place, entry) in C.iter_mut().enumerate() {
            let (J, i, k) = (place / 9, place % 9 / 3, place % 3);
            *entry = tangent[(i + 3 * J, k + 3 * L)];
        }
    }
    for (b, right) in gradients.iter().enumerate() {
        let half: [f64; 27] = std::array::from_fn(|n| C[0][n] * right[0] + C[1][n] * right[1] + C[2][n] * right[2]);
        for (a, left) in gradients.iter().enumerate().skip(b) {
            let block = &mut blocks[a * (a + 1) / 2 + b];
            for (n, entry) in block.iter_mut().enumerate() {
                *entry += left[0] * half[n] + left[1] * half[9 + n] + left[2] * half[18 + n];
            }
        }
    }
}

/// ∂P/∂F at `now`, its stress S replaced by the one that a linear step from `before` foresees.
///
/// ∂P : δF = δF S + F (C : sym Fᵀ δF), and S is taken as S₀ + F₀⁻¹ (∂P₀ : ΔF − ΔF S₀), ΔF = F − F₀: the stress at the
/// end of a long step is spoilt by its own square terms, which a stiff thin sheet makes huge.      [magisano2017]
#[allow(non_snake_case)]
fn with_foreseen_stress(
    material: &'static dyn Material,
    lame: Lame,
    before: &Matrix3<f64>,
    now: &Matrix3<f64>,
) -> Tangent {
    let (then, here) = (material.response(before, lame), material.response(now, lame));
    let (Some(then_inverse), Some(inverse)) = (before.try_inverse(), now.try_inverse()) else {
        return here.tangent;
    };
    let step = now - before;
    let dP = then.tangent * SVector::<f64, 9>::from_column_slice(step.as_slice());
    let dP = Matrix3::from_column_slice(dP.as_slice());
    let S0 = then_inverse * then.stress;
    let foreseen = S0 + then_inverse * (dP - step * S0);
    let change = foreseen - inverse * here.stress;
    let change = (change + change.transpose()) * 0.5;
    let mut tangent = here.tangent;
    for J in 0..3 {
        for L in 0..3 {
            (0..3).for_each(|i| tangent[(i + 3 * J, i + 3 * L)] += change[(J, L)]);
        }
    }
    tangent
}

/// The nearest tangent without negative eigenvalues: Newton's direction then always descends.     [teran2005]
fn without_negative_part(tangent: Tangent) -> Tangent {
    if !tangent.iter().all(|entry| entry.is_finite()) {
        return tangent;
    }
    let eigen = SymmetricEigen::new(tangent);
    if eigen.eigenvalues.min() >= 0.0 {
        return tangent;
    }
    let kept = eigen.eigenvalues.map(|value| value.max(0.0));
    eigen.eigenvectors * Tangent::from_diagonal(&kept) * eigen.eigenvectors.transpose()
}
