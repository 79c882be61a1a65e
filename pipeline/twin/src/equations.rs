//! The equations of one step, and their solution by a quasi-Newton method on a lagged tangent.
//!
//! M q̈ + f(q) = Σ p ∂V/∂q + Q. A residual costs half of a tangent, and Broyden's update of the inverse almost nothing: the
//! tangent is summed anew only where an iteration leaves more than [`REFRESH_ABOVE`] of the one before.
//!
//! The tangent's geometric part takes the stress of the last step's end, not that of the iterate, which the quadratic terms of a linear
//! step in the rotating stiff sheet spoil. Measured on a flapping tail in air, residuals and tangents a step: 9.1 and 4.1 with the iterate's
//! stress, 7.5 and 3.3 with the stress that the last iteration predicts [magisano2017], 5.9 and 2.5 with this. Where walls buckle it is no longer
//! near, and a tangent after [`FORMER`] iterations takes that of the iterate.

use crate::chambers::add;
use crate::dense::{broyden_update, invert, multiply};
use crate::elastic::{Stresses, add_triangle};
use crate::error::TwinError;
use crate::lanes::{Lanes, add_reduced};
use crate::single_precision;
use crate::state::{Lagged, Past, SAME, Stencil, TwinState, Work};
use crate::twin::{Twin, largest_entry};
use crate::workspace::Workspace;
use wide::f32x8;

/// A step that leaves more than this fraction of the one before asks for a new tangent. With 0.1 and the former stress throughout, a tail of thin walls
/// in air took 4.9 tangents a step for 3.0, and two thirds of the speed; one of thick walls moves as fast with either.
const REFRESH_ABOVE: f64 = 0.3;
/// Iterations of a step whose tangents take the former stress.
const FORMER: usize = 2;
/// γ (1/s) above which the tolerance falls with its square, so that what a step leaves accelerates the body by no more: that of 240 steps a second.
const SLOW: f64 = 360.0;
/// Least tolerance: rounding.
const LEAST: f64 = 1e-11;
/// Shortest part of a change that is left of an iterate that is taken back.
const SHORTEST_PART: f64 = 1e-3;

/// The equations of one step, in the buffers of the state that makes it.
pub(crate) struct Equations<'a> {
    twin: &'a Twin,
    stencil: Stencil,
    past: &'a Past,
    /// Stresses at the end of the last step, by region.
    former_stresses: &'a [Stresses],
    /// s, at the begin of the step.
    start_time: f64,
    space: &'a mut Workspace,
    lagged: &'a mut Lagged,
    work: &'a mut Work,
}

impl<'a> Equations<'a> {
    /// Of a step of `duration` seconds from `state`, whose factors are those of that duration.
    pub(crate) fn of_step(twin: &'a Twin, state: &'a mut TwinState, pressures: &[f64], duration: f64) -> Self {
        let TwinState { time, past, histories, factors, lagged, stresses, work, workspace: space, .. } = state;
        let stencil = past.step_stencil(duration);
        for (((solid, history), factors), acting) in
            twin.solids.iter().zip(histories.iter()).zip(&factors.1).zip(&mut space.acting)
        {
            history.hold_stress(solid.mu, factors, &mut acting.held);
            acting.constants = solid.constants_with_gain(factors.iter().map(|by| by.gain).sum());
        }
        space.pressure_work.set_pressures(&twin.chambers, pressures);
        for (kind, sum) in [&past.coordinates, &past.velocities, &past.momenta].into_iter().zip(&mut space.past) {
            stencil.weigh_history(kind, sum);
        }
        Self { twin, stencil, past, former_stresses: stresses, start_time: *time, space, lagged, work }
    }

    /// Fills the workspace with the motion at the end of the step, at `time` (s), and with the stresses of its last residual.
    ///
    /// # Errors
    /// [`TwinError::NoConvergence`]; no lagged tangent is left then.
    pub(crate) fn solve(mut self, time: f64) -> Result<Stencil, TwinError> {
        self.past.initial_guess(time, &mut self.space.coordinates);
        self.evaluate_residual();
        if !self.is_finite() {
            // The polynomial's guess may turn a point inside out, where ln J is no number; the last state, which was
            // found, does not.
            self.space.coordinates.copy_from_slice(&self.past.coordinates[0]);
            self.evaluate_residual();
        }
        // an error on the way leaves none
        let mut gamma = std::mem::replace(&mut self.lagged.gamma, f64::NAN);
        let mut is_usable = (gamma / self.stencil.gamma - 1.0).abs() < SAME;
        let tolerance = self.tolerance();
        let mut size = f64::INFINITY;
        for iteration in 0..self.twin.max_iterations {
            std::mem::swap(&mut self.space.change, &mut self.space.former_change);
            if !(is_usable && self.update_change(iteration > 0)) {
                self.refresh_tangent(iteration < FORMER).then_some(()).ok_or(self.failure(size))?;
                gamma = self.stencil.gamma;
            }
            is_usable = true;
            add(&mut self.space.coordinates, -1.0, &self.space.change);
            size = largest_entry(&self.space.change) / self.twin.size;
            if size < tolerance {
                self.lagged.gamma = gamma;
                self.evaluate_motion();
                return Ok(self.stencil);
            }
            if !size.is_finite() {
                break;
            }
            self.evaluate_residual();
            if !self.is_finite() {
                self.take_back();
                is_usable = false;
            }
        }
        Err(self.failure(size))
    }

