//! Relaxation spectra: Maxwell branches, given freely or as a springpot.

use si::Second;

/// A relaxation spectrum that no solid can have.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "relaxation branch {branch}: {what}, not {value}\n  why: each branch adds strength × e^(−t/time) to the long-term modulus\n  do:  give a strength ≥ 0 (no unit, relative to the long-term modulus) and a time in seconds"
)]
pub struct RelaxationError {
    /// Which branch, from 0.
    pub branch: usize,
    /// What is wrong.
    pub what: &'static str,
    /// The number.
    pub value: f64,
}

/// One Maxwell branch.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Branch {
    /// g: modulus of the branch over the long-term modulus, no unit.
    pub strength: f64,
    /// τ, s.
    pub time: Second,
}

/// A springpot laid out as one branch per decade: gᵢ = s (τᵢ / 1 s)⁻ⁿ at τᵢ = 10ᵏ s.
///
/// Its relaxation modulus falls like a power of time, as that of silicone does: the fractional Kelvin–Voigt solid
/// μ [1 + (iωτ₀)ⁿ] has s = (sin nπ / π) (2/n) sinh(n ln 10 / 2) (τ₀ / 1 s)ⁿ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Springpot {
    /// s: strength of the branch of one second.
    pub strength: f64,
    /// n, between 0 and 1.
    pub exponent: f64,
    /// k of the fastest and of the slowest branch.
    pub decades: [i32; 2],
}

impl Springpot {
    /// The branch of each decade, the fastest first.
    fn branches(&self) -> Vec<Branch> {
        let branch = |time: Second| Branch { strength: self.strength * time.powf(-self.exponent), time };
        self.times().map(branch).collect()
    }

    fn times(&self) -> impl Iterator<Item = Second> {
        (self.decades[0]..=self.decades[1]).map(|decade| 10f64.powi(decade))
    }

    /// ∂gᵢ by strength and by exponent, of each branch.
    fn derivatives(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        self.times().map(|time| {
            let power = time.powf(-self.exponent);
            [power, -self.strength * power * time.ln()]
        })
    }
}

/// Relaxation of the shear part of a law: μ(t) = μ (1 + Σ gᵢ e^(−t/τᵢ)); none by default.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Relaxation {
    branches: Vec<Branch>,
    springpot: Option<Springpot>,
}

/// Most branches of one region: histories take 48 bytes for each at every quadrature point.
pub const MAX_BRANCHES: usize = 16;

impl Relaxation {
    /// Free branches.
    ///
    /// # Errors
    /// [`RelaxationError`] when a strength is negative or a time not positive, or there are too many.
    pub fn maxwell(branches: &[Branch]) -> Result<Self, RelaxationError> {
        Self { branches: branches.to_vec(), springpot: None }.checked()
    }

    /// A springpot.
    ///
    /// # Errors
    /// [`RelaxationError`] when the strength is negative, the exponent not between 0 and 1, or the decades do
    /// not rise within 10⁻⁹ to 10⁹ s.
    pub fn springpot(of: Springpot) -> Result<Self, RelaxationError> {
        let refused = |branch, what, value| Err(RelaxationError { branch, what, value });
        let [first, last] = of.decades;
        if !(of.exponent > 0.0 && of.exponent < 1.0) {
            return refused(0, "the exponent of a springpot must lie between 0 and 1", of.exponent);
        }
        if first > last || first < -9 || last > 9 {
            return refused(0, "the decades of a springpot must rise within -9 to 9", f64::from(first));
        }
        Self { branches: of.branches(), springpot: Some(of) }.checked()
    }

    fn checked(self) -> Result<Self, RelaxationError> {
        let refused = |branch, what, value| Err(RelaxationError { branch, what, value });
        if self.branches.len() > MAX_BRANCHES {
            return refused(MAX_BRANCHES, "at most 16 branches are possible", self.branches.len() as f64);
        }
        for (number, &Branch { strength, time }) in self.branches.iter().enumerate() {
            if !(time > 0.0 && time.is_finite()) {
                return refused(number, "its time must be above 0 s", time);
            }
            if !(strength >= 0.0 && strength.is_finite()) {
                return refused(
                    number,
                    "a negative strength would create energy and can make the modulus negative",
                    strength,
                );
            }
        }
        Ok(self)
    }

