//! The adjoint of histories, backwards in time.
//!
//! With s the stress per unit of μ and qᵢ the overstress of a branch, step n has qᵢ,ₙ = dᵢ qᵢ,ₙ₋₁ + aᵢ (sₙ − sₙ₋₁) and
//! the residual Σ w μ F Σqᵢ,ₙ ∇N. Let zᵢ be the derivative of the loss, this step's residual included, by qᵢ,ₙ:
//! zᵢ,ₙ = dᵢ zᵢ,ₙ₊₁ − w μ sym(Fᵀ ∇λ), and the derivative by sₙ is σₙ = Σ (aᵢ zᵢ,ₙ − aᵢ,ₙ₊₁ zᵢ,ₙ₊₁).
//! The part of σₙ that does not depend on λₙ belongs to the right-hand side of the step's adjoint equation.

use crate::system_data::SystemData;
use crate::viscoelastic::history::{History, for_each_point, tensors};
use crate::viscoelastic::step::RegionStep;
use crate::viscoelastic::symmetric::{Symmetric, add_scaled, contract, symmetric};

/// What the steps after n hand back to it, point by point as in [`History`]: −Σ aᵢ zᵢ,ₙ₊₁, then dᵢ zᵢ,ₙ₊₁ of each branch.
#[derive(Debug, Clone)]
pub(crate) struct AdjointHistory {
    tensors: Vec<Symmetric>,
}

/// The gradient by the numbers of one region's relaxation.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct RelaxationSums {
    /// By μ.
    pub by_mu: f64,
    /// By g and τ of each branch.
    pub by_branch: Vec<[f64; 2]>,
}

impl AdjointHistory {
    pub fn zero(data: &SystemData, regions: &[RegionStep]) -> Self {
        Self { tensors: vec![[0.0; 6]; tensors(data, regions)] }
    }

    /// Adds the derivative of the loss by sₙ that later steps hand back, carried to the nodes at `u`, to `right` (3
    /// entries per node). `regions`: the steps that end in n; none for the initial state.
    pub(crate) fn add_right_side(
        &self,
        data: &SystemData,
        regions: &[RegionStep],
        ends: bool,
        u: &[f64],
        right: &mut [f64],
    ) {
        let mut rest = &self.tensors[..];
        for_each_point(data, regions, |point, region| {
            let (own, after) = rest.split_at(1 + region.branches.len());
            rest = after;
            let mut by_stress = own[0];
            for (branch, later) in region.branches.iter().zip(&own[1..]).filter(|_| ends) {
                add_scaled(&mut by_stress, branch.gain, later);
            }
            let image = region.stress_pulled_back(&point.deformation(u), &by_stress);
            point.add_force(&image, 1.0, right);
        });
    }

    /// Takes the step from n to n − 1: `lambda` solves the adjoint equation of step n, which ends at `u` with the
    /// history `now` after `before`. Adds to the sums of each region.
    pub(crate) fn step_back(
        &mut self,
        data: &SystemData,
        regions: &[RegionStep],
        (u, lambda): (&[f64], &[f64]),
        (before, now): (&History, &History),
        sums: &mut [RelaxationSums],
    ) {
        let mut at = 0;
        for_each_point(data, regions, |point, region| {
            let range = at..at + 1 + region.branches.len();
            at = range.end;
            let (before, now) = (&before.tensors[range.clone()], &now.tensors[range.clone()]);
            let gradient = point.deformation(u);
            let virtual_gradient = point.deformation(lambda) - nalgebra::Matrix3::identity();
            let mut work = symmetric(&(gradient.tr_mul(&virtual_gradient)));
            work.iter_mut().for_each(|entry| *entry *= point.weight);
            region.step_back(&mut self.tensors[range], (before, now), &work, &mut sums[point.region]);
        });
    }
}

impl RegionStep {
    /// One point: from what the later steps hand back to what this one does. `work` is w sym(Fᵀ ∇λ).
    fn step_back(
        &self,
        handed: &mut [Symmetric],
        (before, now): (&[Symmetric], &[Symmetric]),
        work: &Symmetric,
        sums: &mut RelaxationSums,
    ) {
        let mut gained = [0.0; 6];
        let mut change = now[0];
        add_scaled(&mut change, -1.0, &before[0]);
        for (number, branch) in self.branches.iter().enumerate() {
            let z = &mut handed[1 + number];
            add_scaled(z, -self.mu, work);
            add_scaled(&mut gained, branch.gain, z);
            sums.by_mu -= contract(work, &now[1 + number]);
            let (by_decay, by_gain) = (contract(z, &before[1 + number]), contract(z, &change));
            let [decay_by_time, gain_by_time] = branch.by_time();
            let [strength, time] = &mut sums.by_branch[number];
            *strength += by_gain * branch.gain_by_strength();
            *time += by_decay * decay_by_time + by_gain * gain_by_time;
            z.iter_mut().for_each(|entry| *entry *= branch.decay);
        }
        handed[0] = gained.map(|entry| -entry);
    }
}
