//! Kept: what of a reduced body is worth keeping. All else follows from it and the system that it was reduced from.
//!
//! Stands on: `basis`, `cubature`, `volume`. Never knows: which shapes it was drawn from, a file.

use nalgebra::DMatrix;
use si::CubicMetre;

use super::volume::CubicVolume;
use super::{Reduced, ReducedError, basis, cubature};
use crate::system::System;

/// By region: numbers of quadrature points in the whole body, and weights, m³.
pub(super) type Chosen = Vec<Vec<(u32, CubicMetre)>>;

/// A reduced body without what its system knows.
#[derive(Debug, Clone, PartialEq)]
pub struct Kept {
    /// Columns of V, 3 a node, m a unit of q.
    pub modes: Vec<Vec<f64>>,
    /// By region: numbers of quadrature points in the whole body, and weights, m³.
    pub points: Vec<Vec<(u32, CubicMetre)>>,
    /// Largest |q| among the shapes that it was drawn from.
    pub size: f64,
}

impl Reduced {
    /// What [`System::restore`] makes it from again.
    pub fn kept(&self) -> Kept {
        let modes = self.modes.column_iter().map(|mode| mode.iter().copied().collect()).collect();
        Kept { modes, points: self.chosen.clone(), size: self.size }
    }
}

impl System {
    /// The reduced body that was `kept`: the same numbers as when it was reduced.
    ///
    /// # Errors
    /// [`ReducedError`] when it was kept of another system, or a region averages its dilatation.
    pub fn restore(&self, kept: &Kept) -> Result<Reduced, ReducedError> {
        let parts = &*self.parts;
        self.check_reducible()?;
        self.check_own(kept)?;
        let rows = 3 * parts.mesh.nodes.len();
        let modes = DMatrix::from_iterator(rows, kept.modes.len(), kept.modes.iter().flatten().copied());
        let mass = basis::mass(parts, &modes);
        let points = cubature::points(parts, &modes, &kept.points);
        let chambers = parts.chambers.iter().map(|chamber| CubicVolume::of(chamber, &modes, kept.size)).collect();
        Ok(Reduced { modes, mass, points, chambers, size: kept.size, chosen: kept.points.clone() })
    }

    /// # Errors
    /// [`ReducedError::Foreign`]
    fn check_own(&self, kept: &Kept) -> Result<(), ReducedError> {
        let parts = &*self.parts;
        let rows = 3 * parts.mesh.nodes.len();
        let foreign = |what: String| Err(ReducedError::Foreign { what });
        if kept.modes.is_empty() || kept.modes.iter().any(|mode| mode.len() != rows) {
            return foreign(format!("a mode of this system has {rows} numbers, 3 a node"));
        }
        if kept.points.len() != parts.regions.len() {
            return foreign(format!("points of {} regions, not of {}", kept.points.len(), parts.regions.len()));
        }
        if !(kept.size > 0.0 && kept.size.is_finite()) || kept.modes.iter().flatten().any(|v| !v.is_finite()) {
            return foreign("a number that is not finite".into());
        }
        for (region, chosen) in kept.points.iter().enumerate() {
            let own = |point: u32| {
                let element = point as usize / parts.rest.points;
                parts.mesh.regions.get(element).is_some_and(|r| *r as usize == region)
            };
            if let Some((point, _)) =
                chosen.iter().find(|(point, weight)| !own(*point) || weight.is_nan() || *weight <= 0.0)
            {
                return foreign(format!("quadrature point {point} is not one of region {region}"));
            }
        }
        Ok(())
    }
}
