//! A specimen of the bench: its shape and its hidden properties.
//!
//! The shape is public: it is written as two STL files. The properties are drawn from the ranges of the settings and written to
//! `truth.toml` alone.

use si::{Point2, Second};

use lab::truth::{Damping, Properties};
use tail_cad::Tail;

use crate::random::RandomStream;
use crate::settings;

/// A specimen: a name in `bench.toml` and a shape.
pub struct Specimen {
    /// Its name, and its folder's.
    pub name: &'static str,
    /// Its shape.
    pub tail: fn() -> Tail,
}

/// The sheet's material.
pub const SHEET: &str = "acetal";

/// The hidden properties of a specimen.
#[derive(Debug, Clone, PartialEq)]
pub struct HiddenProperties {
    /// The silicone.
    pub body: Properties,
    /// The sheet.
    pub spine: Properties,
    /// Rayleigh damping.
    pub damping: Damping,
    /// Relative excess thickness of the right outer wall; the left one is thinner by the same, no unit.
    pub asymmetry: f64,
    /// Offset of each mark from its nominal place along and across, m.
    pub marks: Vec<Point2>,
}

impl HiddenProperties {
    /// Properties drawn from the ranges of the specimen's materials, and from its own seed.
    pub fn drawn(all: &settings::Settings, set: &settings::Specimen) -> Self {
        let (body, damping) = solid(&all.material[&set.body]);
        let (spine, _) = solid(&all.material[SHEET]);
        let mut random = RandomStream::new(set.seed, "casting");
        let most = all.casting.asymmetry;
        let fraction = random.uniform([0.5, 1.0]);
        let asymmetry = if random.unit() < 0.5 { fraction } else { -fraction } * most;
        let mut offset = || all.casting.markers_off * random.normal();
        let marks = set.markers.iter().map(|_| [offset(), offset()]).collect();
        Self { body, spine, damping, asymmetry, marks }
    }

    /// The tail as it was cast from the nominal `tail`.
    pub fn cast(&self, tail: &Tail) -> Tail {
        let [right, left] = tail.wall;
        Tail { wall: [right * (1.0 + self.asymmetry), left * (1.0 - self.asymmetry)], ..tail.clone() }
    }
}

fn solid(set: &settings::Material) -> (Properties, Damping) {
    let mut random = RandomStream::new(set.seed, "hidden");
    let properties = Properties {
        youngs_modulus: random.uniform(set.youngs_modulus),
        poissons_ratio: random.uniform(set.poissons_ratio),
        density: set.density,
    };
    let ratio = random.uniform(set.damping_ratio);
    (properties, Damping { mass: 0.0, stiffness: stiffness_damping(ratio, set.ring_down) })
}

/// b of C = b K with damping ratio ζ at frequency f: ζ = π f b.
fn stiffness_damping(ratio: f64, frequency: f64) -> Second {
    ratio / (std::f64::consts::PI * frequency)
}
