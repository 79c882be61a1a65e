//! The adjoint of histories, backwards in time.
//!
//! With s the stress per unit of μ and qᵢ the overstress of a branch, step n has qᵢ,ₙ = dᵢ qᵢ,ₙ₋₁ + aᵢ (sₙ − sₙ₋₁) and
//! the residual Σ w μ F Σqᵢ,ₙ ∇N. Let zᵢ be the derivative of the loss, this step's residual included, by qᵢ,ₙ:
//! zᵢ,ₙ = dᵢ zᵢ,ₙ₊₁ − w μ sym(Fᵀ ∇λ), and the derivative by sₙ is σₙ = Σ (aᵢ zᵢ,ₙ − aᵢ,ₙ₊₁ zᵢ,ₙ₊₁).
//! The part of σₙ that does not depend on λₙ belongs to the right-hand side of the step's adjoint equation.

use crate::system_data::SystemData;
use crate::viscoelastic::history::{HistoryStep, for_each_point};
use materials::step::RegionStep;
use materials::symmetric::{Symmetric, add_scaled, double_contraction, symmetric_part};

/// What the steps after n hand back to it, point by point as in a history: −Σ aᵢ zᵢ,ₙ₊₁, then dᵢ zᵢ,ₙ₊₁ of each branch.
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
        let mut tensors = Vec::new();
        for_each_point(data, regions, |point, _| tensors.resize(point.own.end, [0.0; 6]));
        Self { tensors }
    }

    /// Adds the derivative of the loss by sₙ that later steps hand back, carried to the nodes at `u`, to `right` (3
    /// entries per node). `ends`: whether a step ends in n, over `regions`; none does in the initial state.
    pub(crate) fn add_right_side(
        &self,
        (data, regions): (&SystemData, &[RegionStep]),
        ends: bool,
        u: &[f64],
        right: &mut [f64],
    ) {
        for_each_point(data, regions, |point, region| {
            let point_tensors = &self.tensors[point.own.clone()];
            let mut by_stress = point_tensors[0];
            for (branch, later) in region.branches.iter().zip(&point_tensors[1..]).filter(|_| ends) {
                add_scaled(&mut by_stress, branch.gain, later);
            }
            let image = region.stress_pulled_back(&point.deformation(u), &by_stress);
            point.add_force(&image, 1.0, right);
        });
    }

    /// Takes the step from n to n − 1, where `lambda` solves the adjoint equation of step n. Adds to the sums of each
    /// region.
    pub(crate) fn step_back(&mut self, step: &HistoryStep, lambda: &[f64], sums: &mut [RelaxationSums]) {
        for_each_point(step.data, step.regions, |point, region| {
            let histories = (step.before.of_point(point), step.now.of_point(point));
            let gradient = point.deformation(step.displacement);
            let virtual_gradient = point.displacement_gradient(lambda);
            let mut work = symmetric_part(&(gradient.tr_mul(&virtual_gradient)));
            work.iter_mut().for_each(|entry| *entry *= point.weight);
            let point_tensors = &mut self.tensors[point.own.clone()];
            step_point_back(region, point_tensors, (histories, &work), &mut sums[point.region]);
        });
    }
}

/// One point: from what the later steps hand back to what this one does. `work` is w sym(Fᵀ ∇λ).
fn step_point_back(
    region: &RegionStep,
    handed: &mut [Symmetric],
    ((before, now), work): ((&[Symmetric], &[Symmetric]), &Symmetric),
    sums: &mut RelaxationSums,
) {
    let mut gained = [0.0; 6];
    let mut change = now[0];
    add_scaled(&mut change, -1.0, &before[0]);
    for (number, branch) in region.branches.iter().enumerate() {
        let z = &mut handed[1 + number];
        add_scaled(z, -region.mu, work);
        add_scaled(&mut gained, branch.gain, z);
        sums.by_mu -= double_contraction(work, &now[1 + number]);
        let (by_decay, by_gain) = (double_contraction(z, &before[1 + number]), double_contraction(z, &change));
        let [decay_by_time, gain_by_time] = branch.by_time();
        let [strength, time] = &mut sums.by_branch[number];
        *strength += by_gain * branch.gain_by_strength();
        *time += by_decay * decay_by_time + by_gain * gain_by_time;
        z.iter_mut().for_each(|entry| *entry *= branch.decay);
    }
    handed[0] = gained.map(|entry| -entry);
}
