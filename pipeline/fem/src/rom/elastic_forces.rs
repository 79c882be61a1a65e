//! Elastic forces of a reduced model, summed over sampled quadrature points of one region.
//!
//! F = I + G q at each point, with G (9 × r) stored; f = Σ w Gᵀ P(F), K = Σ w Gᵀ (∂P/∂F) G.

use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::{DMatrix, DVector, Matrix3, OMatrix};

use crate::assembly::elastic::Elastic;
use materials::material::{Moduli, Tangent};
use materials::symmetric::{Symmetric, full_tensor};
use materials::tangent::{PointState, TangentKind};

/// G, 9 × r: derivative of F by each coordinate, columns of F one below the other.
pub(super) type ModeGradient = OMatrix<f64, nalgebra::U9, nalgebra::Dyn>;

/// What acts at the points of one region in one step.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ActingRegion {
    /// Those of the law, with damping and relaxation.
    pub moduli: Moduli,
    /// H of each point, Pa; empty: none.
    pub held: Vec<Symmetric>,
}

/// Kind of tangent (see `assembly::tangent`).
#[derive(Debug, Clone, Copy)]
pub(super) enum ReducedTangent<'a> {
    /// The exact tangent.
    Exact,
    /// The mixed-integration-point tangent of the linear step from these coordinates.
    MixedPoint(&'a DVector<f64>),
    /// The tangent with the stress at these coordinates.
    FormerStress(&'a DVector<f64>),
    /// The positive semi-definite part at each point.
    Convex,
}

/// Sampled points of one region that integrate the same shares of its energy: all of them in tetrahedra, two groups in hexahedra of second
/// order (`assembly::reference`).
#[derive(Debug)]
pub(super) struct Points {
    pub region: usize,
    /// Of the μ and the λ part of the energy.
    shares: [f64; 2],
    /// The region's law, with these shares of its moduli.
    elastic: Elastic,
    /// points, m³.
    weights: Vec<f64>,
    /// r × (points × 9): Gᵀ of all points side by side, so that a sum over points reads them once.
    gradients: DMatrix<f64>,
}

/// Points whose tangents are summed by one matrix product.
// Sixteen points of forty coordinates are 46 kB, which stay near the processor from their image to their product.
const BLOCK: usize = 16;

impl Points {
    /// Of a region with its law, the `shares` of its moduli, and the weight (m³) and G of each of its points; `r` coordinates.
    pub fn new((region, elastic): (usize, Elastic), shares: [f64; 2], at: &[(f64, ModeGradient)], r: usize) -> Self {
        let elastic = Elastic { moduli: elastic.moduli.shared(shares[0], shares[1]), ..elastic };
        let mut gradients = DMatrix::zeros(r, 9 * at.len());
        for (point, (_, of_point)) in at.iter().enumerate() {
            gradients.columns_mut(9 * point, 9).copy_from(&of_point.transpose());
        }
        Self { region, shares, elastic, weights: at.iter().map(|(weight, _)| *weight).collect(), gradients }
    }

    /// The law and its constants.
    pub(super) fn elastic(&self) -> &Elastic {
        &self.elastic
    }

    /// What acts where the region has these moduli.
    pub(super) fn acting(&self, moduli: Moduli) -> ActingRegion {
        ActingRegion { moduli: moduli.shared(self.shares[0], self.shares[1]), held: Vec::new() }
    }

    /// points, m³.
    pub(super) fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// points × 9 × r.
    pub(super) fn gradients(&self) -> &[f64] {
        self.gradients.as_slice()
    }

    /// Calls `visit` with F of each point.
    pub(super) fn for_each_deformation(&self, q: &DVector<f64>, mut visit: impl FnMut(&Matrix3<f64>)) {
        self.weighted_gradients().for_each(|(_, gradients)| visit(&deformation_at_point(gradients, q)));
    }

    /// Weight and Gᵀ of each point, 9 columns of r one below the other.
    fn weighted_gradients(&self) -> impl Iterator<Item = (f64, &[f64])> {
        self.weights.iter().copied().zip(self.gradients.as_slice().chunks_exact(9 * self.gradients.nrows()))
    }

    /// Adds f, J.
    pub(super) fn add_forces(&self, q: &DVector<f64>, acting: &ActingRegion, forces: &mut DVector<f64>) {
        for (point, (weight, gradients)) in self.weighted_gradients().enumerate() {
            let now = deformation_at_point(gradients, q);
            let (_, mut stress) = self.elastic.material.energy_and_stress(&now, acting.moduli);
            acting.held.get(point).iter().for_each(|held| stress += now * full_tensor(held));
            add_point_force(&(stress * weight), gradients, forces.as_mut_slice());
        }
    }

    /// Adds K, J.
    pub(super) fn add_stiffness(
        &self,
        q: &DVector<f64>,
        kind: ReducedTangent,
        acting: &ActingRegion,
        stiffness: &mut DMatrix<f64>,
    ) {
        let (kind, previous) = match kind {
            ReducedTangent::Exact => (TangentKind::Exact, q),
            ReducedTangent::Convex => (TangentKind::Convex, q),
            ReducedTangent::MixedPoint(previous) => (TangentKind::MixedPoint(&[]), previous),
            ReducedTangent::FormerStress(previous) => (TangentKind::FormerStress(&[]), previous),
        };
        let r = q.len();
        let (mut half, mut image) = (vec![0.0; r * r], vec![0.0; 9 * r * BLOCK]);
        let points: Vec<(usize, (f64, &[f64]))> = self.weighted_gradients().enumerate().collect();
        for (block, gradients) in points.chunks(BLOCK).zip(self.gradients.as_slice().chunks(9 * r * BLOCK)) {
            let image = &mut image[..gradients.len()];
            for ((point, (weight, gradients)), image) in block.iter().zip(image.chunks_exact_mut(9 * r)) {
                let now = deformation_at_point(gradients, q);
                let held = acting.held.get(*point).map(full_tensor);
                let previous_gradient = |_: &[f64]| deformation_at_point(gradients, previous);
                let (material, moduli) = (self.elastic.material, acting.moduli);
                let state = PointState { material, moduli, F: &now, held: held.as_ref() };
                let tangent = kind.tangent(&state, previous_gradient);
                multiply_tangent(&(tangent * *weight), gradients, image);
            }
            add_lower(gradients, image, &mut half);
        }
        for (row, column) in (0..r).flat_map(|column| (0..r).map(move |row| (row, column))) {
            stiffness[(row, column)] += half[row.min(column) * r + row.max(column)];
        }
    }
}

/// Rows of Gᵀ C that are computed at once: as many as a vector register holds.
const ROWS: usize = 8;

/// `image` = Gᵀ C of one point; both 9 columns of r, one below the other.
fn multiply_tangent(tangent: &Tangent, gradients: &[f64], image: &mut [f64]) {
    let r = gradients.len() / 9;
    let whole_rows = r - r % ROWS;
    (0..whole_rows).step_by(ROWS).for_each(|first| multiply_tangent_rows::<ROWS>(tangent, gradients, first, image));
    (whole_rows..r).for_each(|row| multiply_tangent_rows::<1>(tangent, gradients, row, image));
}

/// N rows of the same, from row `first` on: read once, written once.
fn multiply_tangent_rows<const N: usize>(tangent: &Tangent, gradients: &[f64], first: usize, image: &mut [f64]) {
    let r = gradients.len() / 9;
    let rows: [[f64; N]; 9] = std::array::from_fn(|k| std::array::from_fn(|i| gradients[k * r + first + i]));
    for (column, image) in tangent.column_iter().zip(image.chunks_exact_mut(r)) {
        let mut sums = [0.0; N];
        for (factor, row) in column.iter().zip(&rows) {
            (0..N).for_each(|i| sums[i] += factor * row[i]);
        }
        image[first..first + N].copy_from_slice(&sums);
    }
}

/// Adds the lower half of A Bᵀ, which is symmetric, to `sum`; A and B are columns of r, one below the other.
#[allow(non_snake_case)]
fn add_lower(A: &[f64], B: &[f64], sum: &mut [f64]) {
    let r = sum.len().isqrt();
    let matrix = |columns| MatRef::from_column_major_slice(columns, r, A.len() / r);
    let sum = MatMut::from_column_major_slice_mut(sum, r, r);
    let (low, whole) = (BlockStructure::TriangularLower, BlockStructure::Rectangular);
    triangular::matmul(sum, low, Accum::Add, matrix(A), whole, matrix(B).transpose(), whole, 1.0, Par::Seq);
}

/// Adds Gᵀ P of one point, whose Gᵀ is 9 columns of r one below the other, to `forces`.
#[allow(non_snake_case)]
fn add_point_force(P: &Matrix3<f64>, gradients: &[f64], forces: &mut [f64]) {
    let r = forces.len();
    let whole_rows = r - r % ROWS;
    (0..whole_rows).step_by(ROWS).for_each(|first| add_point_force_rows::<ROWS>(P, gradients, first, forces));
    (whole_rows..r).for_each(|row| add_point_force_rows::<1>(P, gradients, row, forces));
}

/// N rows of the same, from row `first` on.
#[allow(non_snake_case)]
fn add_point_force_rows<const N: usize>(P: &Matrix3<f64>, gradients: &[f64], first: usize, forces: &mut [f64]) {
    let r = forces.len();
    let mut sums: [f64; N] = std::array::from_fn(|i| forces[first + i]);
    for (factor, column) in P.iter().zip(gradients.chunks_exact(r)) {
        let gradients = &column[first..first + N];
        (0..N).for_each(|i| sums[i] += factor * gradients[i]);
    }
    forces[first..first + N].copy_from_slice(&sums);
}

/// Partial sums of G q, so that it vectorises; always in the same order.
const LANES: usize = 4;

/// F = I + G q of one point, whose Gᵀ is 9 columns of r, one below the other.
fn deformation_at_point(gradients: &[f64], q: &DVector<f64>) -> Matrix3<f64> {
    let (r, q) = (q.len(), q.as_slice());
    let mut sums = [[0.0; LANES]; 9];
    let whole_lanes = r - r % LANES;
    for first in (0..whole_lanes).step_by(LANES) {
        let part = &q[first..first + LANES];
        for (sums, column) in sums.iter_mut().zip(gradients.chunks_exact(r)) {
            let gradients = &column[first..first + LANES];
            (0..LANES).for_each(|i| sums[i] += gradients[i] * part[i]);
        }
    }
    let remainder =
        |column: &[f64]| column[whole_lanes..].iter().zip(&q[whole_lanes..]).map(|(a, b)| a * b).sum::<f64>();
    let change =
        sums.iter().zip(gradients.chunks_exact(r)).map(|(sums, column)| sums.iter().sum::<f64>() + remainder(column));
    Matrix3::from_iterator(change) + Matrix3::identity()
}

/// F = I + G q
#[allow(non_snake_case)]
pub(super) fn mode_deformation(G: &ModeGradient, q: &DVector<f64>) -> Matrix3<f64> {
    Matrix3::from_column_slice((G * q).as_slice()) + Matrix3::identity()
}
