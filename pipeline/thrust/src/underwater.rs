//! Motion of a reduced body in still water under measured pressures.

use fem::DynamicSettings;
use hydro::{Coefficients, Tail};
use nalgebra::DMatrix;
use si::Point2;
use signal::resample::Samples;

use crate::real_time::Surroundings;
use diagnostics::Result;
use sysid::actuated::{Actuation, MotionSimulation};
use sysid::{ForcedMotion, ReducedBody};

/// A reduced model in water.
#[derive(Clone)]
pub struct UnderwaterModel<'a> {
    reduced_body: &'a ReducedBody,
    tail: &'a Tail,
    /// Rows of the tail's stations and of the observed marker, m.
    stations: DMatrix<f64>,
    watched: DMatrix<f64>,
    half: bool,
}

impl<'a> UnderwaterModel<'a> {
    /// The tail's stations follow the card's `marker_count` markers in the model of `simulation`.
    pub fn new(
        reduced_body: &'a ReducedBody,
        tail: &'a Tail,
        simulation: &MotionSimulation,
        marker_count: usize,
    ) -> Self {
        let stations = reduced_body.rows(&(marker_count..reduced_body.markers()).collect::<Vec<_>>());
        let half = simulation.model.system.mesh().symmetry_plane_z;
        Self { reduced_body, tail, stations, watched: reduced_body.rows(&[simulation.marker]), half }
    }

    /// The same with another silicone.
    #[must_use]
    pub fn with<'b>(&'b self, reduced_body: &'b ReducedBody) -> UnderwaterModel<'b> {
        UnderwaterModel { reduced_body, ..self.clone() }
    }

    /// Displacement of the observed marker along x and y, m, as functions of the film's time.
    ///
    /// # Errors
    /// A [`Diagnostic`](diagnostics::Diagnostic) when a step finds no motion.
    pub fn path(&self, settings: &DynamicSettings, by: Coefficients, actuation: &Actuation) -> Result<[Samples; 2]> {
        let times = actuation.times(settings.step);
        let motion = ForcedMotion { settings, pressures: &|t| actuation.pressures(t), times: &times };
        let water = Surroundings { tail: self.tail, rows: &self.stations, by, half: self.half };
        let mut path: Vec<Point2> = Vec::with_capacity(times.len());
        water.integrate(self.reduced_body, &motion, &mut |coordinates, _| {
            path.push([0, 1].map(|k| (self.watched.row(k) * coordinates)[0]));
        })?;
        actuation.sample_path(&times, &path)
    }
}
