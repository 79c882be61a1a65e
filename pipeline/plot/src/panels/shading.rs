//! Shading: the brightness of a surface from its normal (Lambert's law with ambient light).

use std::collections::BTreeMap;

use si::Point3;
use si::vec3::{add, cross, dot, norm, scale, sub};

use crate::Colour;

/// Ambient light, as a fraction of the whole.
const AMBIENT: f64 = 0.42;
/// Cosine of the crease angle: neighbours whose normals differ by more are separated by a sharp edge.
const CREASE: f64 = 0.77;
/// Levels of brightness: few enough for smooth surfaces to compress well as PNG, too many for a step to be visible.
const STEPS: f64 = 64.0;

/// A key that is equal for corners at the same place, bit by bit.
type Place = [u64; 3];

fn place_key(p: Point3) -> Place {
    p.map(|v| (v + 0.0).to_bits())
}

/// Unit normals at the corners of triangles (triangles × 3): the mean over neighbours that share the corner and are
/// bent by less than the crease angle, weighted by area.
pub(crate) fn corner_normals(triangles: &[[Point3; 3]]) -> Vec<[Point3; 3]> {
    let flat: Vec<Point3> = triangles.iter().map(|[a, b, c]| cross(sub(*b, *a), sub(*c, *a))).collect();
    let mut triangles_at: BTreeMap<Place, Vec<usize>> = BTreeMap::new();
    for (index, corners) in triangles.iter().enumerate() {
        corners.iter().for_each(|p| triangles_at.entry(place_key(*p)).or_default().push(index));
    }
    let corner = |own_normal: Point3, p: Point3| {
        let bent = |n: &Point3| dot(*n, own_normal) > CREASE * norm(*n) * norm(own_normal);
        let neighbours = triangles_at.get(&place_key(p)).into_iter().flatten().map(|&i| flat[i]).filter(bent);
        let sum = neighbours.fold([0.0; 3], add);
        let length = norm(sum);
        if length > 0.0 { scale(sum, 1.0 / length) } else { [0.0; 3] }
    };
    triangles.iter().zip(&flat).map(|(corners, own_normal)| corners.map(|p| corner(*own_normal, p))).collect()
}

/// A colour under light from `light` (a unit vector towards the lamp), seen from `eye` (towards the eye); both sides of
/// a surface are lit alike (Lambert's law).
pub(crate) fn lit_colour(colour: Colour, normal: Point3, light: Point3, eye: Point3) -> Colour {
    let facing = if dot(normal, eye) < 0.0 { scale(normal, -1.0) } else { normal };
    let direct = dot(facing, light).max(0.0);
    let bright = AMBIENT + (1.0 - AMBIENT) * direct;
    let step = (bright * STEPS).round() / STEPS;
    let channel = |v: u8| (f64::from(v) * step * 1.06).round().clamp(0.0, 255.0) as u8;
    Colour(channel(colour.0), channel(colour.1), channel(colour.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_in_one_plane_share_their_normal_and_a_corner_of_a_cube_does_not() {
        let flat = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let beside = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let wall = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let normals = corner_normals(&[flat, beside, wall]);
        assert_eq!(normals[0], [[0.0, 0.0, 1.0]; 3]);
        assert_eq!(normals[2], [[1.0, 0.0, 0.0]; 3]);
    }

    #[test]
    fn a_surface_that_faces_the_light_is_brighter() {
        let eye = [0.0, 0.0, 1.0];
        let grey = Colour(150, 150, 150);
        let (facing, aside) = (lit_colour(grey, eye, eye, eye), lit_colour(grey, [1.0, 0.0, 0.0], eye, eye));
        assert!(facing.0 > aside.0 + 50);
        assert_eq!(lit_colour(grey, [0.0, 0.0, -1.0], eye, eye), facing);
    }
}
