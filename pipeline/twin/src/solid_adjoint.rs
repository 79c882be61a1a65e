//! Adjoint of a solid with relaxation, at its cubature points eight side by side.
//!
//! With the overstress Qₙ = dₙ Qₙ₋₁ + aₙ (Sₙ − Sₙ₋₁) of a branch, the residual of a step holds F μ Σ Qₙ. Given its adjoint λₙ, X = w sym(Fᵀ G λₙ) and
//! the total derivative of the loss by Qₙ is Yₙ = μ Xₙ + dₙ₊₁ Yₙ₊₁: one tensor a branch, which needs no history. The derivative by dₙ, which
//! is Yₙ : Qₙ₋₁, needs none either: Σ Yₙ d′ₙ : Qₙ₋₁ = Σ Tₙ : aₙ (Sₙ − Sₙ₋₁) with Tₙ = d′ₙ₊₁ Yₙ₊₁ + dₙ₊₁ Tₙ₊₁.

use crate::elastic::{Acting, Solid};
use crate::gradient::RegionGradient;
use crate::history::{FactorSlopes, Factors, add_tensor};
use wide::f32x8;

use crate::lanes::{Lanes, gather, scatter, splat};
use crate::law::{Deformed, NOTHING, Symmetric, Tensor, at, nine, reduced_invariant};

/// A solid's adjoint while a motion is passed backwards.
pub(crate) struct SolidAdjoint<'a> {
    solid: &'a Solid,
    /// Of the step that was passed last; nothing before the first.
    after: Vec<BranchStep>,
    /// blocks × branches: Y and T.
    tensors: Vec<[Symmetric; 2]>,
    points: Vec<Point>,
    sums: Sums,
}

/// A branch over one step.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct BranchStep {
    factors: Factors,
    slopes: FactorSlopes,
}

/// A block of points at one step.
struct Point {
    here: Deformed,
    /// S = I − C⁻¹.
    stress: Symmetric,
}

/// Derivatives in lanes.
struct Sums {
    moduli: [Lanes; 4],
    branches: Vec<[Lanes; 2]>,
}

impl<'a> SolidAdjoint<'a> {
    /// Before the last step.
    pub fn new(solid: &'a Solid) -> Self {
        let branches = solid.branches.len();
        Self {
            solid,
            after: vec![BranchStep::default(); branches],
            tensors: vec![[NOTHING; 2]; solid.block_count() * branches],
            points: Vec::new(),
            sums: Sums { moduli: [Lanes::ZERO; 4], branches: vec![[Lanes::ZERO; 2]; branches] },
        }
    }

    /// Its branches over a step of `duration` seconds.
    pub(crate) fn branch_steps(&self, duration: f64) -> Vec<BranchStep> {
        let branch_step = |branch: &[f64; 2]| BranchStep {
            factors: Factors::new(*branch, duration),
            slopes: FactorSlopes::new(*branch, duration),
        };
        self.solid.branches.iter().map(branch_step).collect()
    }

    /// What acts in a step.
    pub(crate) fn acting_in_step(&self, now: &[BranchStep], held: Vec<Symmetric>) -> Acting {
        Acting { constants: self.solid.constants_with_gain(now.iter().map(|by| by.factors.gain).sum()), held }
    }

    /// Adds the upper triangle of K (J) at q in single precision, and to `loss` what later steps depend on q by through the histories.
    pub(crate) fn add_tangent(
        &mut self,
        q: &[f64],
        acting: &Acting,
        now: &[BranchStep],
        (stiffness, loss): (&mut [f32x8], &mut [Lanes]),
    ) {
        self.points.clear();
        for block in 0..self.solid.block_count() {
            let gradients = self.solid.gradients.block(block);
            let deformed = Deformed::new(&gather(gradients, q), &acting.constants);
            let stress = deformed.relaxing_stress();
            if !now.is_empty() {
                scatter(gradients, &stress_derivative(&deformed, &stress, &self.later_dependence(block, now)), loss);
            }
            let held_stress = acting.held.get(block).unwrap_or(&NOTHING);
            self.solid.single.add_tangent(block, &deformed, (&acting.constants, held_stress), stiffness);
            self.points.push(Point { here: deformed, stress });
        }
    }

    /// Adds K x (J), with the K of the last tangent in double precision.
    pub(crate) fn add_product(&self, x: &[f64], acting: &Acting, image: &mut [Lanes]) {
        for (block, (point, weight)) in self.points.iter().zip(&self.solid.weights).enumerate() {
            let gradients = self.solid.gradients.block(block);
            let held_stress = acting.held.get(block).unwrap_or(&NOTHING);
            let change = point.here.stress_change(&acting.constants, held_stress, &gather(gradients, x));
            scatter(gradients, &change.map(|entry| entry * *weight), image);
        }
    }

    /// What later steps depend on S of this one by: Σ (a d₊ − a₊) Y₊ over the branches.
    fn later_dependence(&self, block: usize, now: &[BranchStep]) -> Symmetric {
        let mut sum = NOTHING;
        let block_tensors = &self.tensors[block * now.len()..];
        for ((now, after), [y, _]) in now.iter().zip(&self.after).zip(block_tensors) {
            add_tensor(&mut sum, now.factors.gain * after.factors.decay - after.factors.gain, y);
        }
        sum
    }

