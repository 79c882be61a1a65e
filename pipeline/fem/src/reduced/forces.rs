//! Elastic forces of a reduced body, summed over the chosen quadrature points of one region.
//!
//! F = I + G q at each point, with G (9 × r) kept; f = Σ w Gᵀ P(F), K = Σ w Gᵀ (∂P/∂F) G.
//!
//! Stands on: `material`, `bend`, `nalgebra`, `faer`'s dense products. Never knows: how points were chosen.

use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, MatMut, MatRef, Par};
use nalgebra::{DMatrix, DVector, Matrix3, OMatrix};

use crate::body::assembly::Elastic;
use crate::body::bend::Bend;
use crate::material::{Lame, Tangent};

/// 9 × r: how F changes with each coordinate, columns of F one below the other.
pub(super) type Slopes = OMatrix<f64, nalgebra::U9, nalgebra::Dyn>;

/// Which stress acts on turning edges in a tangent (see `bend`).
#[derive(Debug, Clone, Copy)]
pub(super) enum Stress<'a> {
    /// The present one: the exact tangent.
    #[cfg(test)]
    Present,
    /// The one that a linear step from these coordinates foresees.
    ForeseenFrom(&'a DVector<f64>),
    /// The present one, each point's tangent without its negative part.
    Convex,
}

/// The chosen points of one region.
#[derive(Debug)]
pub(super) struct Points {
    /// Its law and constants.
    elastic: Elastic,
    /// points, m³.
    weights: Vec<f64>,
    /// r × (points × 9): Gᵀ of each point beside the other, so that a sum over points passes over them once.
    slopes: DMatrix<f64>,
}

/// Points whose tangents are summed at once.
const BLOCK: usize = 16;

impl Points {
    /// Of a region with the weight (m³) and G of each of its points; `r` coordinates.
    pub fn new(elastic: Elastic, at: &[(f64, Slopes)], r: usize) -> Self {
        let mut slopes = DMatrix::zeros(r, 9 * at.len());
        for (point, (_, of_point)) in at.iter().enumerate() {
            slopes.columns_mut(9 * point, 9).copy_from(&of_point.transpose());
        }
        Self { elastic, weights: at.iter().map(|(weight, _)| *weight).collect(), slopes }
    }

    pub fn count(&self) -> usize {
        self.weights.len()
    }

    fn lame(&self, scale: f64) -> Lame {
        Lame { mu: scale * self.elastic.lame.mu, lambda: scale * self.elastic.lame.lambda }
    }

    /// Weight and Gᵀ of each point, 9 columns of r one below the other.
    fn each(&self) -> impl Iterator<Item = (f64, &[f64])> {
        self.weights.iter().copied().zip(self.slopes.as_slice().chunks_exact(9 * self.slopes.nrows()))
    }

    /// Adds f, J.
    pub fn add_forces(&self, q: &DVector<f64>, scale: f64, forces: &mut DVector<f64>) {
        let lame = self.lame(scale);
        for (weight, slopes) in self.each() {
            let (_, stress) = self.elastic.material.stress(&gradient(slopes, q), lame);
            pull(&(stress * weight), slopes, forces.as_mut_slice());
        }
    }

    /// Adds K, J.
    pub fn add_stiffness(&self, q: &DVector<f64>, stress: Stress, scale: f64, stiffness: &mut DMatrix<f64>) {
        let (bend, before) = match stress {
            #[cfg(test)]
            Stress::Present => (Bend::Straight, q),
            Stress::Convex => (Bend::Convex, q),
            Stress::ForeseenFrom(before) => (Bend::Foreseen(&[]), before),
        };
        let (lame, r) = (self.lame(scale), q.len());
        let (mut half, mut image) = (vec![0.0; r * r], vec![0.0; 9 * r * BLOCK]);
        let all: Vec<(f64, &[f64])> = self.each().collect();
        for (block, slopes) in all.chunks(BLOCK).zip(self.slopes.as_slice().chunks(9 * r * BLOCK)) {
            let image = &mut image[..slopes.len()];
            for ((weight, slopes), image) in block.iter().zip(image.chunks_exact_mut(9 * r)) {
                let now = gradient(slopes, q);
                let tangent = bend.tangent(self.elastic.material, lame, &now, |_| gradient(slopes, before));
                mix(&(tangent * *weight), slopes, image);
            }
            add_lower(slopes, image, &mut half);
        }
        for (row, column) in (0..r).flat_map(|column| (0..r).map(move |row| (row, column))) {
            stiffness[(row, column)] += half[row.min(column) * r + row.max(column)];
        }
    }
}

