//! Comparisons of the silicone: loss factor, rise of the storage modulus, creep, softening in the first cycles.
//!
//! Published for like silicones: loss factor and storage modulus of Ecoflex 00-30 from 0.1 to 10 Hz and the loss factor of a bar of Dragon
//! Skin 10 at 4 and 8 Hz.

use fem::{Branch, Relaxation};
use si::{Hertz, Second};

use super::{Comparison, range_of};
use crate::settings::{Material, Settings};
use crate::specimen::draw_properties;

/// Frequencies at which the loss factor is compared, Hz.
const FREQUENCIES: [Hertz; 5] = [1.0, 2.0, 4.0, 8.0, 10.0];
const LOSS_FACTOR: [f64; 2] = [0.06, 0.13];
/// Of the storage modulus at 10 Hz over the modulus a second after loading, %.
const RISE: [f64; 2] = [10.0, 20.0];

pub(super) fn silicone_comparisons(set: &Settings) -> Vec<Comparison> {
    let silicones = || set.material.values().filter(|material| !material.branches.is_empty()).map(relaxation_spectrum);
    let loss = |s: &Relaxation, f: Hertz| {
        let [storage, loss] = s.complex_modulus(std::f64::consts::TAU * f);
        loss / storage
    };
    let rise = |s: Relaxation| {
        let [storage, _] = s.complex_modulus(std::f64::consts::TAU * 10.0);
        let second: Second = 1.0;
        100.0 * (storage / s.modulus(second) - 1.0)
    };
    let losses = silicones().flat_map(|s| FREQUENCIES.map(|f| loss(&s, f)));
    vec![
        Comparison::new("silicone: loss factor from 1 to 10 Hz", LOSS_FACTOR, range_of(losses)),
        Comparison::new(
            "silicone: storage modulus at 10 Hz above the modulus after 1 s (%)",
            RISE,
            range_of(silicones().map(rise)),
        ),
    ]
}

fn relaxation_spectrum(material: &Material) -> Relaxation {
    let branches: Vec<Branch> =
        draw_properties(material).branch.iter().map(|b| Branch { strength: b.strength, time: b.time }).collect();
    // refused spectra are named when the body is made
    Relaxation::maxwell(&branches).unwrap_or_default()
}