    /// The branches.
    pub fn branches(&self) -> &[Branch] {
        &self.branches
    }

    /// The springpot that the branches stand for, if they do.
    pub fn as_springpot(&self) -> Option<Springpot> {
        self.springpot
    }

    /// Whether there is nothing to relax.
    pub fn is_none(&self) -> bool {
        self.branches.is_empty()
    }

    /// μ(t) / μ, a time t after a step of strain.
    pub fn modulus(&self, time: Second) -> f64 {
        1.0 + self.branches.iter().map(|branch| branch.strength * (-time / branch.time).exp()).sum::<f64>()
    }

    /// The stress over μ and the strain, a time after a step of stress that is held: one over the creep compliance. It is above
    /// [`Relaxation::modulus`], as creep lags behind relaxation.
    // The convolution with the strain, linear over steps that grow by a tenth, exactly in each branch.
    pub fn creep_modulus(&self, time: Second) -> f64 {
        const STEPS: i32 = 120;
        if self.is_none() || time.is_infinite() {
            return 1.0;
        }
        let mut strain = 1.0 / self.modulus(0.0);
        let mut stresses: Vec<f64> = self.branches.iter().map(|branch| branch.strength * strain).collect();
        let mut passed = 0.0;
        for step in (0..STEPS).rev() {
            let next = time * 1.1_f64.powi(-step);
            let decay = |branch: &Branch| (-(next - passed) / branch.time).exp();
            let mean_decay = |branch: &Branch| branch.time / (next - passed) * (1.0 - decay(branch));
            stresses.iter_mut().zip(&self.branches).for_each(|(stress, branch)| *stress *= decay(branch));
            let stiffness: f64 = self.branches.iter().map(|branch| branch.strength * mean_decay(branch)).sum();
            let increment = (1.0 - strain - stresses.iter().sum::<f64>()) / (1.0 + stiffness);
            let gains = self.branches.iter().map(|branch| branch.strength * mean_decay(branch) * increment);
            stresses.iter_mut().zip(gains).for_each(|(stress, gain)| *stress += gain);
            (strain, passed) = (strain + increment, next);
        }
        1.0 / strain
    }

    /// Storage and loss modulus over μ at an angular frequency `omega`, rad/s.
    pub fn complex_modulus(&self, omega: f64) -> [f64; 2] {
        self.branches.iter().fold([1.0, 0.0], |[storage, loss], branch| {
            let x = omega * branch.time;
            let part = branch.strength / (1.0 + x * x);
            [storage + part * x * x, loss + part * x]
        })
    }

    /// The gradient by strength and exponent of the springpot, from that by the strength of each branch; `None` when
    /// the branches are free.
    pub fn springpot_gradient(&self, by_strength: &[f64]) -> Option<[f64; 2]> {
        let springpot = self.springpot?;
        let parts = springpot.derivatives().zip(by_strength);
        Some(parts.fold([0.0; 2], |sum, (by, of)| [0, 1].map(|n| sum[n] + by[n] * of)))
    }

