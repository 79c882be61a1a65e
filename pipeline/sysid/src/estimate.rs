//! Estimate: a quantity of a specimen as the pipeline states it, beside the hidden truth of the virtual bench.

use serde::{Deserialize, Serialize};
use si::{Hertz, MILLIMETRE};

/// What is estimated. All are positive, and their intervals are those of the logarithm.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Young's modulus of the body at the stated time after loading, Pa.
    BodyModulus,
    /// Young's modulus of the spine, Pa.
    SpineModulus,
    /// Storage modulus over the modulus at the stated time, no unit.
    StorageRatio(Hertz),
    /// Loss factor, no unit.
    LossFactor(Hertz),
    /// Added mass over that of elongated-body theory, no unit.
    AddedMass,
    /// Normal drag coefficient, no unit.
    NormalDrag,
    /// Root mean square of the tip's lateral displacement in a condition that identification has not seen, m.
    TipAmplitude(String),
}

/// Kinds of quantity over which coverage is stated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QuantityKind {
    /// Both moduli.
    Moduli,
    /// Storage modulus and loss factor.
    Relaxation,
    /// Added mass.
    AddedMass,
    /// Normal drag.
    Drag,
    /// Predicted motion of the tip.
    TipMotion,
}

impl QuantityKind {
    /// Every kind with its name in metrics and its title, in the order of the pipeline.
    pub const ALL: [(QuantityKind, &'static str, &'static str); 5] = [
        (QuantityKind::Moduli, "moduli", "moduli"),
        (QuantityKind::Relaxation, "relaxation", "relaxation"),
        (QuantityKind::AddedMass, "added_mass", "added mass"),
        (QuantityKind::Drag, "drag", "drag"),
        (QuantityKind::TipMotion, "tip_motion", "predicted tip motion"),
    ];
}

impl Quantity {
    /// Its kind.
    pub fn kind(&self) -> QuantityKind {
        match self {
            Quantity::BodyModulus | Quantity::SpineModulus => QuantityKind::Moduli,
            Quantity::StorageRatio(_) | Quantity::LossFactor(_) => QuantityKind::Relaxation,
            Quantity::AddedMass => QuantityKind::AddedMass,
            Quantity::NormalDrag => QuantityKind::Drag,
            Quantity::TipAmplitude(_) => QuantityKind::TipMotion,
        }
    }

    /// Its name in metrics.
    pub fn id(&self) -> String {
        match self {
            Quantity::BodyModulus => "body_e".into(),
            Quantity::SpineModulus => "spine_e".into(),
            Quantity::StorageRatio(frequency) => format!("storage_ratio_{frequency}hz"),
            Quantity::LossFactor(frequency) => format!("loss_factor_{frequency}hz"),
            Quantity::AddedMass => "added".into(),
            Quantity::NormalDrag => "drag".into(),
            Quantity::TipAmplitude(condition) => format!("tip_{condition}"),
        }
    }

    /// Its title with the unit of a table's cells, and the number of those units in the SI unit.
    pub fn title(&self) -> (String, f64) {
        match self {
            Quantity::BodyModulus => ("E of the body at its time (MPa)".into(), 1e-6),
            Quantity::SpineModulus => ("E of the spine (GPa)".into(), 1e-9),
            Quantity::StorageRatio(frequency) => (format!("storage modulus over E at {frequency} Hz"), 1.0),
            Quantity::LossFactor(frequency) => (format!("loss factor at {frequency} Hz"), 1.0),
            Quantity::AddedMass => ("added mass ratio".into(), 1.0),
            Quantity::NormalDrag => ("normal drag coefficient".into(), 1.0),
            Quantity::TipAmplitude(condition) => {
                (format!("predicted tip amplitude, {} (mm)", condition.replace('_', " ")), 1.0 / MILLIMETRE)
            }
        }
    }
}

/// An estimate beside the truth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Of what.
    pub quantity: Quantity,
    /// Estimated, SI.
    pub found: f64,
    /// True, SI.
    pub hidden: f64,
    /// Standard deviation of the logarithm of the estimate.
    pub sigma: f64,
}

impl Estimate {
    /// Estimated over true, less one.
    pub fn relative_error(&self) -> f64 {
        self.found / self.hidden - 1.0
    }

    /// Error of the logarithm over its standard deviation.
    pub fn standardised_error(&self) -> f64 {
        (self.found / self.hidden).ln() / self.sigma
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_estimate_a_tenth_too_high_is_two_deviations_of_a_twentieth_off() {
        let drag = Estimate { quantity: Quantity::NormalDrag, found: 16.5, hidden: 15.0, sigma: 0.05 };
        assert!((drag.relative_error() - 0.1).abs() < 1e-12);
        assert!((drag.standardised_error() - 1.1_f64.ln() / 0.05).abs() < 1e-12);
    }

    #[test]
    fn every_quantity_is_of_a_listed_kind_and_survives_json() {
        let all = [Quantity::BodyModulus, Quantity::LossFactor(8.0), Quantity::TipAmplitude("a_2hz".into())];
        for quantity in all {
            assert!(QuantityKind::ALL.iter().any(|(kind, ..)| *kind == quantity.kind()));
            let text = serde_json::to_string(&quantity).unwrap();
            assert_eq!(serde_json::from_str::<Quantity>(&text).unwrap(), quantity);
        }
    }
}
