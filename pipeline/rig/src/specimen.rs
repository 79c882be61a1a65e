//! A specimen of the bench: its shape and its hidden properties.
//!
//! The shape is public: it is written as two STL files. The properties are drawn from the ranges of the settings and written to
//! `truth.toml` alone.

use std::borrow::Cow;

use si::{Metre, Point2};

use lab::truth::{Properties, TrueBranch};
use tail_cad::{Tail, Unbonded};

use crate::random::RandomStream;
use crate::settings;

/// A specimen: a name in `bench.toml` and a shape.
pub struct Specimen {
    /// Its name, and its folder's.
    pub name: Cow<'static, str>,
    /// Its shape.
    pub tail: fn() -> Tail,
    /// Where it comes from a population.
    pub draw: Option<Draw>,
}

/// A specimen's place in a population ([`crate::population`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Draw {
    /// The population's seed.
    pub seed: u64,
    /// Its number in the population, from 1.
    pub number: usize,
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
    /// Relative excess thickness of the right outer wall; the left one is thinner by the same, no unit.
    pub asymmetry: f64,
    /// By how much the sheet lies off the middle, towards +y, m.
    pub sheet_offset: Metre,
    /// Where the silicone does not adhere to the sheet.
    pub unbonded: Debonding,
    /// Offset of each mark from its nominal place along and across, m.
    pub marks: Vec<Point2>,
}

/// Where the silicone of a casting does not adhere to the sheet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Debonding {
    /// The side of the sheet: 0 is −y, 1 is +y.
    pub side: u16,
    /// Its place among those possible, from 0 behind the first chamber to 1.
    pub place: f64,
    /// Along so many chambers.
    pub chambers: usize,
    /// Thickness of the film, m.
    pub film: Metre,
}

impl Debonding {
    fn draw_stretch(set: &settings::Casting, seed: u64) -> Self {
        let mut random = RandomStream::new(seed, "debonding");
        let side = u16::from(random.unit() < 0.5);
        Self { side, place: random.unit(), chambers: set.unbonded, film: set.film }
    }

    /// The stretch of a tail with so many chambers; none where it is no chamber long. Behind the first chamber and before the last.
    fn unbonded_chambers(&self, chambers: usize) -> Option<Unbonded> {
        let places = (chambers - 1).checked_sub(self.chambers).filter(|_| self.chambers > 0)?;
        let first = 1 + ((self.place * places as f64) as usize).min(places.saturating_sub(1));
        Some(Unbonded { side: self.side, chambers: [first, first + self.chambers - 1], film: self.film })
    }
}

impl HiddenProperties {
    /// Properties drawn from the ranges of the specimen's materials, and from its own seed.
    pub fn drawn(all: &settings::Settings, set: &settings::Specimen) -> Self {
        let (body, spine) = (draw_properties(&all.material[&set.body]), draw_properties(&all.material[SHEET]));
        let mut random = RandomStream::new(set.seed, "casting");
        let greatest = all.casting.asymmetry;
        let fraction = random.uniform([0.5, 1.0]);
        let asymmetry = if random.unit() < 0.5 { fraction } else { -fraction } * greatest;
        let mut offset = || all.casting.markers_off * random.normal();
        let marks = set.markers.iter().map(|_| [offset(), offset()]).collect();
        let sheet_offset = random.uniform([-1.0, 1.0]) * all.casting.sheet_offset;
        let unbonded = Debonding::draw_stretch(&all.casting, set.seed);
        Self { body, spine, asymmetry, marks, sheet_offset, unbonded }
    }

    /// The tail as it was cast from the nominal `tail`.
    pub fn cast_tail(&self, tail: &Tail) -> Tail {
        let [right, left] = tail.wall;
        Tail {
            wall: [right * (1.0 + self.asymmetry), left * (1.0 - self.asymmetry)],
            sheet_offset: self.sheet_offset,
            unbonded: self.unbonded.unbonded_chambers(tail.chambers),
            ..tail.clone()
        }
    }
}

/// Drawn properties; the range of Young's modulus holds at a time after loading, the truth has it after all relaxation.
pub(crate) fn draw_properties(set: &settings::Material) -> Properties {
    let mut random = RandomStream::new(set.seed, "hidden");
    let (modulus_at_time, poissons_ratio) = (random.uniform(set.youngs_modulus), random.uniform(set.poissons_ratio));
    let factor = random.uniform(set.branch_factor);
    let branch: Vec<TrueBranch> =
        set.branches.iter().map(|[time, strength]| TrueBranch { strength: factor * strength, time: *time }).collect();
    let relaxing_part = branch.iter().map(|b| b.strength * (-set.modulus_time / b.time).exp()).sum::<f64>();
    Properties {
        youngs_modulus: modulus_at_time / (1.0 + relaxing_part),
        poissons_ratio,
        density: set.density,
        stiffening: set.stiffening,
        branch,
    }
}