    /// Passes the step of the last tangent, whose residual has this adjoint.
    pub(crate) fn pass_step(&mut self, adjoint: &[f64], acting: &Acting, now: Vec<BranchStep>) {
        let gain = 1.0 + now.iter().map(|by| by.factors.gain).sum::<f64>();
        let of_mu = 1.0 / self.solid.mu;
        for (block, point) in self.points.iter().enumerate() {
            let weight = self.solid.weights[block];
            let strain =
                weighted_strain(&point.here.gradient, &gather(self.solid.gradients.block(block), adjoint), weight);
            let held_work =
                acting.held.get(block).map_or(Lanes::ZERO, |held_work| double_contraction(held_work, &strain));
            self.sums.add_block(point, &strain, [splat(gain), held_work * splat(of_mu)]);
            let block_tensors = &mut self.tensors[block * now.len()..(block + 1) * now.len()];
            for (((tensors, now), after), sums) in
                block_tensors.iter_mut().zip(&now).zip(&self.after).zip(&mut self.sums.branches)
            {
                pass_branch(tensors, [now, after], (&strain.map(|x| x * splat(self.solid.mu)), &point.stress), sums);
            }
        }
        self.after = now;
    }

    /// The derivatives after the first step was passed.
    pub fn gradient(&self) -> RegionGradient {
        let [mu, lambda, c20, c30] = self.sums.moduli.map(Lanes::sum);
        let branches = self.sums.branches.iter().map(|by| by.map(Lanes::sum)).collect();
        RegionGradient { mu, lambda, stiffening: [c20, c30], branches }
    }
}

impl Sums {
    /// Adds the derivatives by the moduli at a block; `gain` is what multiplies μ in the law, `held` the held part's derivative by μ.
    #[inline(always)]
    fn add_block(&mut self, point: &Point, strain: &Symmetric, [gain, held]: [Lanes; 2]) {
        // (F − G) : δF = S : Fᵀ δF and G : δF = C⁻¹ : Fᵀ δF with C⁻¹ = I − S
        let relaxing_work = double_contraction(&point.stress, strain);
        let x = reduced_invariant(&point.here.gradient, point.here.ln_volume);
        let volume = strain[0] + strain[1] + strain[2] - relaxing_work;
        let derivatives = [
            gain * relaxing_work + held,
            point.here.ln_volume * volume,
            splat(4.0) * x * relaxing_work,
            splat(6.0) * x * x * relaxing_work,
        ];
        self.moduli.iter_mut().zip(derivatives).for_each(|(sum, derivatives)| *sum = *sum + derivatives);
    }
}

/// Y and T of one branch at a block, from those of the step after it; adds the derivatives by strength and time.
#[inline(always)]
fn pass_branch(
    [y, t]: &mut [Symmetric; 2],
    [now, after]: [&BranchStep; 2],
    (strain, stress): (&Symmetric, &Symmetric),
    [by_strength, by_time]: &mut [Lanes; 2],
) {
    let (later_y, later_t) = (double_contraction(stress, y), double_contraction(stress, t));
    for k in 0..6 {
        t[k] = (t[k] * splat(after.factors.decay)).plus(splat(after.slopes.decay_by_time), y[k]);
        y[k] = strain[k].plus(splat(after.factors.decay), y[k]);
    }
    let (own_y, own_t) = (double_contraction(stress, y), double_contraction(stress, t));
    let change = |own: (Lanes, f64), later: (Lanes, f64)| own.0 * splat(own.1) - later.0 * splat(later.1);
    *by_strength =
        *by_strength + change((own_y, now.slopes.gain_by_strength), (later_y, after.slopes.gain_by_strength));
    *by_time = *by_time
        + change((own_y, now.slopes.gain_by_time), (later_y, after.slopes.gain_by_time))
        + change((own_t, now.factors.gain), (later_t, after.factors.gain));
}

/// w sym(Fᵀ δF); the entries off the diagonal are those of both sides.
#[inline(always)]
fn weighted_strain(f: &Tensor, change: &Tensor, weight: Lanes) -> Symmetric {
    let entry = |a: usize, b: usize| {
        (f[at(0, a)] * change[at(0, b)]).plus(f[at(1, a)], change[at(1, b)]).plus(f[at(2, a)], change[at(2, b)])
    };
    let [yz, xz, xy] = [(1, 2), (0, 2), (0, 1)].map(|(a, b)| (entry(a, b) + entry(b, a)) * weight);
    [entry(0, 0) * weight, entry(1, 1) * weight, entry(2, 2) * weight, yz, xz, xy]
}

/// Σ over the six entries of a stress and of what [`weighted_strain`] returns.
#[inline(always)]
fn double_contraction(a: &Symmetric, b: &Symmetric) -> Lanes {
    let half = |k: usize| (a[k] * b[k]).plus(a[k + 1], b[k + 1]).plus(a[k + 2], b[k + 2]);
    half(0) + half(3)
}

/// ∂(Z : S)/∂F = 2 G Z C⁻¹, Z the derivatives by the six entries of S.
#[inline(always)]
fn stress_derivative(deformed: &Deformed, stress: &Symmetric, by_stress: &Symmetric) -> Tensor {
    let full_tensor = |[xx, yy, zz, yz, xz, xy]: [Lanes; 6]| [xx, xy, xz, xy, yy, yz, xz, yz, zz];
    let (half, one) = (splat(0.5), splat(1.0));
    let z = full_tensor([
        by_stress[0],
        by_stress[1],
        by_stress[2],
        half * by_stress[3],
        half * by_stress[4],
        half * by_stress[5],
    ]);
    let mut inverse = stress.map(|entry| Lanes::ZERO - entry);
    inverse[..3].iter_mut().for_each(|entry| *entry = *entry + one);
    let image = matrix_product(&z, &full_tensor(inverse));
    matrix_product(&deformed.cofactor, &image).map(|entry| entry + entry)
}

/// A B.
#[inline(always)]
fn matrix_product(a: &Tensor, b: &Tensor) -> Tensor {
    nine(|i, k| (a[at(i, 0)] * b[at(0, k)]).plus(a[at(i, 1)], b[at(1, k)]).plus(a[at(i, 2)], b[at(2, k)]))
}
