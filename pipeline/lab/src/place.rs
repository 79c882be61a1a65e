//! Places: selections of nodes and faces for clamps, loads and masses.

use serde::{Deserialize, Serialize};
use si::{Metre, Point3};

/// `plane = { x = 0.0 }`: a plane across one axis.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Plane {
    /// Its place along x, m.
    pub x: Option<Metre>,
    /// Its place along y, m.
    pub y: Option<Metre>,
    /// Its place along z, m.
    pub z: Option<Metre>,
}

/// `box = { low = […], high = […] }`, m.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Block {
    /// Its least corner.
    pub low: Point3,
    /// Its greatest corner.
    pub high: Point3,
}

/// A set of points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// The plane across an axis (0, 1, 2) at a coordinate, m.
    Plane(usize, Metre),
    /// A box and its surface.
    Block(Block),
}

/// Tolerance of a plane or box, in sizes of the body: files often have single precision.
const NEAR: f64 = 1e-5;

impl Place {
    /// The given place; none unless there is exactly one.
    pub fn of(plane: Option<Plane>, block: Option<Block>) -> Option<Self> {
        match (plane, block) {
            (Some(plane), None) => match [plane.x, plane.y, plane.z] {
                [Some(at), None, None] => Some(Self::Plane(0, at)),
                [None, Some(at), None] => Some(Self::Plane(1, at)),
                [None, None, Some(at)] => Some(Self::Plane(2, at)),
                _ => None,
            },
            (None, Some(block)) => Some(Self::Block(block)),
            _ => None,
        }
    }

    /// Whether a point of a body of this size (m) belongs to it.
    pub fn holds(&self, at: Point3, size: Metre) -> bool {
        let tolerance = NEAR * size;
        match self {
            Self::Plane(axis, coordinate) => (at[*axis] - coordinate).abs() <= tolerance,
            Self::Block(Block { low, high }) => {
                (0..3).all(|k| at[k] >= low[k] - tolerance && at[k] <= high[k] + tolerance)
            }
        }
    }
}

impl std::fmt::Display for Place {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Plane(axis, at) => write!(out, "the plane {} = {at} m", ["x", "y", "z"][*axis]),
            Self::Block(Block { low, high }) => write!(out, "the box from {low:?} to {high:?} m"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plane_across_two_axes_is_no_plane_and_a_point_beside_it_is_not_on_it() {
        let plane = |x, y| Plane { x, y, z: None };
        assert_eq!(Place::of(Some(plane(Some(0.0), Some(1.0))), None), None);
        let wall = Place::of(Some(plane(None, Some(0.5))), None).unwrap();
        assert!(wall.holds([9.0, 0.5 + 1e-7, 3.0], 0.1) && !wall.holds([9.0, 0.5 + 1e-5, 3.0], 0.1));
    }

    #[test]
    fn a_place_is_exactly_one_plane_or_box() {
        let plane = |[x, y, z]: [Option<f64>; 3]| Some(Plane { x, y, z });
        for axis in 0..3 {
            let mut at = [None; 3];
            at[axis] = Some(0.25);
            let place = Place::of(plane(at), None);
            assert_eq!(place, Some(Place::Plane(axis, 0.25)));
            let word = format!("the plane {} = 0.25 m", ["x", "y", "z"][axis]);
            assert_eq!(place.map(|place| place.to_string()), Some(word));
        }
        let block = Block { low: [0.0; 3], high: [1.0; 3] };
        assert_eq!(Place::of(None, Some(block)), Some(Place::Block(block)));
        assert_eq!(Place::of(plane([Some(0.0), None, None]), Some(block)), None);
        assert_eq!(Place::of(plane([None; 3]), None), None);
        assert_eq!(Place::of(None, None), None);
    }

    /// Files often have single precision: a point counts as on the surface within 10⁻⁵ of the body's size.
    #[test]
    fn a_box_holds_its_surface_within_the_precision_of_files() {
        let place = Place::Block(Block { low: [0.0, 0.1, 0.2], high: [1.0, 1.1, 1.2] });
        let (size, centre) = (2.0, [0.5, 0.6, 0.7]);
        for axis in 0..3 {
            for (side, out) in [(-0.5, -1.0), (0.5, 1.0)] {
                let mut at = centre;
                at[axis] += side;
                let moved = |by: f64| (0..3).map(|k| if k == axis { at[k] + by } else { at[k] }).collect::<Vec<_>>();
                let holds = |by: f64| place.holds(moved(by).try_into().unwrap(), size);
                assert!(holds(-0.1 * out) && holds(0.9e-5 * size * out) && !holds(1.1e-5 * size * out), "{axis} {out}");
            }
        }
    }
}
