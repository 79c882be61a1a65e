//! Discrete adjoint of a recorded motion: derivatives of a loss by moduli, relaxation, pressures at every step and the water's two
//! numbers, with checkpoints [griewank1992].
//!
//! Steps are passed from the last to the first. Each takes one tangent at its end, where the step's own was lagged, and one solution with its
//! transpose: the tangent is summed in single precision, and products with the exact one refine the solution [higham2002]. The stencil of
//! BDF2 carries the adjoint to the two steps before, and [`SolidAdjoint`] through the relaxation.

use crate::chambers::{PressureWork, add};
use crate::dense::{inverse, multiply, multiply_transposed};
use crate::elastic::{Acting, add_triangle};
use crate::error::TwinError;
use crate::gradient::{LossGradient, MotionGradient};
use crate::lanes::{Lanes, add_reduced};
use crate::law::Symmetric;
use crate::recording::{RecordedPart, Recording, checkpoint_place};
use crate::single_precision;
use crate::solid_adjoint::{BranchStep, SolidAdjoint};
use crate::twin::Twin;
use crate::water::WaterSums;
use crate::water_adjoint::WaterGradient;

/// The refinement that changes the solution by less than this, relative, is the last. With 1e-4 it is the first one, and derivatives of four
/// seconds of flapping are off by up to 2e-6; with this, by 1e-8, for 3 % more time.
const REFINED: f64 = 1e-5;
/// Refinements at most.
// Twenty products are half of what the exact tangent of a tail of forty coordinates takes, so that giving up later
// would not pay.
const MAX_REFINEMENTS: usize = 20;

/// The tangent of one part.
struct Tangent {
    /// All but the solids.
    rest: Vec<f64>,
    /// Inverse of the whole, the solids in single precision.
    inverse: Vec<f64>,
}

/// Derivatives of the loss by q, q̇ and the water's momentum after one part, but for what that part's own residual depends on them by.
#[derive(Debug, Clone)]
struct Pending {
    coordinates: Vec<f64>,
    velocity: Vec<f64>,
    momentum: Vec<f64>,
}

/// The pass through a motion.
struct Pass<'a> {
    twin: &'a Twin,
    solids: Vec<SolidAdjoint<'a>>,
    /// Of the part that is passed next, and of the two before it.
    pending: [Pending; 3],
    water: [f64; 2],
}

impl Twin {
    /// The derivatives of a loss of a recorded motion; `loss` gives those by the state after each step, from 0, last step first.
    ///
    /// They are exact to the tolerance of the steps, [`Twin::with_tolerance`].
    ///
    /// # Errors
    /// [`TwinError::Adjoint`] when a step's tangent is singular, [`TwinError::State`] when the recording is of another twin.
    pub fn adjoint(
        &self,
        recording: &Recording,
        loss: &mut dyn FnMut(usize) -> LossGradient,
    ) -> Result<MotionGradient, TwinError> {
        self.check_state(recording.state())?;
        let mut pass = Pass::new(self);
        let mut pressures = vec![vec![0.0; self.chambers.len()]; recording.steps()];
        let (mut checkpoint, mut held_stresses) = (usize::MAX, Vec::new());
        for step in (0..recording.steps()).rev() {
            pass.pending[0].add_loss(&loss(step));
            let first = step.checked_sub(1).map_or(0, |former| recording.ends[former]);
            for number in (first..recording.ends[step]).rev() {
                let (segment, within) = checkpoint_place(number);
                if segment != checkpoint {
                    (checkpoint, held_stresses) = (segment, self.held_stresses(recording, segment));
                }
                let part = &recording.parts[number];
                let by_pressures = pass.pass_part(part, std::mem::take(&mut held_stresses[within]))?;
                add_pressure_derivatives(&by_pressures, (step, part.passed), &mut pressures);
            }
        }
        let regions = pass.solids.iter().map(SolidAdjoint::gradient).collect();
        Ok(MotionGradient { regions, pressures, water: pass.water })
    }
}

/// Adds the derivatives by the pressures of a part to those by the pressures at both ends of its step.
fn add_pressure_derivatives(by_pressures: &[f64], (step, passed): (usize, f64), pressures: &mut [Vec<f64>]) {
    add(&mut pressures[step], passed, by_pressures);
    // before the first step there is no pressure
    if step > 0 {
        add(&mut pressures[step - 1], 1.0 - passed, by_pressures);
    }
}

impl<'a> Pass<'a> {
    fn new(twin: &'a Twin) -> Self {
        let pending = || Pending::zero(twin.coordinates());
        let solids = twin.solids.iter().map(SolidAdjoint::new).collect();
        Self { twin, solids, pending: [pending(), pending(), pending()], water: [0.0; 2] }
    }

