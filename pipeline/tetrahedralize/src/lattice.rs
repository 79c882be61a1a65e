//! Points within the solid, spaced by the target length.

use si::Point3;
use si::vec3::{add, scale};

use crate::geometry::distance;
use crate::tree::Tree;

/// Points nearer to the surface than this share of the target length would make flat elements.
const CLEAR: f64 = 0.55;
/// Sides of cells over the target length.
const CELL: f64 = 1.15;

/// Target lengths in space, from those of a surface.
pub(crate) struct SizeField<'a> {
    pub(crate) tree: &'a Tree,
    /// Target length by triangle.
    pub(crate) size: &'a [f64],
    pub(crate) gradation: f64,
    pub(crate) edge: f64,
}

impl SizeField<'_> {
    /// Target length, and distance from the surface.
    pub(crate) fn length_and_distance(&self, at: Point3) -> [f64; 2] {
        match self.tree.nearest(at, f64::INFINITY) {
            Some(near) => {
                [self.edge.min(self.size[near.triangle as usize] + self.gradation * near.distance), near.distance]
            }
            None => [self.edge, f64::INFINITY],
        }
    }
}

/// Centres of the cells of a graded octree that lie inside, away from the surface.
pub(crate) fn graded_lattice(field: &SizeField, points: &[Point3], inside: &dyn Fn(Point3) -> bool) -> Vec<Point3> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for k in 0..3 {
        low[k] = points.iter().fold(low[k], |l, p| l.min(p[k]));
        high[k] = points.iter().fold(high[k], |h, p| h.max(p[k]));
    }
    let middle = scale(add(low, high), 0.5);
    let side = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
    let mut centres = Vec::new();
    let mut stack = vec![(middle, side)];
    while let Some((centre, side)) = stack.pop() {
        let [size, gap] = field.length_and_distance(centre);
        // no cell that lies outside as a whole is divided
        let far = gap > 0.9 * side && !inside(centre);
        if far {
            continue;
        }
        if side > CELL * size {
            let quarter = side / 4.0;
            let child = |i: usize| add(centre, [0, 1, 2].map(|k| if i >> k & 1 == 1 { quarter } else { -quarter }));
            stack.extend((0..8).map(|i| (child(i), side / 2.0)));
        } else if gap > CLEAR * size && inside(centre) {
            centres.push(shifted_point(centre, 0.1 * side));
        }
    }
    centres
}

/// A point moved a little, by its own coordinates: a cubic lattice has flat tetrahedra between four points of a square.
fn shifted_point(at: Point3, by: f64) -> Point3 {
    let bits = at.map(f64::to_bits);
    let mixed =
        bits.iter().fold(0x9E37_79B9_7F4A_7C15u64, |m, b| (m ^ b).wrapping_mul(0xBF58_476D_1CE4_E5B9).rotate_left(27));
    let share = |k: u32| (mixed.rotate_left(20 * k) & 0xF_FFFF) as f64 / f64::from(0xF_FFFF) * 2.0 - 1.0;
    let jittered = add(at, [by * share(0), by * share(1), by * share(2)]);
    debug_assert!(distance(jittered, at) <= 2.0 * by);
    jittered
}
