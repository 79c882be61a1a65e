//! A specimen on the bench: its shape, and what is hidden in it.
//!
//! The shape is public (it leaves the bench as two STL files); the properties are drawn from the seed's ranges and leave
//! the bench in `truth.toml` alone.
//!
//! Stands on: `shape` (the parametric tail), the settings. Never knows: a trial.

use si::Second;

use lab::truth::{Damping, Properties};
use shape::tail::Tail;

use crate::draw::Draw;
use crate::settings;

/// A member of the bench's family: a name in `bench.toml` and a shape.
pub struct Specimen {
    /// Its name, and its folder's.
    pub name: &'static str,
    /// Its shape.
    pub tail: fn() -> Tail,
}

/// What is hidden in a specimen.
#[derive(Debug, Clone, PartialEq)]
pub struct Hidden {
    /// The silicone.
    pub body: Properties,
    /// The sheet.
    pub spine: Properties,
    /// What loses energy.
    pub damping: Damping,
}

impl Hidden {
    /// Properties drawn from the specimen's ranges.
    pub fn drawn(set: &settings::Specimen) -> Self {
        let mut draw = Draw::new(set.seed, "hidden");
        let mut solid = |ranges: &settings::Ranges| Properties {
            youngs_modulus: draw.between(ranges.youngs_modulus),
            poissons_ratio: draw.between(ranges.poissons_ratio),
            density: ranges.density,
        };
        let (body, spine) = (solid(&set.body), solid(&set.spine));
        let ratio = draw.between(set.damping_ratio);
        Self { body, spine, damping: Damping { mass: 0.0, stiffness: stiffness_damping(ratio, set.ring_down) } }
    }
}

/// b of C = b K with damping ratio ζ at frequency f: ζ = π f b.
fn stiffness_damping(ratio: f64, frequency: f64) -> Second {
    ratio / (std::f64::consts::PI * frequency)
}
