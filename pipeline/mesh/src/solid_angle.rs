//! The chamber that contains a point, by the solid angle of its walls.

use std::collections::BTreeMap;

use crate::surface::solid_angle;
use crate::{QuadraticMesh, Skin, Solid};
use si::Point3;

/// The skin index of the chamber that holds `at` (m), or nothing when it lies in none.
///
/// The solid angle of a chamber's walls is 4π from inside and 0 from outside. A half model is mirrored at z = 0.
pub fn chamber_at(solid: &QuadraticMesh, at: Point3) -> Option<u16> {
    let faces = solid.skin.iter().map(|face| (face.nodes(), face.on));
    holding_chamber(&solid.nodes, faces, solid.half, at)
}

/// The same for a mesh of either order.
pub fn chamber_containing(solid: &Solid, at: Point3) -> Option<u16> {
    holding_chamber(solid.nodes(), solid.faces().into_iter(), solid.half(), at)
}

fn holding_chamber<'a>(
    nodes: &[Point3],
    faces: impl Iterator<Item = (&'a [u32], Skin)>,
    half: bool,
    point: Point3,
) -> Option<u16> {
    let mut angles = BTreeMap::new();
    for (face, on) in faces {
        let Skin::Chamber(chamber) = on else { continue };
        let halves: &[[usize; 3]] = if face.len() == 8 { &[[0, 1, 2], [0, 2, 3]] } else { &[[0, 1, 2]] };
        for corners in halves.iter().map(|part| part.map(|i| nodes[face[i] as usize])) {
            let [a, b, c] = corners;
            let mirrored = [a, c, b].map(|[x, y, z]| [x, y, -z]);
            let subtended = solid_angle(corners, point) + if half { solid_angle(mirrored, point) } else { 0.0 };
            *angles.entry(chamber).or_insert(0.0) += subtended;
        }
    }
    angles
        .into_iter()
        // Half of 4π decides: chords of curved walls, and a point near a wall, change the sum by less.
        .find(|(_, angle): &(u16, f64)| angle.abs() > 2.0 * std::f64::consts::PI)
        .map(|(chamber, _)| chamber)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{QuadraticElements, QuadraticFace};

    fn octahedron() -> QuadraticMesh {
        let nodes = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]];
        let face = |a: u32, b: u32| QuadraticFace::triangle([a, b, 4, 0, 0, 0], Skin::Chamber(7));
        let skin = vec![face(0, 1), face(1, 2), face(2, 3), face(3, 0)];
        QuadraticMesh {
            nodes,
            elements: QuadraticElements::Tetrahedra(Vec::new()),
            regions: Vec::new(),
            skin,
            half: true,
        }
    }

    #[test]
    fn a_point_inside_a_half_chamber_and_its_mirror_image_are_found() {
        assert_eq!(chamber_at(&octahedron(), [0.1, 0.2, 0.3]), Some(7));
        assert_eq!(chamber_at(&octahedron(), [0.1, 0.2, -0.3]), Some(7));
    }

    #[test]
    fn a_point_outside_is_in_no_chamber() {
        assert_eq!(chamber_at(&octahedron(), [0.9, 0.9, 0.1]), None);
    }
}
