//! `[clamp]`: the clamped part of the specimen.

use serde::{Deserialize, Serialize};
use si::{Metre, Point3};

use crate::place::{Block, Place, Plane};

/// The clamped part: exactly one of its keys is given.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Clamp {
    /// Everything at and below this x, m, CAD frame.
    #[serde(default)]
    pub below_x: Option<Metre>,
    /// A plane across one axis.
    #[serde(default)]
    pub plane: Option<Plane>,
    /// A box.
    #[serde(default, rename = "box")]
    pub block: Option<Block>,
    /// A surface that the mesh file names or numbers.
    #[serde(default)]
    pub surface: Option<String>,
}

impl Clamp {
    /// Everything at and below an x (m).
    pub fn below(x: Metre) -> Self {
        Self { below_x: Some(x), ..Self::default() }
    }

    /// Whether exactly one key is given, and a plane across one axis alone.
    pub(super) fn is_one(&self) -> bool {
        let given = [self.below_x.is_some(), self.plane.is_some(), self.block.is_some(), self.surface.is_some()];
        let across_one = self.plane.is_none() || Place::of(self.plane, None).is_some();
        given.into_iter().filter(|given| *given).count() == 1 && across_one
    }

    /// Whether a point of a body of this size (m) is held; of a named surface the mesh knows the nodes.
    pub fn holds(&self, at: Point3, size: Metre) -> bool {
        match (self.below_x, Place::of(self.plane, self.block)) {
            (Some(x), _) => at[0] <= x,
            (None, Some(place)) => place.holds(at, size),
            (None, None) => false,
        }
    }

    /// The largest x that it holds, m: there the free part begins. Negative infinity of a plane along x, and of a named surface.
    pub fn end(&self) -> Metre {
        match (self.below_x, Place::of(self.plane, self.block)) {
            (Some(x), _) => x,
            (None, Some(Place::Plane(0, x))) => x,
            (None, Some(Place::Block(block))) => block.high[0],
            _ => f64::NEG_INFINITY,
        }
    }
}

impl std::fmt::Display for Clamp {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.below_x, Place::of(self.plane, self.block)) {
            (Some(x), _) => write!(out, "clamp.below_x = {x} m"),
            (None, Some(place)) => write!(out, "clamp, {place},"),
            (None, None) => write!(out, "clamp.surface = `{}`", self.surface.as_deref().unwrap_or_default()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clamp_is_one_place() {
        let block = Block { low: [0.0; 3], high: [0.01, 0.02, 0.02] };
        let plane = |y| Plane { x: Some(0.0), y, z: None };
        let of = |below_x, plane, block| Clamp { below_x, plane, block, surface: None };
        let named = Clamp { surface: Some("holder".into()), ..Clamp::default() };
        for one in [Clamp::below(0.0), of(None, Some(plane(None)), None), of(None, None, Some(block)), named.clone()] {
            assert!(one.is_one(), "{one:?}");
        }
        let more = of(Some(0.0), Some(plane(None)), None);
        let twice = Clamp { below_x: Some(0.0), ..named };
        for other in [Clamp::default(), more, twice, of(None, Some(plane(Some(0.0))), None)] {
            assert!(!other.is_one(), "{other:?}");
        }
        assert_eq!(of(None, None, Some(block)).end(), 0.01);
    }

    #[test]
    fn the_free_part_begins_where_a_clamp_across_x_ends() {
        let block = Block { low: [0.0; 3], high: [0.01, 0.02, 0.03] };
        let plane = |x, y| Clamp { plane: Some(Plane { x, y, z: None }), ..Clamp::default() };
        assert_eq!(plane(Some(0.004), None).end(), 0.004);
        assert_eq!(plane(None, Some(0.004)).end(), f64::NEG_INFINITY, "it runs along x");
        assert_eq!(Clamp::below(0.002).end(), 0.002);
        assert_eq!(Clamp { block: Some(block), ..Clamp::default() }.end(), 0.01);
        assert_eq!(Clamp { surface: Some("holder".into()), ..Clamp::default() }.end(), f64::NEG_INFINITY);
    }
}
