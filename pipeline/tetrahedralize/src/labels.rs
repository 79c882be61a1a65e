//! Which part holds a tetrahedron: generalised winding numbers of its centroid [jacobson2013].

use si::Point3;

use crate::Fill;
use crate::complex::{Complex, OUTSIDE};
use crate::geometry::centroid;
use crate::tree::Tree;

/// The closed surfaces of all parts; later parts displace earlier ones.
pub(crate) struct Space {
    parts: Vec<(Tree, Fill)>,
}

impl Space {
    /// Of the surfaces that were inserted: beside the input, from which they depart a little, thin tetrahedra would be labelled at random.
    pub(crate) fn new(surfaces: Vec<(Tree, Fill)>) -> Self {
        Self { parts: surfaces }
    }

    /// The label of a place.
    pub(crate) fn label_at(&self, at: Point3) -> u16 {
        let holding = self.parts.iter().rev().find(|(tree, _)| tree.winding_number(at) > 0.5);
        match holding {
            Some((_, Fill::Region(region))) => *region,
            _ => OUTSIDE,
        }
    }
}

/// Labels all tetrahedra.
pub(crate) fn label_all(complex: &mut Complex, space: &Space) {
    let tets: Vec<u32> = complex.living_tets().collect();
    for tet in tets {
        complex.labels[tet as usize] = space.label_at(centroid(complex.corners_of(tet)));
    }
}