    /// Passes one part; returns the derivatives by its pressures, 1/Pa.
    fn pass_part(&mut self, part: &RecordedPart, held_stresses: Vec<Vec<Symmetric>>) -> Result<Vec<f64>, TwinError> {
        let (twin, q, gamma) = (self.twin, &part.coordinates, part.stencil.gamma);
        let [current, before, earlier] = &self.pending;
        let mut current = current.clone();
        self.pending = [before.clone(), earlier.clone(), Pending::zero(q.len())];
        let (branches, acting) = self.acting_solids(part, held_stresses);
        let tangent = self.tangent_of_part(part, (&acting, &branches), &mut current.coordinates);
        let tangent = tangent.ok_or(TwinError::Adjoint { time: part.time })?;
        let momentum = self.water_gradient(part, [&vec![0.0; q.len()], &current.momentum]);
        add(&mut current.coordinates, 1.0, &momentum.by_coordinates);
        add(&mut current.velocity, 1.0, &momentum.by_velocity);
        let mut right = current.coordinates.clone();
        add(&mut right, gamma, &current.velocity);
        right.iter_mut().for_each(|entry| *entry = -*entry);
        let adjoint = self.solve_transposed(&tangent, &acting, &right).ok_or(TwinError::Adjoint { time: part.time })?;
        let force = self.water_gradient(part, [&adjoint, &vec![0.0; q.len()]]);
        add(&mut current.velocity, 1.0, &force.by_velocity);
        self.carry_adjoint(part, current, &adjoint);
        for ((solid, acting), now) in self.solids.iter_mut().zip(&acting).zip(branches) {
            solid.pass_step(&adjoint, acting, now);
        }
        let work = |chamber: &crate::data::Chamber| -dot(&chamber.volume_gradient(q), &adjoint);
        Ok(twin.chambers.iter().map(work).collect())
    }

    /// The branches of each solid, and what acts in it.
    fn acting_solids(
        &self,
        part: &RecordedPart,
        held_stresses: Vec<Vec<Symmetric>>,
    ) -> (Vec<Vec<BranchStep>>, Vec<Acting>) {
        let branches: Vec<Vec<BranchStep>> =
            self.solids.iter().map(|solid| solid.branch_steps(part.duration)).collect();
        let acting = self
            .solids
            .iter()
            .zip(&branches)
            .zip(held_stresses)
            .map(|((solid, now), held_stresses)| solid.acting_in_step(now, held_stresses));
        let acting = acting.collect();
        (branches, acting)
    }

    /// The derivative of the part's residual by its q, none where it is singular; adds to `loss` what later steps depend on q by through
    /// the relaxation.
    fn tangent_of_part(
        &mut self,
        part: &RecordedPart,
        (acting, branches): (&[Acting], &[Vec<BranchStep>]),
        loss: &mut [f64],
    ) -> Option<Tangent> {
        let (twin, q, gamma) = (self.twin, &part.coordinates, part.stencil.gamma);
        let mut without_solids: Vec<f64> = twin.mass.iter().map(|m| m * gamma * gamma).collect();
        let mut work = PressureWork::none(q.len());
        work.set_pressures(&twin.chambers, &part.pressures);
        work.subtract_hessian(q, &mut without_solids);
        if let Some(water) = &twin.water {
            water.add_stiffness((q, &part.velocity, gamma), &mut WaterSums::new(q.len()), &mut without_solids);
        }
        let (mut stiffness, mut later) = (single_precision::zero_triangle(q.len()), vec![Lanes::ZERO; q.len()]);
        for ((solid, acting), now) in self.solids.iter_mut().zip(acting).zip(branches) {
            solid.add_tangent(q, acting, now, (&mut stiffness, &mut later));
        }
        add_reduced(&later, loss);
        let mut full_tangent = without_solids.clone();
        add_triangle(single_precision::lane_sums(&stiffness), &mut full_tangent);
        Some(Tangent { rest: without_solids, inverse: inverse(full_tangent)? })
    }

    /// x of Kᵀ x = `right`, with the tangent of the part that is passed; none where it is singular.
    // Far from rest the stiffness of a soft direction may be lost in single precision beside that of a stiff sheet, and refinements do not converge:
    // the exact tangent then takes as many products as there are coordinates.
    fn solve_transposed(&self, tangent: &Tangent, acting: &[Acting], right: &[f64]) -> Option<Vec<f64>> {
        self.refined_solution(tangent, acting, right).or_else(|| self.solve_exactly(tangent, acting, right))
    }

    /// Kᵀ x, in double precision.
    fn transposed_product(&self, tangent: &Tangent, acting: &[Acting], x: &[f64]) -> Vec<f64> {
        let (mut image, mut lanes) = (vec![0.0; x.len()], vec![Lanes::ZERO; x.len()]);
        multiply_transposed(&tangent.rest, x, &mut image);
        self.solids.iter().zip(acting).for_each(|(solid, acting)| solid.add_product(x, acting, &mut lanes));
        add_reduced(&lanes, &mut image);
        image
    }

