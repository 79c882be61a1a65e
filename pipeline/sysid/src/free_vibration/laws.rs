//! The ladder of laws that are fitted and compared: each adds one ingredient of real silicone.
//!
//! To add a law: its line in [`LADDER`]; to add an ingredient: its quantity, with its place in [`Law::properties`].

use fem::{Branch, Relaxation, Springpot};
use si::Second;

use super::condition::Properties;
use diagnostics::Result;

/// A parameter of a law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    /// E at the page's `modulus_time`, Pa.
    Modulus,
    /// α, 1/s.
    MassDamping,
    /// β, s.
    StiffnessDamping,
    /// g of the branch.
    BranchStrength,
    /// τ of the branch, s.
    BranchTime,
    /// Strength of the springpot.
    SpringpotStrength,
    /// Its exponent.
    SpringpotExponent,
    /// C₂₀/C₁₀.
    Softening,
}

/// How a quantity is searched: name, unit, start and bounds; on a logarithmic scale or not.
pub(super) struct Scale {
    pub name: &'static str,
    pub unit: &'static str,
    pub start: f64,
    pub range: [f64; 2],
    pub logarithmic: bool,
}

impl Quantity {
    pub(super) fn scale(self, modulus: [f64; 2]) -> Scale {
        let positive = |name, unit, start, range| Scale { name, unit, start, range, logarithmic: true };
        match self {
            Self::Modulus => positive("youngs_modulus", "Pa", (modulus[0] * modulus[1]).sqrt(), modulus),
            Self::MassDamping => positive("mass_damping", "1/s", 1.0, [1e-3, 50.0]),
            Self::StiffnessDamping => positive("stiffness_damping", "s", 1e-3, [1e-6, 0.05]),
            Self::BranchStrength => positive("branch_strength", "", 0.2, [1e-3, 5.0]),
            Self::BranchTime => positive("branch_time", "s", 0.02, [1e-4, 10.0]),
            Self::SpringpotStrength => positive("springpot_strength", "", 0.06, [1e-4, 1.0]),
            Self::SpringpotExponent => {
                Scale { logarithmic: false, ..positive("springpot_exponent", "", 0.25, [0.01, 0.9]) }
            }
            // Not by its logarithm: C₂₀ may be negative.
            Self::Softening => Scale { logarithmic: false, ..positive("c20_over_c10", "", 0.0, [-6.0, 6.0]) },
        }
    }
}

/// A law of the ladder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Law {
    pub name: &'static str,
    pub parameters: &'static [Quantity],
}

use Quantity::{
    BranchStrength, BranchTime, MassDamping, Modulus, Softening, SpringpotExponent, SpringpotStrength, StiffnessDamping,
};

/// All laws, from the simplest to the richest.
pub(super) const LADDER: &[Law] = &[
    Law { name: "elastic_beta", parameters: &[Modulus, StiffnessDamping] },
    Law { name: "elastic_alpha_beta", parameters: &[Modulus, MassDamping, StiffnessDamping] },
    Law { name: "maxwell", parameters: &[Modulus, BranchStrength, BranchTime] },
    Law { name: "springpot", parameters: &[Modulus, SpringpotStrength, SpringpotExponent] },
    Law { name: "springpot_yeoh", parameters: &[Modulus, SpringpotStrength, SpringpotExponent, Softening] },
    Law {
        name: "springpot_yeoh_alpha",
        parameters: &[Modulus, SpringpotStrength, SpringpotExponent, Softening, MassDamping],
    },
];

/// Decades of the springpot's branches: from shorter than a step to longer than a recording.
const DECADES: [i32; 2] = [-3, 2];

impl Law {
    /// The body's numbers at the `values` of the parameters; E belongs to the time `modulus_time` after loading.
    ///
    /// # Errors
    /// A diagnostic when a spectrum is refused.
    pub fn properties(&self, values: &[f64], modulus_time: Second) -> Result<Properties> {
        let value = |quantity: Quantity| {
            self.parameters.iter().position(|parameter| *parameter == quantity).map(|index| values[index])
        };
        let branch = value(BranchStrength).zip(value(BranchTime));
        let springpot = value(SpringpotStrength).zip(value(SpringpotExponent));
        let relaxation = match (branch, springpot) {
            (Some((strength, time)), _) => Relaxation::maxwell(&[Branch { strength, time }])?,
            (_, Some((strength, exponent))) => {
                Relaxation::springpot(Springpot { strength, exponent, decades: DECADES })?
            }
            _ => Relaxation::default(),
        };
        // C₃₀/C₁₀ = ½ (C₂₀/C₁₀)²: the least round multiple with which the stress rises at every strain, whatever C₂₀. Bars that bend
        // by a tenth of their length determine C₂₀ alone.
        let softening = value(Softening).unwrap_or(0.0);
        Ok(Properties {
            youngs_modulus: value(Modulus).unwrap_or(0.0) / relaxation.modulus(modulus_time),
            stiffening: [softening, 0.5 * softening * softening],
            relaxation,
            mass_damping: value(MassDamping).unwrap_or(0.0),
            stiffness_damping: value(StiffnessDamping).unwrap_or(0.0),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_law_has_its_own_name_and_the_modulus_first() {
        for (i, law) in LADDER.iter().enumerate() {
            assert_eq!(law.parameters[0], Modulus);
            assert!(LADDER[..i].iter().all(|other| other.name != law.name));
        }
    }

    #[test]
    fn the_modulus_belongs_to_its_time() {
        let law = LADDER[3];
        let is = law.properties(&[2e5, 0.1, 0.3], 3.0).unwrap();
        assert!((is.youngs_modulus * is.relaxation.modulus(3.0) / 2e5 - 1.0).abs() < 1e-12);
        assert_eq!(LADDER[0].properties(&[2e5, 1e-3], 3.0).unwrap().youngs_modulus, 2e5);
    }
}
