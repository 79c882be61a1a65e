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
    pub fn staircase<'a>(
        &'a self,
        staircase: Staircase<'a>,
        span: TimeSpan,
        fluid: Option<Fluid>,
    ) -> Result<StaircaseMotion<'a>> {
        let Staircase { side, sweep, trace } = staircase;
        let pressures = |t: Second| side.alone(trace.at(t));
        let flapping = self.flapping(span, &pressures, &Conditions { fluid, softening: 1.0, softened: None })?;
        let quasistatic = QuasistaticMotion { rest: &self.body.mesh.nodes, sweep, trace };
        let equilibria = &self.equilibria[usize::from(side == Side::Right)];
        Ok(StaircaseMotion { quasistatic, flapping, equilibria })
    }
}

impl StaircaseMotion<'_> {
    /// Deviation of the reduced coordinates from their equilibrium.
    fn deviation(&self, t: Second) -> DVector<f64> {
        let (first, weights) = self.quasistatic.interpolation(t);
        let here = self.flapping.coordinates(t);
        self.equilibria[first..].iter().zip(weights).fold(here, |left, (rest, weight)| left - rest * weight)
    }
}

impl Motion for StaircaseMotion<'_> {
    fn nodes(&self, t: Second) -> Vec<Point3> {
        let (mut nodes, moved) =
            (self.quasistatic.nodes(t), flapping::displacements(self.flapping.modes(), &self.deviation(t)));
        let (moved, _) = moved.as_chunks::<3>();
        nodes.iter_mut().zip(moved).for_each(|(x, u)| shift(x, u));
        nodes
    }

    fn nodes_of(&self, t: Second, of: &[u32]) -> Vec<Point3> {
        let mut nodes = self.quasistatic.nodes_of(t, of);
        let moved = flapping::displacements_of(self.flapping.modes(), &self.deviation(t), of);
        of.iter().zip(moved).for_each(|(i, u)| shift(&mut nodes[*i as usize], &u));
        nodes
    }

    fn pull(&self, t: Second) -> Newton {
        self.flapping.pull(t)
    }

    fn thrust(&self, t: Second) -> Newton {
        self.flapping.thrust(t)
    }
}

fn shift(x: &mut Point3, u: &[f32; 3]) {
    x.iter_mut().zip(u).for_each(|(x, u)| *x += f64::from(*u));
}
