//! One step of a region's branches at a point, with all derivatives; `fem` says how they enter a time step.

use crate::material::{Material, Moduli};
use crate::relaxation::{Branch, Relaxation};
use crate::symmetric::{Symmetric, add_scaled, full_tensor, symmetric_part};
use nalgebra::Matrix3;
use si::{Pascal, Second};

/// The factors of one branch over a step: Q ← decay Q + gain ΔS.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BranchStep {
    /// Its strength and time.
    pub branch: Branch,
    /// d = e^(−x), x = h/τ.
    pub decay: f64,
    /// a = g (1 − e^(−x))/x.
    pub gain: f64,
    /// h, s.
    step: Second,
}

impl BranchStep {
    /// Of `branch` over a step of `step` seconds.
    pub fn new(branch: Branch, step: Second) -> Self {
        let x = step / branch.time;
        Self { branch, decay: (-x).exp(), gain: branch.strength * mean_decay(x), step }
    }

    /// ∂a/∂g.
    pub fn gain_by_strength(&self) -> f64 {
        mean_decay(self.step / self.branch.time)
    }

    /// ∂d/∂τ and ∂a/∂τ, 1/s.
    pub fn by_time(&self) -> [f64; 2] {
        let x = self.step / self.branch.time;
        // (1 − e^(−x))/x has the slope (e^(−x) (1 + x) − 1)/x², and the series −1/2 + x/3 where that cancels.
        let slope = if x < 1e-4 { -0.5 + x / 3.0 } else { (self.decay * (1.0 + x) - 1.0) / (x * x) };
        let by_time = -x / self.branch.time;
        [-self.decay * by_time, self.branch.strength * slope * by_time]
    }
}

/// (1 − e^(−x))/x, the mean of e^(−s) over 0 to x.
fn mean_decay(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { -(-x).exp_m1() / x }
}

/// One step of one region.
#[derive(Debug, Clone)]
pub struct RegionStep {
    /// The law.
    pub material: &'static dyn Material,
    /// The long-term moduli.
    pub moduli: Moduli,
    /// μ, Pa.
    pub mu: Pascal,
    /// Nothing: the region is elastic.
    pub branches: Vec<BranchStep>,
}

#[allow(non_snake_case)]
impl RegionStep {
    /// Of a region with the long-term `moduli` over a step of `step` seconds.
    pub fn new(material: &'static dyn Material, moduli: Moduli, relaxation: &Relaxation, step: Second) -> Self {
        let branches = relaxation.branches().iter().map(|&branch| BranchStep::new(branch, step)).collect();
        Self { material, moduli, mu: moduli.mu, branches }
    }

    /// A = Σ a.
    pub fn gain(&self) -> f64 {
        self.branches.iter().map(|branch| branch.gain).sum()
    }

    /// S_μ / μ = F⁻¹ P_μ / μ.
    pub fn stress(&self, F: &Matrix3<f64>) -> Symmetric {
        match F.try_inverse() {
            Some(inverse) => symmetric_part(&(inverse * self.material.energy_and_stress(F, Moduli::unit_modulus(0)).1)),
            None => [0.0; 6],
        }
    }

    /// ΔS_μ / μ = F⁻¹ (∂P_μ : ΔF − ΔF S_μ) / μ at F for a change ΔF.
    pub fn stress_change(&self, F: &Matrix3<f64>, change: &Matrix3<f64>) -> Symmetric {
        let Some(inverse) = F.try_inverse() else { return [0.0; 6] };
        let response = self.material.constitutive_response(F, Moduli::unit_modulus(0));
        let dP = response.tangent * nalgebra::SVector::<f64, 9>::from_column_slice(change.as_slice());
        let dP = Matrix3::from_column_slice(dP.as_slice());
        symmetric_part(&(inverse * (dP - change * inverse * response.stress)))
    }

    /// ∂(T : S_μ / μ)/∂F for a symmetric T: the transpose of [`RegionStep::stress_change`].
    pub fn stress_pulled_back(&self, F: &Matrix3<f64>, T: &Symmetric) -> Matrix3<f64> {
        let Some(inverse) = F.try_inverse() else { return Matrix3::zeros() };
        let response = self.material.constitutive_response(F, Moduli::unit_modulus(0));
        let covariant = inverse.transpose() * full_tensor(T);
        // ∂P is symmetric, so that its transpose is itself.
        let image = response.tangent * nalgebra::SVector::<f64, 9>::from_column_slice(covariant.as_slice());
        Matrix3::from_column_slice(image.as_slice()) - covariant * (inverse * response.stress).transpose()
    }

    /// H / μ from a point's history: S_μ / μ, then the overstress of each branch.
    pub fn held_stress(&self, history: &[Symmetric]) -> Symmetric {
        let mut stress = [0.0; 6];
        for (branch, overstress) in self.branches.iter().zip(&history[1..]) {
            add_scaled(&mut stress, branch.decay, overstress);
            add_scaled(&mut stress, -branch.gain, &history[0]);
        }
        stress
    }