    /// Largest size of the last iteration, relative to the largest shape.
    fn tolerance(&self) -> f64 {
        let loosest_tolerance = self.twin.tolerance;
        loosest_tolerance * (SLOW / self.stencil.gamma).powi(2).clamp(LEAST / loosest_tolerance, 1.0)
    }

    fn failure(&self, change: f64) -> TwinError {
        TwinError::NoConvergence { time: self.start_time, iterations: self.twin.max_iterations, change }
    }

    fn is_finite(&self) -> bool {
        self.space.residual.iter().all(|force| force.is_finite())
    }

    /// Takes the iterate back along its last change by halves until no point is turned inside out.
    fn take_back(&mut self) {
        let mut part = 1.0;
        self.evaluate_residual();
        // Such an iterate has no forces. Without a way back a step in which it occurred was lost with all its halves: a
        // thin-walled tail under the pressures of its hardest recorded flap.
        while part > SHORTEST_PART && !self.is_finite() {
            part *= 0.5;
            add(&mut self.space.coordinates, part, &self.space.change);
            self.evaluate_residual();
        }
    }

    /// The residual and the stresses at the iterate.
    fn evaluate_residual(&mut self) {
        self.work.residuals += 1;
        let (twin, gamma, space) = (self.twin, self.stencil.gamma, &mut *self.space);
        let (q, residual) = (&space.coordinates, &mut space.residual);
        space.velocity.copy_from_slice(&space.past[0]);
        add(&mut space.velocity, gamma, q);
        space.acceleration.copy_from_slice(&space.past[1]);
        add(&mut space.acceleration, gamma, &space.velocity);
        multiply(&twin.mass, &space.acceleration, residual);
        if let Some(water) = &twin.water {
            water.add_forces((q, &space.velocity, gamma), &mut space.water, (residual, &mut space.momentum));
            add(residual, 1.0, &space.past[2]);
        }
        space.lanes.fill(Lanes::ZERO);
        for ((solid, acting), stresses) in twin.solids.iter().zip(&space.acting).zip(&mut space.stresses) {
            solid.add_forces(q, acting, (&mut space.lanes, stresses));
        }
        add_reduced(&space.lanes, residual);
        space.pressure_work.subtract_gradient(q, residual);
    }

    /// q̇ and the water's momentum at the state itself: those of the last residual would leave their difference in every later step.
    fn evaluate_motion(&mut self) {
        let Workspace { coordinates, velocity, momentum, past, water, row, .. } = &mut *self.space;
        velocity.copy_from_slice(&past[0]);
        add(velocity, self.stencil.gamma, coordinates);
        if let Some(fluid) = &self.twin.water {
            fluid.add_forces((coordinates, velocity, self.stencil.gamma), water, (row, momentum));
        }
    }

    /// H r on the lagged inverse, which is updated by what the change before left; false where it converges too slowly.
    fn update_change(&mut self, has_former: bool) -> bool {
        let Workspace { change, former_change, residual, row, .. } = &mut *self.space;
        multiply(&self.lagged.inverse, residual, change);
        if !has_former {
            return true;
        }
        let is_slow = largest_entry(change) > REFRESH_ABOVE * largest_entry(former_change);
        !is_slow && broyden_update(&mut self.lagged.inverse, former_change, (change, row))
    }

    /// H r on a new inverse of ∂residual/∂q, with the stress of the step's start or of the iterate; false where it is singular.
    fn refresh_tangent(&mut self, takes_former: bool) -> bool {
        self.work.tangents += 1;
        let (twin, gamma, space) = (self.twin, self.stencil.gamma, &mut *self.space);
        let (q, tangent) = (&space.coordinates, &mut space.tangent);
        // length: both are r × r
        tangent.iter_mut().zip(&twin.mass).for_each(|(entry, mass)| *entry = mass * gamma * gamma);
        space.triangle.fill(f32x8::ZERO);
        for ((solid, acting), before) in twin.solids.iter().zip(&space.acting).zip(self.former_stresses) {
            let former_stress = if takes_former { before.law.as_slice() } else { &[] };
            solid.add_stiffness(q, (acting, former_stress), &mut space.triangle);
        }
        add_triangle(single_precision::lane_sums(&space.triangle), tangent);
        space.pressure_work.subtract_hessian(q, tangent);
        if let Some(water) = &twin.water {
            water.add_stiffness((q, &space.velocity, gamma), &mut space.water, tangent);
        }
        let is_regular = invert(tangent, &mut self.lagged.inverse);
        multiply(&self.lagged.inverse, &space.residual, &mut space.change);
        is_regular
    }
}
