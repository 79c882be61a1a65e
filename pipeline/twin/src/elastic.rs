//! Forces and stiffness of a solid, summed over its cubature points eight at a time.
//!
//! F = I + G q, f = Σ w Gᵀ P, K = Σ w Gᵀ (∂P/∂F) G.

use wide::f32x8;

use crate::data::Region;
use crate::lanes::{Blocks, LANES, Lanes, gather, per_lane, scatter};
use crate::law::{Constants, Deformed, NOTHING, Symmetric};
use crate::single_precision::SingleGradients;

/// A solid laid out for vectors.
#[derive(Debug, Clone)]
pub struct Solid {
    pub mu: f64,
    lambda: f64,
    stiffening: [f64; 2],
    pub branches: Vec<[f64; 2]>,
    pub(crate) weights: Vec<Lanes>,
    pub(crate) gradients: Blocks<9>,
    pub(crate) single: SingleGradients,
}

/// Stresses at a solid's points that a residual leaves, by block.
#[derive(Debug, Clone, Default)]
pub struct Stresses {
    /// I − C⁻¹.
    pub relaxing: Vec<Symmetric>,
    /// S of the law alone, Pa.
    pub law: Vec<Symmetric>,
}

impl Stresses {
    /// None yet, with room for so many blocks.
    pub(crate) fn with_capacity(blocks: usize) -> Self {
        Self { relaxing: Vec::with_capacity(blocks), law: Vec::with_capacity(blocks) }
    }
}

/// What acts at a solid's points in one step.
#[derive(Debug, Clone)]
pub struct Acting {
    pub constants: Constants,
    /// H of each block, Pa; empty: none.
    pub held: Vec<Symmetric>,
}

impl Solid {
    /// Of a region of `r` coordinates.
    pub fn new(region: &Region, r: usize) -> Self {
        let count = region.weights.len();
        let gradients = Blocks::new(count, r, |point, m, k| region.gradients[(point * r + m) * 9 + k]);
        let weight = |point: usize| region.weights.get(point).copied().unwrap_or(0.0);
        let weights: Vec<Lanes> =
            (0..gradients.block_count()).map(|block| per_lane(|i| weight(LANES * block + i))).collect();
        let single = SingleGradients::new(&gradients, &weights);
        let Region { mu, lambda, stiffening, ref branches, .. } = *region;
        Self { mu, lambda, stiffening, branches: branches.clone(), weights, gradients, single }
    }

    pub(crate) fn block_count(&self) -> usize {
        self.weights.len()
    }

    /// The constants of a step in which branches add `gain` to μ, relative.
    pub(crate) fn constants_with_gain(&self, gain: f64) -> Constants {
        Constants { mu: self.mu * (1.0 + gain), lambda: self.lambda, stiffening: self.stiffening }
    }

    /// Adds f (J) at q; `stresses` receives the stresses there.
    // They are kept from the last residual: reading the gradients once more after a step would cost a third of a residual, and the
    // state moves by less than the tolerance in between.
    pub fn add_forces(&self, q: &[f64], acting: &Acting, (forces, stresses): (&mut [Lanes], &mut Stresses)) {
        stresses.law.clear();
        stresses.relaxing.clear();
        for (block, weight) in self.weights.iter().enumerate() {
            let gradients = self.gradients.block(block);
            let deformed = Deformed::new(&gather(gradients, q), &acting.constants);
            scatter(gradients, &deformed.stress(&acting.constants, acting.held.get(block), *weight), forces);
            let relaxing = deformed.relaxing_stress();
            stresses.law.push(deformed.second_stress(&acting.constants, &relaxing));
            stresses.relaxing.push(relaxing);
        }
    }

    /// Adds the upper triangle of K (J) at q, row after row, its geometric part with the stresses of the law `former_stress` the step.
    pub fn add_stiffness(&self, q: &[f64], (acting, former_stress): (&Acting, &[Symmetric]), stiffness: &mut [f32x8]) {
        for block in 0..self.block_count() {
            let gradients = self.gradients.block(block);
            let deformed = Deformed::new(&gather(gradients, q), &acting.constants);
            let now = deformed.second_stress(&acting.constants, &deformed.relaxing_stress());
            let held_stress = acting.held.get(block).copied().unwrap_or(NOTHING);
            let former_stress = former_stress.get(block).copied().unwrap_or(now);
            // The moduli bring the law's geometric part with the stress of the iterate; the difference exchanges that
            // for the former one.
            let geometric: Symmetric = std::array::from_fn(|k| held_stress[k] + former_stress[k] - now[k]);
            self.single.add_tangent(block, &deformed, (&acting.constants, &geometric), stiffness);
        }
    }
}

/// Adds an upper triangle, row after row, to a symmetric matrix.
pub(crate) fn add_triangle(triangle: impl Iterator<Item = f64>, matrix: &mut [f64]) {
    let r = matrix.len().isqrt();
    let pairs = (0..r).flat_map(|m| (m..r).map(move |n| (m, n)));
    for ((m, n), sum) in pairs.zip(triangle) {
        matrix[m * r + n] += sum;
        if m != n {
            matrix[n * r + m] += sum;
        }
    }
}