    /// ∂gᵢ by strength (0) or exponent (1) of the springpot, of each branch; nothing when the branches are free.
    pub fn springpot_direction(&self, which: usize) -> Vec<f64> {
        self.springpot
            .iter()
            .flat_map(|springpot| springpot.derivatives().map(|by| by[which]).collect::<Vec<_>>())
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SILICONE: Springpot = Springpot { strength: 0.06, exponent: 0.27, decades: [-5, 4] };

    /// J = 1 − g/(1 + g) e^(−t/τ(1+g)) of the standard linear solid.
    #[test]
    fn a_held_stress_creeps_with_the_time_of_retardation() {
        let (strength, relaxation_time) = (0.3, 0.4);
        let solid = Relaxation::maxwell(&[Branch { strength, time: relaxation_time }]).unwrap();
        for time in [1e-6, 0.01, 0.3, 2.0, f64::INFINITY] {
            let compliance = 1.0 - strength / (1.0 + strength) * (-time / (relaxation_time * (1.0 + strength))).exp();
            assert!((solid.creep_modulus(time) * compliance - 1.0).abs() < 1e-4, "{time}");
            assert!(solid.creep_modulus(time) >= solid.modulus(time) - 1e-12);
        }
    }

    /// μ* = 1 + (iωτ₀)ⁿ of Ecoflex 00-30, τ₀ = 260 µs, n = 0.27.
    #[test]
    fn one_branch_per_decade_follows_the_fractional_kelvin_voigt_solid() {
        let n: f64 = 0.27;
        let strength = (n * std::f64::consts::PI).sin() / std::f64::consts::PI
            * (2.0 / n)
            * (0.5 * n * std::f64::consts::LN_10).sinh()
            * 2.6e-4_f64.powf(n);
        let springpot = Relaxation::springpot(Springpot { strength, exponent: n, decades: [-6, 5] }).unwrap();
        for frequency in [0.1, 0.3, 1.0, 3.0, 10.0] {
            let omega: f64 = std::f64::consts::TAU * frequency;
            let (size, angle) = ((omega * 2.6e-4).powf(n), 0.5 * n * std::f64::consts::PI);
            let [storage, loss] = springpot.complex_modulus(omega);
            assert!((storage / (1.0 + size * angle.cos()) - 1.0).abs() < 0.01, "{frequency}: {storage}");
            assert!((loss / (size * angle.sin()) - 1.0).abs() < 0.06, "{frequency}: {loss}");
        }
    }

    #[test]
    fn the_modulus_falls_from_the_sum_of_all_branches_to_the_long_term_one() {
        let relaxation = Relaxation::springpot(SILICONE).unwrap();
        let sum: f64 = relaxation.branches().iter().map(|branch| branch.strength).sum();
        assert!((relaxation.modulus(0.0) - 1.0 - sum).abs() < 1e-12);
        assert!((relaxation.modulus(1e7) - 1.0).abs() < 1e-12);
        assert!((relaxation.complex_modulus(1e9)[0] - 1.0 - sum).abs() < 1e-6);
    }

    #[test]
    fn the_springpots_derivatives_are_those_of_its_branches() {
        let strengths = |s: f64, n: f64| {
            let of = Springpot { strength: s, exponent: n, ..SILICONE };
            Relaxation::springpot(of).unwrap().branches().iter().map(|b| b.strength).collect::<Vec<_>>()
        };
        let relaxation = Relaxation::springpot(SILICONE).unwrap();
        let h = 1e-6;
        let by_strength = strengths(0.06 + h, 0.27).into_iter().zip(strengths(0.06 - h, 0.27));
        let by_exponent = strengths(0.06, 0.27 + h).into_iter().zip(strengths(0.06, 0.27 - h));
        for (exact, (above, below)) in relaxation.springpot_direction(0).into_iter().zip(by_strength) {
            assert!((exact - (above - below) / (2.0 * h)).abs() < 1e-8 * exact.abs());
        }
        for (exact, (above, below)) in relaxation.springpot_direction(1).into_iter().zip(by_exponent) {
            assert!((exact - (above - below) / (2.0 * h)).abs() < 1e-7 * (1.0 + exact.abs()));
        }
        let by: Vec<f64> = (0..10).map(|k| f64::from(k) - 3.0).collect();
        let sum = |which| relaxation.springpot_direction(which).iter().zip(&by).map(|(a, b)| a * b).sum::<f64>();
        assert_eq!(relaxation.springpot_gradient(&by), Some([sum(0), sum(1)]));
    }

    #[test]
    fn what_no_solid_can_do_is_refused() {
        let branch =
            |strength, time| Relaxation::maxwell(&[Branch { strength: 0.1, time: 1.0 }, Branch { strength, time }]);
        assert!(branch(0.1, 0.0).unwrap_err().to_string().contains("branch 1: its time must be above 0 s, not 0"));
        assert!(branch(-1.2, 1.0).unwrap_err().to_string().contains("negative"));
        for exponent in [0.0, 1.0, f64::NAN] {
            assert!(Relaxation::springpot(Springpot { exponent, ..SILICONE }).is_err());
        }
        assert!(Relaxation::springpot(Springpot { decades: [2, 1], ..SILICONE }).is_err());
        assert!(Relaxation::maxwell(&[Branch { strength: 0.0, time: 1.0 }; 17]).is_err());
    }
}
