//! The basis: a few shapes that span many, in units in which a body at rest is equally stiff along each.
//!
//! Proper orthogonal decomposition in the metric of the mass: the eigenvectors of the shapes' products uᵢᵀ M uⱼ. The
//! basis is then turned and scaled so that VᵀK₀V = I, so that an error of force along any coordinate weighs as the energy it is.
//!
//! Stands on: `parts`, `nalgebra`. Never knows: a quadrature point.

use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};

use super::Reduction;
use crate::body::bend::Bend;
use crate::given::Given;
use crate::parts::Parts;

/// V, and the shapes' own coordinates.
pub(super) struct Basis {
    pub modes: DMatrix<f64>,
    pub coordinates: Vec<DVector<f64>>,
}

/// The basis of `shapes` (3 a node each).
pub(super) fn draw(parts: &Parts, shapes: &[&[f64]], by: &Reduction) -> Basis {
    let free = gathered(parts, shapes);
    let pushed = product(&free, |x, y| parts.mass.multiply(&parts.pattern, x, y));
    let turn = principal(&(free.transpose() * &pushed), by);
    let (orthogonal, along) = (&free * &turn, pushed.transpose());
    let factor = stiffness_factor(parts, &orthogonal);
    let back = factor.transpose();
    let scaled = right_divided(&orthogonal, &back);
    let coordinates = (0..shapes.len()).map(|s| &back * (turn.transpose() * &free_weights(&along, &free, s))).collect();
    Basis { modes: spread(parts, &scaled), coordinates }
}

/// VᵀMV of modes of all freedoms, 3 a node.
pub(super) fn mass(parts: &Parts, modes: &DMatrix<f64>) -> DMatrix<f64> {
    let columns: Vec<&[f64]> = modes.as_slice().chunks_exact(modes.nrows()).collect();
    let free = gathered(parts, &columns);
    free.transpose() * product(&free, |x, y| parts.mass.multiply(&parts.pattern, x, y))
}

/// uᵀ M u_s over all shapes u.
fn free_weights(along: &DMatrix<f64>, free: &DMatrix<f64>, shape: usize) -> DVector<f64> {
    along * free.column(shape)
}

/// Shapes × modes: weights of the shapes in each mode of unit mass, the heaviest first.
fn principal(products: &DMatrix<f64>, by: &Reduction) -> DMatrix<f64> {
    let eigen = SymmetricEigen::new(products.clone());
    let mut order: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let least = by.least_share * eigen.eigenvalues.iter().sum::<f64>();
    let kept: Vec<usize> = order.into_iter().take(by.coordinates).filter(|i| eigen.eigenvalues[*i] > least).collect();
    let column = |i: &usize| eigen.eigenvectors.column(*i) / eigen.eigenvalues[*i].sqrt();
    DMatrix::from_columns(&kept.iter().map(column).collect::<Vec<_>>())
}

/// L with L Lᵀ = VᵀK₀V.
fn stiffness_factor(parts: &Parts, modes: &DMatrix<f64>) -> DMatrix<f64> {
    let given = Given::new(parts);
    let mut values = vec![0.0; parts.pattern.entries()];
    let rest = vec![0.0; 3 * parts.mesh.nodes.len()];
    parts.body().stiffness(&given.elastic, &rest, 1.0, Bend::Straight, &mut values);
    let stiffness = modes.transpose() * product(modes, |x, y| parts.pattern.multiply(&values, x, y));
    Cholesky::new(stiffness).expect("a held body at rest is stiff along every shape").l()
}

/// A B⁻¹ for an upper triangle B.
fn right_divided(a: &DMatrix<f64>, upper: &DMatrix<f64>) -> DMatrix<f64> {
    let lower = upper.transpose();
    lower.solve_lower_triangular(&a.transpose()).expect("a Cholesky factor has no zero on its diagonal").transpose()
}

/// The image of each column.
fn product(of: &DMatrix<f64>, multiply: impl Fn(&[f64], &mut [f64])) -> DMatrix<f64> {
    let mut image = DMatrix::zeros(of.nrows(), of.ncols());
    for column in 0..of.ncols() {
        multiply(of.column(column).as_slice(), image.column_mut(column).as_mut_slice());
    }
    image
}

/// Shapes of all freedoms as shapes of the free ones.
fn gathered(parts: &Parts, shapes: &[&[f64]]) -> DMatrix<f64> {
    let free = |shape: &&[f64]| {
        let mut free = Vec::new();
        parts.pattern.gather(shape, &mut free);
        free
    };
    DMatrix::from_iterator(parts.pattern.freedoms(), shapes.len(), shapes.iter().flat_map(free))
}

/// Modes of free freedoms as modes of all, 3 a node.
fn spread(parts: &Parts, free: &DMatrix<f64>) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(3 * parts.mesh.nodes.len(), free.ncols());
    for column in 0..free.ncols() {
        parts.pattern.spread(free.column(column).as_slice(), 1.0, all.column_mut(column).as_mut_slice());
    }
    all
}
