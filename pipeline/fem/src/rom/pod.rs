//! Proper orthogonal decomposition (POD): a few modes that span many snapshots.
//!
//! In the metric of the mass, by the method of snapshots: eigenvectors of the products uᵢᵀ M uⱼ. The modes are then
//! rotated and scaled so that VᵀK₀V = I, so that a force error along any coordinate is weighted by its elastic energy.

use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};

use crate::inputs::Inputs;
use crate::system_data::SystemData;
use materials::tangent::TangentKind;

/// How far a body is reduced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReductionSettings {
    /// Coordinates at most.
    pub coordinates: usize,
    /// Modes with less than this fraction of the sum of all eigenvalues are left out, no unit.
    pub least_share: f64,
    /// Relative error of the displacements by the hyper-reduced forces over all snapshots, no unit.
    pub tolerance: f64,
}

impl Default for ReductionSettings {
    fn default() -> Self {
        // Eigenvalues are squares: modes below 1e-5 of the snapshots' amplitude are left out, long before rounding
        // (1e-8) fills them.
        Self { coordinates: 30, least_share: 1e-10, tolerance: 1e-3 }
    }
}

/// V, and the coordinates of the snapshots.
pub(super) struct Pod {
    pub modes: DMatrix<f64>,
    pub coordinates: Vec<DVector<f64>>,
}

/// The modes of `snapshots` (3 entries per node each); none where they span nothing.
pub(super) fn decompose(system: &SystemData, snapshots: &[&[f64]], settings: &ReductionSettings) -> Option<Pod> {
    let free = gather_columns(system, snapshots);
    // By the mass and not by nodes alone: a finely meshed part would count more than its volume.
    let image = image_of_columns(&free, |x, y| system.mass.multiply(&system.pattern, x, y));
    let weights = principal_weights(&(free.transpose() * &image), settings)?;
    let (orthogonal, along) = (&free * &weights, image.transpose());
    let factor = stiffness_factor(system, &orthogonal)?;
    let back = factor.transpose();
    let scaled = right_divided(&orthogonal, &back);
    let projected = |s: usize| &back * (weights.transpose() * (&along * free.column(s)));
    Some(Pod { modes: scatter_columns(system, &scaled), coordinates: (0..snapshots.len()).map(projected).collect() })
}

/// VᵀMV of modes with 3 entries per node.
pub(super) fn projected_mass(system: &SystemData, modes: &DMatrix<f64>) -> DMatrix<f64> {
    let columns: Vec<&[f64]> = modes.as_slice().chunks_exact(modes.nrows()).collect();
    let free = gather_columns(system, &columns);
    free.transpose() * image_of_columns(&free, |x, y| system.mass.multiply(&system.pattern, x, y))
}

/// Snapshots × modes: weights of the snapshots in each mode of unit mass, in descending order of the eigenvalues.
fn principal_weights(products: &DMatrix<f64>, settings: &ReductionSettings) -> Option<DMatrix<f64>> {
    if !products.iter().all(|product| product.is_finite()) {
        return None;
    }
    let eigen = SymmetricEigen::new(products.clone());
    let mut order: Vec<usize> = (0..eigen.eigenvalues.len()).collect();
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let least_eigenvalue = settings.least_share * eigen.eigenvalues.iter().sum::<f64>();
    let selected: Vec<usize> =
        order.into_iter().take(settings.coordinates).filter(|i| eigen.eigenvalues[*i] > least_eigenvalue).collect();
    let column = |i: &usize| eigen.eigenvectors.column(*i) / eigen.eigenvalues[*i].sqrt();
    (!selected.is_empty()).then(|| DMatrix::from_columns(&selected.iter().map(column).collect::<Vec<_>>()))
}

/// L with L Lᵀ = VᵀK₀V; none where that is not positive definite.
fn stiffness_factor(system: &SystemData, modes: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let inputs = Inputs::new(system);
    let mut values = vec![0.0; system.pattern.entries()];
    let undeformed = vec![0.0; 3 * system.mesh.nodes.len()];
    system.body(&inputs.elastic).stiffness(&undeformed, TangentKind::Exact, &mut values);
    let stiffness = modes.transpose() * image_of_columns(modes, |x, y| system.pattern.multiply(&values, x, y));
    // A constrained body at rest is stiff along every mode, unless a mode holds rounding alone.
    Cholesky::new(stiffness).map(|factor| factor.l())
}

/// A B⁻¹ for an upper triangle B.
fn right_divided(a: &DMatrix<f64>, upper: &DMatrix<f64>) -> DMatrix<f64> {
    let lower = upper.transpose();
    lower.solve_lower_triangular(&a.transpose()).expect("a Cholesky factor has no zero on its diagonal").transpose()
}

/// The image of each column.
fn image_of_columns(columns: &DMatrix<f64>, multiply: impl Fn(&[f64], &mut [f64])) -> DMatrix<f64> {
    let mut image = DMatrix::zeros(columns.nrows(), columns.ncols());
    for column in 0..columns.ncols() {
        multiply(columns.column(column).as_slice(), image.column_mut(column).as_mut_slice());
    }
    image
}

/// Vectors with 3 entries per node, at free dofs, as columns.
fn gather_columns(system: &SystemData, full: &[&[f64]]) -> DMatrix<f64> {
    let free = full.iter().flat_map(|column| system.pattern.gather(column));
    DMatrix::from_iterator(system.pattern.dofs(), full.len(), free)
}

/// Columns of free dofs, as columns with 3 entries per node.
fn scatter_columns(system: &SystemData, free: &DMatrix<f64>) -> DMatrix<f64> {
    let mut full = DMatrix::zeros(3 * system.mesh.nodes.len(), free.ncols());
    for column in 0..free.ncols() {
        system.pattern.scatter(free.column(column).as_slice(), 1.0, full.column_mut(column).as_mut_slice());
    }
    full
}
