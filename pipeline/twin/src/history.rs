//! Relaxation of a solid: stress and overstress of each branch at its cubature points, eight side by side.
//!
//! Q ← d Q + a ΔS with d = e^(−h/τ), a = g (1 − d) τ/h, S the stress of μ over μ.     [simo1987]

use crate::lanes::splat;
use crate::law::Symmetric;

/// d and a of one branch over a step.
#[derive(Debug, Clone, Copy, Default)]
pub struct Factors {
    pub decay: f64,
    pub gain: f64,
}

impl Factors {
    /// Of a branch of this strength and time over `step` seconds.
    pub fn new([strength, time]: [f64; 2], step: f64) -> Self {
        // By `exp_m1`: 1 − e^(−x) cancels where a step is short beside the branch's time, which is what a controller's
        // steps are.
        let x = step / time;
        Self { decay: (-x).exp(), gain: strength * -(-x).exp_m1() / x }
    }
}

/// Derivatives of d and a by a branch's time, and of a by its strength.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct FactorSlopes {
    pub decay_by_time: f64,
    pub gain_by_time: f64,
    pub gain_by_strength: f64,
}

impl FactorSlopes {
    /// Of a branch of this strength and time over `step` seconds.
    pub fn new([strength, time]: [f64; 2], step: f64) -> Self {
        let (x, decay) = (step / time, (-step / time).exp());
        let relaxed_part = -(-x).exp_m1();
        Self {
            decay_by_time: decay * x / time,
            gain_by_time: strength * (relaxed_part - x * decay) / (x * time),
            gain_by_strength: relaxed_part / x,
        }
    }
}

/// What relaxes at the points of one solid.
#[derive(Debug, Clone, Default)]
pub struct History {
    branches: usize,
    /// blocks × (1 + branches): S, then Q of each branch.
    tensors: Vec<Symmetric>,
}

impl History {
    /// At rest for ever; nothing where there is no branch.
    pub fn at_rest(blocks: usize, branches: usize) -> Self {
        Self { branches, tensors: vec![[splat(0.0); 6]; Self::size(blocks, branches)[1]] }
    }

    /// Branches, and tensors that a history of them has.
    pub fn size(blocks: usize, branches: usize) -> [usize; 2] {
        [branches, if branches == 0 { 0 } else { blocks * (1 + branches) }]
    }

    /// Of saved tensors.
    pub(crate) fn restored(branches: usize, tensors: Vec<Symmetric>) -> Self {
        Self { branches, tensors }
    }

    pub(crate) fn tensors(&self) -> &[Symmetric] {
        &self.tensors
    }

    /// [`History::size`] of this one.
    pub(crate) fn own_size(&self) -> [usize; 2] {
        [self.branches, self.tensors.len()]
    }

    /// H of each block over a step: μ Σ (d Q − a S), Pa; `held` is filled.
    pub(crate) fn hold_stress(&self, mu: f64, factors: &[Factors], held: &mut Vec<Symmetric>) {
        held.clear();
        let gain = mu * factors.iter().map(|factors| factors.gain).sum::<f64>();
        held.extend(self.tensors.chunks_exact(1 + self.branches).map(|block_tensors| {
            let mut sum = block_tensors[0].map(|entry| entry * splat(-gain));
            block_tensors[1..]
                .iter()
                .zip(factors)
                .for_each(|(overstress, branch)| add_tensor(&mut sum, mu * branch.decay, overstress));
            sum
        }));
    }

    /// Advances by a step that ends at the stresses `now`, one per block.
    pub fn advance(&mut self, factors: &[Factors], now: &[Symmetric]) {
        for (block_tensors, now) in self.tensors.chunks_exact_mut(1 + self.branches).zip(now) {
            let mut change = *now;
            add_tensor(&mut change, -1.0, &block_tensors[0]);
            block_tensors[0] = *now;
            for (overstress, branch) in block_tensors[1..].iter_mut().zip(factors) {
                *overstress = overstress.map(|entry| entry * splat(branch.decay));
                add_tensor(overstress, branch.gain, &change);
            }
        }
    }
}

/// `sum` += `factor` `term`.
#[inline(always)]
pub(crate) fn add_tensor(sum: &mut Symmetric, factor: f64, term: &Symmetric) {
    sum.iter_mut().zip(term).for_each(|(sum, term)| *sum = sum.plus(splat(factor), *term));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slopes_of_the_factors_are_their_differences() {
        let (strength, time, step) = (0.2, 0.02, 0.01);
        let slopes = FactorSlopes::new([strength, time], step);
        let by = 1e-6;
        let [above, below] = [by, -by].map(|by| Factors::new([strength, time + by], step));
        assert!((slopes.decay_by_time - (above.decay - below.decay) / (2.0 * by)).abs() < 1e-6);
        assert!((slopes.gain_by_time - (above.gain - below.gain) / (2.0 * by)).abs() < 1e-6);
        assert!((slopes.gain_by_strength * strength - Factors::new([strength, time], step).gain).abs() < 1e-15);
    }
    use materials::{Branch, Moduli, Relaxation, step::RegionStep};

    #[test]
    fn it_holds_and_advances_as_a_region_of_the_materials_does() {
        let branches = [[0.2, 0.02], [0.1, 0.5]];
        let relaxation = Relaxation::maxwell(&branches.map(|[strength, time]| Branch { strength, time })).unwrap();
        let law = materials::by_name("neo_hookean").unwrap();
        let region = RegionStep::new(law, Moduli::of(2e5, 0.45), &relaxation, 0.01);
        let factors = branches.map(|branch| Factors::new(branch, 0.01));
        let (mut own, mut exact) = (History::at_rest(1, 2), vec![[0.0; 6]; 3]);
        let mut held = Vec::new();
        for step in 1..4 {
            let stress: [f64; 6] = std::array::from_fn(|n| 0.1 * f64::from(step) * (n as f64).cos());
            own.hold_stress(1.0, &factors, &mut held);
            let by = region.held_stress(&exact);
            (0..6).for_each(|n| assert!((held[0][n].to_array()[5] - by[n]).abs() < 1e-15));
            own.advance(&factors, &[stress.map(splat)]);
            region.advance_history(&mut exact, stress);
        }
        assert!((own.tensors[2][1].to_array()[0] - exact[2][1]).abs() < 1e-15 && exact[2][1] != 0.0);
    }
}
