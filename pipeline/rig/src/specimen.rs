//! A specimen on the bench: its shape, and what is hidden in it.
//!
//! The shape is public (it leaves the bench as two STL files); the properties are drawn from the seed's ranges and leave
//! the bench in `truth.toml` alone.
//!
//! Stands on: `shape` (the parametric tail), the settings. Never knows: a trial.

use si::{Point2, Second};

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

/// The sheet's material.
pub const SHEET: &str = "acetal";

/// What is hidden in a specimen.
#[derive(Debug, Clone, PartialEq)]
pub struct Hidden {
    /// The silicone.
    pub body: Properties,
    /// The sheet.
    pub spine: Properties,
    /// What loses energy.
    pub damping: Damping,
    /// The right outer wall is thicker and the left one thinner by this share, no unit.
    pub asymmetry: f64,
    /// How far each mark is off its nominal place along and across, m.
    pub marks: Vec<Point2>,
}

impl Hidden {
    /// Properties drawn from the ranges of the specimen's materials, and from its own seed.
    pub fn drawn(all: &settings::Settings, set: &settings::Specimen) -> Self {
        let (body, damping) = solid(&all.material[&set.body]);
        let (spine, _) = solid(&all.material[SHEET]);
        let mut draw = Draw::new(set.seed, "casting");
        let most = all.casting.asymmetry;
        let share = draw.between([0.5, 1.0]);
        let asymmetry = if draw.unit() < 0.5 { share } else { -share } * most;
        let mut off = || all.casting.markers_off * draw.normal();
        let marks = set.markers.iter().map(|_| [off(), off()]).collect();
        Self { body, spine, damping, asymmetry, marks }
    }

    /// The tail as it was cast, where `tail` is what was drawn.
    pub fn cast(&self, tail: &Tail) -> Tail {
        let [right, left] = tail.wall;
        Tail { wall: [right * (1.0 + self.asymmetry), left * (1.0 - self.asymmetry)], ..tail.clone() }
    }
}

fn solid(set: &settings::Material) -> (Properties, Damping) {
    let mut draw = Draw::new(set.seed, "hidden");
    let properties = Properties {
        youngs_modulus: draw.between(set.youngs_modulus),
        poissons_ratio: draw.between(set.poissons_ratio),
        density: set.density,
    };
    let ratio = draw.between(set.damping_ratio);
    (properties, Damping { mass: 0.0, stiffness: stiffness_damping(ratio, set.ring_down) })
}

/// b of C = b K with damping ratio ζ at frequency f: ζ = π f b.
fn stiffness_damping(ratio: f64, frequency: f64) -> Second {
    ratio / (std::f64::consts::PI * frequency)
}
