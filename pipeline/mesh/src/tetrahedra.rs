//! Linear tetrahedra with regions, and a skin whose faces are classified.

use si::vec3::{cross, dot, sub};
use si::{CubicMetre, Point3};

/// Region of the soft body.
pub const BODY: u16 = 0;
/// Region of the stiff sheet in the body's mid-plane.
pub const SPINE: u16 = 1;

/// What lies on the other side of a face of the skin.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Skin {
    /// The surroundings.
    Outer,
    /// A closed cavity, by its index in [`crate::Report::chambers`].
    Chamber(u16),
    /// The other half of a body of which only z ≥ 0 is meshed.
    Symmetry,
}

/// Codes of a skin in a table: [`Skin::Outer`], [`Skin::Symmetry`], then the chambers.
const OUTER: u32 = 0;
const SYMMETRY: u32 = 1;
const FIRST_CHAMBER: u32 = 2;

impl Skin {
    /// A whole number for a table.
    pub fn code(self) -> u32 {
        match self {
            Self::Outer => OUTER,
            Self::Symmetry => SYMMETRY,
            Self::Chamber(chamber) => FIRST_CHAMBER + u32::from(chamber),
        }
    }

    /// The inverse of [`Skin::code`]; none of a number that is no code.
    pub fn from_code(code: u32) -> Option<Self> {
        match code {
            OUTER => Some(Self::Outer),
            SYMMETRY => Some(Self::Symmetry),
            chamber => u16::try_from(chamber - FIRST_CHAMBER).ok().map(Self::Chamber),
        }
    }
}

/// A triangle of the skin; its normal (right hand, in the order of `nodes`) points out of the solid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SkinFace {
    /// Three nodes.
    pub nodes: [u32; 3],
    /// What is on the other side.
    pub on: Skin,
}

/// Linear tetrahedra with regions and a skin.
///
/// | field     | shape        | meaning                                                       |
/// |-----------|--------------|---------------------------------------------------------------|
/// | `nodes`   | nodes × 3    | metres                                                        |
/// | `tets`    | tets × 4     | node indices, positive volume: (b−a) × (c−a) · (d−a) > 0      |
/// | `regions` | tets         | [`BODY`] or [`SPINE`]                                         |
/// | `skin`    | faces        | every face that has a solid on one side only                  |
/// | `half`    | one          | only z ≥ 0 is there, cut at z = 0                             |
#[derive(Debug, Clone, PartialEq)]
pub struct TetMesh {
    /// Node positions, m.
    pub nodes: Vec<Point3>,
    /// Four corners an element.
    pub tets: Vec<[u32; 4]>,
    /// Region of each element.
    pub regions: Vec<u16>,
    /// The closed boundary of the solid.
    pub skin: Vec<SkinFace>,
    /// Whether only z ≥ 0 is meshed.
    pub half: bool,
}

impl TetMesh {
    /// Corner positions of element `tet`, m.
    pub fn corners(&self, tet: usize) -> [Point3; 4] {
        self.tets[tet].map(|n| self.nodes[n as usize])
    }

    /// Volume of element `tet`, m³; positive in every mesh this crate makes.
    pub fn volume(&self, tet: usize) -> CubicMetre {
        let [a, b, c, d] = self.corners(tet);
        dot(cross(sub(b, a), sub(c, a)), sub(d, a)) / 6.0
    }

    /// Volume of all elements of one region, m³; of the half when only the half is meshed.
    pub fn region_volume(&self, region: u16) -> CubicMetre {
        (0..self.tets.len()).filter(|&t| self.regions[t] == region).map(|t| self.volume(t)).sum()
    }

    /// Number of cavities that the skin names.
    pub fn chambers(&self) -> usize {
        let index = |face: &SkinFace| match face.on {
            Skin::Chamber(k) => k as usize + 1,
            _ => 0,
        };
        self.skin.iter().map(index).max().unwrap_or(0)
    }

    /// Volume of one cavity from its skin, m³; of the half when only the half is meshed.
    ///
    /// V = −⅓ ∮ x · n dA over the cavity's faces; faces on z = 0 that close a half cavity would add nothing.
    pub fn chamber_volume(&self, chamber: u16) -> CubicMetre {
        let is_of_chamber = |face: &&SkinFace| face.on == Skin::Chamber(chamber);
        -self.skin.iter().filter(is_of_chamber).map(|face| self.cone_volume(face)).sum::<f64>()
    }
}

/// The four faces of a tetrahedron, each with its normal outwards.
pub const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_code_is_that_of_one_skin_and_a_number_beyond_all_chambers_is_none() {
        for skin in [Skin::Outer, Skin::Symmetry, Skin::Chamber(0), Skin::Chamber(u16::MAX)] {
            assert_eq!(Skin::from_code(skin.code()), Some(skin));
        }
        assert_eq!(Skin::from_code(Skin::Chamber(u16::MAX).code() + 1), None);
        assert_eq!(Skin::from_code(u32::MAX), None);
    }
}
