//! A model in reduced coordinates, in which long motions are integrated; the error is measured against the full model.

use std::sync::Arc;

use fem::{
    Actuation, DynamicSettings, ExternalForce, NoForce, ReducedModel, ReducedModelData, ReducedMotion, Relaxation,
};
use nalgebra::{DMatrix, DVector};
use si::{Pascal, Point2, Second};

use crate::model::{BODY, Model, Viscoelastic};
use diagnostics::{Diagnostic, Result};

/// A model with its moduli in reduced coordinates.
pub struct ReducedBody {
    reduced: Arc<ReducedModel>,
    /// Moduli over those that the system was made with.
    scale: Vec<f64>,
    /// Of body and spine.
    relaxation: Vec<Relaxation>,
    /// Ratios of stiffening by region.
    stiffening: Vec<[f64; 2]>,
    /// Displacement of each marker in the plane by coordinate, m: markers × 2 × coordinates.
    rows: Vec<[Vec<f64>; 2]>,
}

/// A motion from rest forced by the chambers' pressures.
#[derive(Clone, Copy)]
pub struct ForcedMotion<'a> {
    /// Settings of the time integration.
    pub settings: &'a DynamicSettings,
    /// One pressure a chamber (Pa) at a time (s from the start).
    pub pressures: &'a dyn Fn(Second) -> Vec<Pascal>,
    /// Ends of the time steps, rising, s from the start.
    pub times: &'a [Second],
}

/// Ends of `steps` equal time steps, s.
pub fn even_times(step: Second, steps: usize) -> Vec<Second> {
    (1..=steps).map(|i| i as f64 * step).collect()
}

impl ReducedBody {
    /// Restores a reduced `model` from its data, with the `silicone`'s constants and the model's markers.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the data are of another mesh.
    pub fn of(model: &Model, silicone: &Viscoelastic, data: &ReducedModelData) -> Result<Self> {
        let reduced = Arc::new(model.system.restore(data)?);
        let rows = model.markers.iter().map(|spot| marker_rows(&reduced, spot)).collect();
        let unscaled = Self { reduced, scale: Vec::new(), relaxation: Vec::new(), stiffening: Vec::new(), rows };
        Ok(unscaled.with(model, silicone))
    }

    /// Displacement of a marker in the plane (m) after each step of a motion.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a step finds no motion.
    // By its twin, where there is one: the same equations to the same tolerance in a third to a fifth of the time.
    pub fn integrate(&self, motion: &ForcedMotion, marker: usize) -> Result<Vec<Point2>> {
        let projection = |row: &[f64], q: &DVector<f64>| row.iter().zip(q.as_slice()).map(|(r, q)| r * q).sum::<f64>();
        let position = |q: &DVector<f64>| self.rows[marker].each_ref().map(|row| projection(row, q));
        // A twin takes whole steps. Where a wall buckles none may be found, and the line search of the reduced model finds one.
        if motion.suits_a_twin()
            && self.has_twin()
            && let Some(states) = motion.twin_states(self.twin_data(&[])?)?
        {
            return Ok(states.iter().map(|(q, _)| position(q)).collect());
        }
        let mut path = Vec::with_capacity(motion.times.len());
        self.integrate_in_fluid(motion, &mut NoForce, &mut |q, _| path.push(position(q)))?;
        Ok(path)
    }

    /// Integrates a motion under the `external_force`; `see` receives each new q and q̇.
    ///
    /// # Errors
    /// A [`Diagnostic`] when a step finds no motion.
    pub fn integrate_in_fluid(
        &self,
        motion: &ForcedMotion,
        external_force: &mut dyn ExternalForce,
        see: &mut dyn FnMut(&DVector<f64>, &DVector<f64>),
    ) -> Result<()> {
        let actuation = |t: Second| Actuation { pressures: (motion.pressures)(t) };
        let reduced = ReducedMotion {
            settings: motion.settings,
            modulus_scale: &self.scale,
            relaxation: &self.relaxation,
            stiffening: &self.stiffening,
            actuation: &actuation,
        };
        let mut shown = |_: Second, q: &DVector<f64>, v: &DVector<f64>| see(q, v);
        self.reduced.integrate_at(&reduced, external_force, motion.times, &mut shown).map_err(Diagnostic::from)
    }

    /// Displacement of the markers along x and y by each coordinate, m: (markers × 2) × coordinates, in the order of `markers`.
    pub fn rows(&self, markers: &[usize]) -> DMatrix<f64> {
        DMatrix::from_fn(2 * markers.len(), self.coordinates(), |i, j| self.rows[markers[i / 2]][i % 2][j])
    }

    /// The reduced model.
    pub fn model(&self) -> &ReducedModel {
        &self.reduced
    }

    /// By region: the factor of its moduli, its relaxation, its ratios of stiffening.
    pub fn constants(&self) -> impl Iterator<Item = (f64, &Relaxation, [f64; 2])> {
        let constants = self.scale.iter().zip(&self.relaxation).zip(&self.stiffening);
        constants.map(|((scale, relaxation), stiffening)| (*scale, relaxation, *stiffening))
    }

    /// The same reduced model with other constants of the silicone; `model` is the one that was reduced.
    #[must_use]
    pub fn with(&self, model: &Model, silicone: &Viscoelastic) -> Self {
        let regions = model.system.regions();
        let scale = regions.iter().zip(&silicone.elastic.youngs_moduli).map(|(r, e)| e / r.youngs_modulus).collect();
        let mut relaxation = vec![Relaxation::default(); regions.len()];
        relaxation[BODY] = silicone.relaxation.clone();
        let mut stiffening: Vec<[f64; 2]> = regions.iter().map(|region| region.stiffening).collect();
        stiffening[BODY] = silicone.elastic.stiffening;
        Self { reduced: Arc::clone(&self.reduced), scale, relaxation, stiffening, rows: self.rows.clone() }
    }

    /// Number of markers and further points.
    pub fn markers(&self) -> usize {
        self.rows.len()
    }

    /// Number of coordinates.
    pub fn coordinates(&self) -> usize {
        self.reduced.coordinates()
    }
}

fn marker_rows(reduced: &ReducedModel, spot: &mesh::Spot) -> [Vec<f64>; 2] {
    [0, 1].map(|axis| {
        let mut row = vec![0.0; reduced.coordinates()];
        for &(node, weight) in &spot.weights {
            let node_row = reduced.row(3 * node as usize + axis);
            row.iter_mut().zip(node_row).for_each(|(sum, part)| *sum += weight * part);
        }
        row
    })
}
