//! Reduced bodies: the same nonlinear body in a few dozen coordinates, for the motions of a hundred trials.
//!
//! u = V q, with V drawn from shapes that the whole body took ([`basis`]). The elastic forces of q are summed over a few
//! hundred quadrature points, chosen and weighted so that they do the same work on V as all points do ([`cubature`]);
//! mass is projected, and the volumes of chambers are cubic in q and kept as such ([`volume`]).
//! Energy-conserving sampling and weighting: [farhat2014], [hernandez2017].
//!
//! Stands on: `body`, `loads`, `nalgebra`. Never knows: where shapes come from, a pressure in time, what surrounds a body.

mod balance;
mod basis;
mod cubature;
mod forces;
mod kept;
mod march;
mod nonnegative;
mod volume;

use nalgebra::{DMatrix, DVector};

use crate::system::System;
use basis::Basis;
use forces::{Points, Stress};
use volume::CubicVolume;

use kept::Chosen;
pub use kept::Kept;
pub use march::{Around, Drive, Moment, ReducedError, Still};

/// How far a body is reduced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reduction {
    /// Coordinates at most.
    pub coordinates: usize,
    /// Shapes are left out of the basis whose share of all kinetic energy is below this, no unit.
    pub least_share: f64,
    /// How far the forces of the chosen points may be off over all shapes, relative, no unit.
    pub tolerance: f64,
}

impl Default for Reduction {
    fn default() -> Self {
        Self { coordinates: 30, least_share: 1e-10, tolerance: 1e-3 }
    }
}

/// A body in r coordinates.
#[derive(Debug)]
pub struct Reduced {
    /// V, (3 a node) × r, m a unit of q.
    modes: DMatrix<f64>,
    /// r × r, kg m² in the units of q.
    mass: DMatrix<f64>,
    /// One a region.
    points: Vec<Points>,
    /// One a chamber.
    chambers: Vec<CubicVolume>,
    /// Largest |q| among the shapes that it was drawn from.
    size: f64,
    /// Where its points lie, as they are kept.
    chosen: Chosen,
}

impl System {
    /// Reduces the body to coordinates drawn from `shapes`: displacements (3 a node, m) that it takes under loads like those
    /// to come, the shapes at rest left out.
    ///
    /// # Errors
    /// [`ReducedError`] when shapes are missing, are not of this system, or a region averages its dilatation.
    pub fn reduce(&self, shapes: &[&[f64]], by: &Reduction) -> Result<Reduced, ReducedError> {
        let parts = &*self.parts;
        let right = 3 * parts.mesh.nodes.len();
        if shapes.is_empty() || shapes.iter().any(|shape| shape.len() != right) {
            return Err(ReducedError::Shapes { count: shapes.len(), right });
        }
        self.check_reducible()?;
        let Basis { modes, coordinates } = basis::draw(parts, shapes, by);
        let points = cubature::choose(parts, &modes, &coordinates, by.tolerance);
        let size = coordinates.iter().flat_map(|q| q.iter()).fold(0.0, |most: f64, q| most.max(q.abs()));
        let modes = modes.column_iter().map(|mode| mode.iter().copied().collect()).collect();
        self.restore(&Kept { modes, points, size })
    }

    /// # Errors
    /// [`ReducedError::MeanDilatation`]
    fn check_reducible(&self) -> Result<(), ReducedError> {
        if self.parts.options.mean_dilatation.contains(&true) { Err(ReducedError::MeanDilatation) } else { Ok(()) }
    }
}

impl Reduced {
    /// r.
    pub fn coordinates(&self) -> usize {
        self.modes.ncols()
    }

    /// Quadrature points that were chosen, by region.
    pub fn points(&self) -> Vec<usize> {
        self.points.iter().map(Points::count).collect()
    }

    /// Displacements V q, 3 a node, m.
    pub fn displacement(&self, q: &DVector<f64>) -> Vec<f64> {
        (&self.modes * q).data.into()
    }

    /// Rows of V: how far each coordinate moves freedom `freedom` (3 node + axis), m.
    pub fn row(&self, freedom: usize) -> impl Iterator<Item = f64> + '_ {
        self.modes.row(freedom).into_iter().copied().collect::<Vec<_>>().into_iter()
    }

    /// Elastic forces ∂Ψ/∂q (J) at q, each region's moduli `scale`d (no unit).
    ///
    /// # Panics
    /// When there is not one scale a region.
    pub fn elastic_forces(&self, q: &DVector<f64>, scale: &[f64]) -> DVector<f64> {
        assert_eq!(scale.len(), self.points.len(), "one scale a region");
        let mut forces = DVector::zeros(self.coordinates());
        self.points.iter().zip(scale).for_each(|(points, scale)| points.add_forces(q, *scale, &mut forces));
        forces
    }

    /// ∂²Ψ/∂q² (J) at q, each region's moduli `scale`d, with this `stress`.
    fn stiffness(&self, q: &DVector<f64>, stress: Stress, scale: &[f64]) -> DMatrix<f64> {
        let r = self.coordinates();
        let mut stiffness = DMatrix::zeros(r, r);
        self.points
            .iter()
            .zip(scale)
            .for_each(|(points, scale)| points.add_stiffness(q, stress, *scale, &mut stiffness));
        stiffness
    }

    /// Volume of `chamber` at q, m³; of a half model, of the half.
    ///
    /// # Panics
    /// When there is no such chamber.
    pub fn chamber_volume(&self, chamber: usize, q: &DVector<f64>) -> si::CubicMetre {
        self.chambers[chamber].at(q)
    }
}

#[cfg(test)]
mod tests;
