//! The identified silicone one standard deviation off, along each independent direction of what identification left open.
//!
//! Whatever is predicted with the silicone is simulated with each of these as well: the squares of the changes add to the variance.

use nalgebra::{DMatrix, SymmetricEigen};

use crate::records::{Identified, Relaxation};
use diagnostics::Result;
use sysid::{Model, Viscoelastic};

/// The silicone off along each principal axis of the moduli's covariance, and of that of the branches' strengths.
///
/// # Errors
/// A [`diagnostics::Diagnostic`] when a branch is one that no solid can have.
pub(super) fn of_silicone(
    model: &Model,
    identified: &Identified,
    relaxation: &Relaxation,
) -> Result<Vec<Viscoelastic>> {
    let mut all = Vec::new();
    let moduli = &identified.uncertainty;
    for shift in axes(moduli.sigma.len(), &|i, j| moduli.on_the_same_mesh(i, j)) {
        let mut other = identified.clone();
        other.best.iter_mut().zip(&shift).for_each(|(modulus, by)| *modulus *= by.exp());
        all.push(relaxation.silicone(model, &other)?);
    }
    let sigma: Vec<f64> = relaxation.branches.iter().map(|b| b.sigma).collect();
    let count = sigma.len();
    for shift in axes(count, &|i, j| sigma[i] * sigma[j] * relaxation.correlation[i * count + j]) {
        let mut other = relaxation.clone();
        other.branches.iter_mut().zip(&shift).for_each(|(branch, by)| branch.strength *= by.exp());
        all.push(other.silicone(model, identified)?);
    }
    Ok(all)
}

/// Principal axes of a covariance, each as long as its standard deviation.
fn axes(count: usize, covariance: &dyn Fn(usize, usize) -> f64) -> Vec<Vec<f64>> {
    let split = SymmetricEigen::new(DMatrix::from_fn(count, count, covariance));
    let axis =
        |k: usize| split.eigenvectors.column(k).iter().map(|v| v * split.eigenvalues[k].max(0.0).sqrt()).collect();
    (0..count).map(axis).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axes_of_a_covariance_give_it_back() {
        let axes = axes(2, &|i, j| [[0.01, -0.024], [-0.024, 0.09]][i][j]);
        let of = |i: usize, j: usize| axes.iter().map(|a| a[i] * a[j]).sum::<f64>();
        assert!((of(0, 0) - 0.01).abs() < 1e-12 && (of(1, 1) - 0.09).abs() < 1e-12 && (of(0, 1) + 0.024).abs() < 1e-12);
    }
}