/// Rows of Gᵀ C that are made at once: as many as a wide register holds.
const ROWS: usize = 8;

/// `image` = Gᵀ C of one point; both 9 columns of r, one below the other.
fn mix(tangent: &Tangent, slopes: &[f64], image: &mut [f64]) {
    let r = slopes.len() / 9;
    let whole = r - r % ROWS;
    (0..whole).step_by(ROWS).for_each(|first| mix_rows::<ROWS>(tangent, slopes, first, image));
    (whole..r).for_each(|row| mix_rows::<1>(tangent, slopes, row, image));
}

/// N rows of that, from row `first` on: read once, written once.
fn mix_rows<const N: usize>(tangent: &Tangent, slopes: &[f64], first: usize, image: &mut [f64]) {
    let r = slopes.len() / 9;
    let rows: [[f64; N]; 9] = std::array::from_fn(|k| std::array::from_fn(|i| slopes[k * r + first + i]));
    for (column, image) in tangent.column_iter().zip(image.chunks_exact_mut(r)) {
        let mut sums = [0.0; N];
        for (share, row) in column.iter().zip(&rows) {
            (0..N).for_each(|i| sums[i] += share * row[i]);
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
fn pull(P: &Matrix3<f64>, slopes: &[f64], forces: &mut [f64]) {
    let r = forces.len();
    let whole = r - r % ROWS;
    (0..whole).step_by(ROWS).for_each(|first| pull_rows::<ROWS>(P, slopes, first, forces));
    (whole..r).for_each(|row| pull_rows::<1>(P, slopes, row, forces));
}

/// N rows of that, from row `first` on.
#[allow(non_snake_case)]
fn pull_rows<const N: usize>(P: &Matrix3<f64>, slopes: &[f64], first: usize, forces: &mut [f64]) {
    let r = forces.len();
    let mut sums: [f64; N] = std::array::from_fn(|i| forces[first + i]);
    for (share, column) in P.iter().zip(slopes.chunks_exact(r)) {
        let slopes = &column[first..first + N];
        (0..N).for_each(|i| sums[i] += share * slopes[i]);
    }
    forces[first..first + N].copy_from_slice(&sums);
}

/// Entries of q whose share in F is summed side by side; always in the same order.
const LANES: usize = 4;

/// F = I + G q of one point, whose Gᵀ is 9 columns of r, one below the other.
fn gradient(slopes: &[f64], q: &DVector<f64>) -> Matrix3<f64> {
    let (r, q) = (q.len(), q.as_slice());
    let mut sums = [[0.0; LANES]; 9];
    let whole = r - r % LANES;
    for first in (0..whole).step_by(LANES) {
        let part = &q[first..first + LANES];
        for (sums, column) in sums.iter_mut().zip(slopes.chunks_exact(r)) {
            let slopes = &column[first..first + LANES];
            (0..LANES).for_each(|i| sums[i] += slopes[i] * part[i]);
        }
    }
    let rest = |column: &[f64]| column[whole..].iter().zip(&q[whole..]).map(|(a, b)| a * b).sum::<f64>();
    let change = sums.iter().zip(slopes.chunks_exact(r)).map(|(sums, column)| sums.iter().sum::<f64>() + rest(column));
    Matrix3::from_iterator(change) + Matrix3::identity()
}

/// F = I + G q
#[allow(non_snake_case)]
pub(super) fn deformation(G: &Slopes, q: &DVector<f64>) -> Matrix3<f64> {
    Matrix3::from_column_slice((G * q).as_slice()) + Matrix3::identity()
}
