//! The laws between which a joint fit chooses, and what is shared by all tests of one material.

use fem::{Relaxation, Springpot};
use si::{Hertz, Pascal, Second};

use super::parameters::Parameter;
use crate::free_vibration::condition::Properties;
use crate::inflation_test::inflated::creep_elasticity;
use diagnostics::Result;

/// The time after loading to which Young's moduli of a joint fit belong, s: tensile tests and holds of pressures take as long.
pub(super) const MODULUS_TIME: Second = 3.0;
/// Decades of the springpot's branches: from shorter than a step to longer than a recording.
const DECADES: [i32; 2] = [-3, 2];

/// A further coefficient of a law, over C₁₀.
#[derive(Debug, Clone, Copy)]
pub(super) struct Term {
    /// 0: C₂₀, 1: C₃₀.
    pub which: usize,
    pub start: f64,
    pub range: [f64; 2],
}

/// A law of elasticity, with the coefficients that are fitted.
#[derive(Debug)]
pub(super) struct Law {
    pub name: &'static str,
    /// In `materials`.
    pub material: &'static str,
    pub terms: &'static [Term],
    /// E where the search begins, Pa: stiff enough that no wall balloons.
    pub start: Pascal,
}

const fn term(which: usize, start: f64, range: [f64; 2]) -> Term {
    Term { which, start, range }
}

/// From the plainest to the richest.
pub(super) const LAWS: &[Law] = &[
    Law { name: "neo_hookean", material: "neo_hookean", terms: &[], start: 3.2e5 },
    Law { name: "yeoh_c20", material: "yeoh", terms: &[term(0, 1.2, [-0.5, 5.0])], start: 2.6e5 },
    Law {
        name: "yeoh",
        material: "yeoh",
        terms: &[term(0, 1.2, [-0.5, 5.0]), term(1, 0.0, [-1.0, 3.0])],
        start: 2.6e5,
    },
    Law {
        name: "lopez_pamies",
        material: "lopez_pamies",
        terms: &[term(0, 2.5, [-0.5, 10.0]), term(1, 0.0, [-12.0, 8.0])],
        start: 2.6e5,
    },
    Law {
        name: "lopez_pamies_m5",
        material: "lopez_pamies_m5",
        terms: &[term(0, 7.0, [-1.0, 30.0]), term(1, 0.0, [-4.0, 0.9])],
        start: 2.6e5,
    },
    Law {
        name: "lopez_pamies_m15",
        material: "lopez_pamies_m15",
        terms: &[term(0, 7.0, [-1.0, 30.0]), term(1, 0.0, [-4.0, 0.9])],
        start: 2.6e5,
    },
    Law {
        name: "lopez_pamies_m60",
        material: "lopez_pamies_m60",
        terms: &[term(0, 7.0, [-1.0, 30.0]), term(1, 0.0, [-4.0, 0.9])],
        start: 2.6e5,
    },
    Law {
        name: "ogden",
        material: "ogden",
        terms: &[term(0, 0.8, [-0.4, 4.0]), term(1, 0.0, [-0.4, 2.0])],
        start: 2.6e5,
    },
];

/// Number of the shared parameters before the law's own.
const SHARED: usize = 4;

/// A material at a point of the search.
#[derive(Debug, Clone)]
pub(super) struct Constants {
    /// Long-term E, Pa.
    pub youngs_modulus: Pascal,
    /// C₂₀/C₁₀ and C₃₀/C₁₀ at long times.
    pub stiffening: [f64; 2],
    pub relaxation: Relaxation,
    /// α, 1/s.
    pub mass_damping: Hertz,
}

impl Law {
    /// ln E, ln of the springpot's strength, its exponent, α, and the law's own coefficients.
    pub fn parameters(&self) -> Vec<Parameter> {
        let shared = [
            Parameter::logarithmic("youngs_modulus", "Pa", self.start, [5e4, 2e6]),
            Parameter::logarithmic("springpot_strength", "", 0.05, [1e-4, 1.0]),
            Parameter::linear("springpot_exponent", "", 0.25, [0.02, 0.9]),
            Parameter::linear("mass_damping", "1/s", 1.0, [0.0, 20.0]),
        ];
        let law_parameters = self.terms.iter().map(|term| {
            let name = ["c20_over_c10", "c30_over_c10"][term.which];
            Parameter::linear(name, "", term.start, term.range)
        });
        shared.into_iter().chain(law_parameters).collect()
    }

    /// The material at the `point`.
    ///
    /// # Errors
    /// A diagnostic when the spectrum is refused.
    pub fn constants(&self, point: &[f64]) -> Result<Constants> {
        let springpot = Springpot { strength: point[1].exp(), exponent: point[2], decades: DECADES };
        let relaxation = Relaxation::springpot(springpot)?;
        let mut stiffening = [0.0; 2];
        for (k, term) in self.terms.iter().enumerate() {
            stiffening[term.which] = point[SHARED + k];
        }
        let youngs_modulus = point[0].exp() / relaxation.modulus(MODULUS_TIME);
        Ok(Constants { youngs_modulus, stiffening, relaxation, mass_damping: point[3] })
    }
}

impl Constants {
    /// Of a body in motion.
    pub fn properties(&self) -> Properties {
        Properties {
            youngs_modulus: self.youngs_modulus,
            stiffening: self.stiffening,
            relaxation: self.relaxation.clone(),
            mass_damping: self.mass_damping,
            stiffness_damping: 0.0,
        }
    }

    /// Of the elastic body that has this material's shape a time after a step of pressure.
    pub(super) fn creep_elasticity(&self, time: Second) -> (Pascal, [f64; 2]) {
        creep_elasticity((self.youngs_modulus, self.stiffening), &self.relaxation, time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_law_has_its_own_name_and_starts_within_its_ranges() {
        for (i, law) in LAWS.iter().enumerate() {
            assert!(LAWS[..i].iter().all(|other| other.name != law.name));
            assert!(materials_know(law.material), "{}", law.material);
            assert!(law.terms.iter().all(|term| (term.range[0]..term.range[1]).contains(&term.start)));
        }
    }

    fn materials_know(name: &str) -> bool {
        fem::materials::by_name(name).is_some()
    }

    #[test]
    fn the_stress_of_the_stiffening_does_not_creep() {
        let law = &LAWS[1];
        let point: Vec<f64> = vec![2e5_f64.ln(), 0.05_f64.ln(), 0.3, 1.0, 0.7];
        let material = law.constants(&point).unwrap();
        // the modulus of the search is that of relaxation, which creep lags behind
        let lag = material.creep_elasticity(3.0).0 / 2e5 - 1.0;
        assert!((0.0..0.01).contains(&lag), "{lag}");
        let absolute = |time: f64| material.creep_elasticity(time).0 * material.creep_elasticity(time).1[0];
        assert!((absolute(0.1) / absolute(3.0) - 1.0).abs() < 1e-12);
        assert!(material.creep_elasticity(0.1).0 > material.creep_elasticity(3.0).0);
    }
}