    fn solve_exactly(&self, tangent: &Tangent, acting: &[Acting], right: &[f64]) -> Option<Vec<f64>> {
        let n = right.len();
        let unit = |k: usize| -> Vec<f64> { (0..n).map(|i| f64::from(u8::from(i == k))).collect() };
        let rows: Vec<Vec<f64>> = (0..n).map(|k| self.transposed_product(tangent, acting, &unit(k))).collect();
        let mut x = vec![0.0; n];
        multiply_transposed(&inverse(rows.concat())?, right, &mut x);
        Some(x)
    }

    /// By the inverse in single precision and refinements; none where they do not converge.
    fn refined_solution(&self, tangent: &Tangent, acting: &[Acting], right: &[f64]) -> Option<Vec<f64>> {
        let mut x = vec![0.0; right.len()];
        multiply_transposed(&tangent.inverse, right, &mut x);
        for _ in 0..MAX_REFINEMENTS {
            let image = self.transposed_product(tangent, acting, &x);
            let residual: Vec<f64> = right.iter().zip(&image).map(|(right, image)| right - image).collect();
            let mut change = vec![0.0; right.len()];
            multiply_transposed(&tangent.inverse, &residual, &mut change);
            add(&mut x, 1.0, &change);
            // The change and not the residual is small at the end: beside a stiff sheet a small residual leaves soft
            // directions open.
            if dot(&change, &change) <= REFINED * REFINED * dot(&x, &x) {
                return Some(x);
            }
        }
        None
    }

    /// The derivatives of the water's part, whose factors' are summed.
    fn water_gradient(&mut self, part: &RecordedPart, adjoints: [&[f64]; 2]) -> WaterGradient {
        let motion = (&*part.coordinates, &*part.velocity);
        let gradient = self.twin.water.as_ref().map(|water| water.adjoint(motion, part.stencil.gamma, adjoints));
        let gradient = gradient.unwrap_or_else(|| WaterGradient::zero(part.coordinates.len()));
        self.water.iter_mut().zip(gradient.by_factors).for_each(|(sum, gradient)| *sum += gradient);
        gradient
    }

    /// Carries the adjoint to the two parts before by the stencil.
    fn carry_adjoint(&mut self, part: &RecordedPart, mut current: Pending, adjoint: &[f64]) {
        let mut momentum = vec![0.0; adjoint.len()];
        multiply(&self.twin.mass, adjoint, &mut momentum);
        add(&mut current.velocity, part.stencil.gamma, &momentum);
        for (pending, weight) in self.pending.iter_mut().zip(part.stencil.weights) {
            add(&mut pending.coordinates, weight, &current.velocity);
            add(&mut pending.velocity, weight, &momentum);
            add(&mut pending.momentum, weight, adjoint);
        }
    }
}

impl Pending {
    fn zero(r: usize) -> Self {
        Self { coordinates: vec![0.0; r], velocity: vec![0.0; r], momentum: vec![0.0; r] }
    }

    fn add_loss(&mut self, loss: &LossGradient) {
        add(&mut self.coordinates, 1.0, &loss.coordinates);
        add(&mut self.velocity, 1.0, &loss.velocity);
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::beam;

    #[test]
    fn where_refinements_do_not_converge_the_exact_tangent_gives_the_same_solution() {
        let twin = Twin::new(beam(true)).unwrap();
        let mut recording = twin.recording();
        (1..9).for_each(|n| twin.record(&mut recording, &[400.0 * f64::from(n), 0.0], 1.0 / 240.0).unwrap());
        let number = recording.parts.len() - 1;
        let (segment, within) = checkpoint_place(number);
        let (part, held) = (&recording.parts[number], twin.held_stresses(&recording, segment).swap_remove(within));
        let mut pass = Pass::new(&twin);
        let (branches, acting) = pass.acting_solids(part, held);
        let right: Vec<f64> = (0..twin.coordinates()).map(|k| 1.0 + k as f64).collect();
        let mut tangent = pass.tangent_of_part(part, (&acting, &branches), &mut vec![0.0; right.len()]).unwrap();
        let refined = pass.refined_solution(&tangent, &acting, &right).unwrap();
        tangent.inverse.iter_mut().for_each(|entry| *entry *= 3.0);
        assert_eq!(pass.refined_solution(&tangent, &acting, &right), None);
        let exact = pass.solve_transposed(&tangent, &acting, &right).unwrap();
        let off: Vec<f64> = exact.iter().zip(&refined).map(|(a, b)| a - b).collect();
        assert!(dot(&off, &off) < 1e-16 * dot(&exact, &exact), "{exact:?} for {refined:?}");
    }
}
