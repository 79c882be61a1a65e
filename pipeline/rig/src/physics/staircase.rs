//! A staircase of pressures on one side, with the free vibration that follows each step.
//!
//! u(t) = u₀(p(t)) + V (q(t) − q₀(p(t))): the equilibrium of the whole body at the present pressure, plus the deviation of the reduced model
//! from its own equilibrium. Held levels are as accurate as the whole body, and a release decays as a free vibration, from which the
//! pipeline identifies damping and drag.

use crate::side::Side;
use diagnostics::Result;
use nalgebra::DVector;
use si::{Newton, Point3, Second};

use super::flapping::{self, Conditions, FlappingModel, FlappingMotion, TimeSpan};
use super::{Fluid, Motion, PressureSweep, QuasistaticMotion};
use crate::valve::Trace;

/// The actuation of a staircase.
pub struct Staircase<'a> {
    /// The side that is filled.
    pub side: Side,
    /// The whole body's equilibria on that side, at the reference temperature.
    pub sweep: &'a PressureSweep,
    /// The pressure in its chamber.
    pub trace: Trace,
}

/// The motion of a tail during a staircase.
pub struct StaircaseMotion<'a> {
    quasistatic: QuasistaticMotion<'a>,
    /// Motion of the reduced model under the same pressure.
    flapping: FlappingMotion<'a>,
    /// Equilibria of the reduced model at the pressures of the sweep.
    equilibria: &'a [DVector<f64>],
}

impl FlappingModel<'_> {
    /// The motion from rest during `staircase`.
    ///
    /// # Errors
    /// When a step does not converge.
    pub fn simulate_staircase<'a>(
        &'a self,
        staircase: Staircase<'a>,
        span: TimeSpan,
        fluid: Option<Fluid>,
    ) -> Result<StaircaseMotion<'a>> {
        let Staircase { side, sweep, trace } = staircase;
        let pressures = |t: Second| side.alone(trace.at(t));
        let flapping =
            self.simulate_flapping(span, &pressures, &Conditions { fluid, softening: 1.0, softened: None })?;
        let quasistatic = QuasistaticMotion { rest: &self.body.mesh.nodes, sweep, trace };
        let equilibria = &self.equilibria[usize::from(side == Side::Right)];
        Ok(StaircaseMotion { quasistatic, flapping, equilibria })
    }
}

impl StaircaseMotion<'_> {
    /// Deviation of the reduced coordinates from their equilibrium.
    fn modal_deviation(&self, t: Second) -> DVector<f64> {
        let (first, weights) = self.quasistatic.cubic_weights(t);
        let coordinates = self.flapping.coordinates_at(t);
        self.equilibria[first..]
            .iter()
            .zip(weights)
            .fold(coordinates, |deviation, (equilibrium, weight)| deviation - equilibrium * weight)
    }
}

impl Motion for StaircaseMotion<'_> {
    fn nodes(&self, t: Second) -> Vec<Point3> {
        let (mut nodes, displacements) = (
            self.quasistatic.nodes(t),
            flapping::nodal_displacements(self.flapping.nodal_modes(), &self.modal_deviation(t)),
        );
        let (displacements, _) = displacements.as_chunks::<3>();
        nodes.iter_mut().zip(displacements).for_each(|(x, u)| shift_node(x, u));
        nodes
    }

    fn nodes_of(&self, t: Second, wanted: &[u32]) -> Vec<Point3> {
        let mut nodes = self.quasistatic.nodes_of(t, wanted);
        let displacements = flapping::displacements_of(self.flapping.nodal_modes(), &self.modal_deviation(t), wanted);
        wanted.iter().zip(displacements).for_each(|(i, u)| shift_node(&mut nodes[*i as usize], &u));
        nodes
    }

    fn pull(&self, t: Second) -> Newton {
        self.flapping.pull(t)
    }

    fn thrust(&self, t: Second) -> Newton {
        self.flapping.thrust(t)
    }
}

fn shift_node(x: &mut Point3, u: &[f32; 3]) {
    x.iter_mut().zip(u).for_each(|(x, u)| *x += f64::from(*u));
}