    /// The history after a step that ends at the stress `stress`, in the place of the one before.
    pub fn advance_history(&self, history: &mut [Symmetric], stress: Symmetric) {
        let mut change = stress;
        add_scaled(&mut change, -1.0, &history[0]);
        for (branch, overstress) in self.branches.iter().zip(&mut history[1..]) {
            overstress.iter_mut().for_each(|entry| *entry *= branch.decay);
            add_scaled(overstress, branch.gain, &change);
        }
        history[0] = stress;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::by_name;
    use crate::symmetric::double_contraction;

    fn region() -> RegionStep {
        let material = by_name("yeoh").unwrap();
        let moduli = Moduli::of(2e5, 0.45).with_stiffening([-0.05, 0.02]);
        RegionStep::new(material, moduli, &Relaxation::default(), 0.01)
    }

    #[test]
    fn the_factors_of_a_branch_are_the_integrals_of_its_decay_and_have_their_derivatives() {
        for (time, step) in [(0.1, 0.01), (1e-3, 0.02), (10.0, 1e-5)] {
            let of = |g: f64, t: f64| BranchStep::new(Branch { strength: g, time: t }, step);
            let exact = of(0.3, time);
            let h = 1e-5 * time;
            let [decay, gain] = exact.by_time();
            let (above, below) = (of(0.3, time + h), of(0.3, time - h));
            assert!((decay - (above.decay - below.decay) / (2.0 * h)).abs() < 1e-6 * (1.0 + decay.abs()));
            assert!((gain - (above.gain - below.gain) / (2.0 * h)).abs() < 1e-6 * (1.0 + gain.abs()));
            assert!((exact.gain_by_strength() * 0.3 - exact.gain).abs() < 1e-15);
            let integral: f64 = (0..1000).map(|k| (-(f64::from(k) + 0.5) * step / 1000.0 / time).exp() / 1000.0).sum();
            assert!((exact.gain / 0.3 - integral).abs() < 1e-4 * integral);
        }
    }

    #[test]
    fn the_change_of_the_stress_and_its_transpose_are_derivatives() {
        let at = Matrix3::new(1.3, 0.2, -0.1, 0.1, 0.8, 0.2, 0.15, 0.1, 1.1);
        let change = Matrix3::new(0.4, -0.3, 0.2, 0.5, 0.1, -0.6, 0.3, 0.2, -0.2);
        let (region, h) = (region(), 1e-6);
        let (above, below) = (region.stress(&(at + change * h)), region.stress(&(at - change * h)));
        let exact = region.stress_change(&at, &change);
        (0..6).for_each(|n| assert!((exact[n] - (above[n] - below[n]) / (2.0 * h)).abs() < 1e-8));
        let tensor = [0.3, -0.2, 0.5, 0.1, 0.7, -0.4];
        let back = region.stress_pulled_back(&at, &tensor);
        assert!((back.dot(&change) - double_contraction(&tensor, &exact)).abs() < 1e-12);
    }

    #[test]
    fn a_step_leaves_the_overstress_that_was_held_and_gained() {
        let material = by_name("neo_hookean").unwrap();
        let branches = [Branch { strength: 0.2, time: 0.02 }, Branch { strength: 0.1, time: 0.5 }];
        let relaxation = Relaxation::maxwell(&branches).unwrap();
        let region = RegionStep::new(material, Moduli::of(2e5, 0.45), &relaxation, 0.01);
        let stress = region.stress(&Matrix3::new(1.1, 0.0, 0.1, 0.0, 1.0, 0.0, 0.0, 0.0, 0.95));
        let mut history = vec![[0.1, 0.0, 0.0, 0.0, 0.02, 0.0], [0.3; 6], [-0.2; 6]];
        let mut expected = region.held_stress(&history);
        add_scaled(&mut expected, region.gain(), &stress);
        region.advance_history(&mut history, stress);
        (0..6).for_each(|n| assert!((history[1][n] + history[2][n] - expected[n]).abs() < 1e-15));
        assert_eq!(history[0], stress);
    }

    #[test]
    fn a_step_that_is_short_beside_a_branchs_time_has_the_derivatives_of_the_series() {
        // a(τ) = g (1 − x/2 + x²/6) with x = h/τ: ∂a/∂τ = g (x/2 − x²/3)/τ
        let (strength, time, step) = (0.3, 2.0, 1e-5);
        let x = step / time;
        let [decay, gain] = BranchStep::new(Branch { strength, time }, step).by_time();
        assert!((gain / (strength * (x / 2.0 - x * x / 3.0) / time) - 1.0).abs() < 1e-9, "{gain}");
        assert!((decay / ((-x).exp() * x / time) - 1.0).abs() < 1e-12, "{decay}");
    }
}
