//! The input surfaces, against which every change of a surface is held.

use si::Point3;
use si::vec3::{add, dot, norm, scale, sub};

use crate::geometry::{centroid, distance, normal, triangle_samples, unit};
use crate::tree::{Nearest, Tree};

/// A triangle is sampled at most so finely: 18 points beside its corners.
const MAX_PARTS: f64 = 5.0;
/// Triangles are cut no further when there are so many.
pub(crate) const MAX_TRIANGLES: usize = 2_000_000;
/// Opposite walls are those whose normals differ by less than 50° from being parallel.
const PARALLEL: f64 = 0.64;
/// Widths are measured from so far off a node, as a share of its distance from the face's middle.
const OFFSET: f64 = 0.03;

/// A surface to which others stay near.
#[derive(Debug, Clone)]
pub(crate) struct Envelope {
    pub(crate) tree: Tree,
    normals: Vec<Point3>,
}

impl Envelope {
    /// Of triangles that are cut into parts with sides up to a length: boxes around the slivers of a long cylinder overlap, and a search of them
    /// looks at most.
    pub(crate) fn new(triangles: &[[Point3; 3]], longest: f64) -> Self {
        let (mut parts, mut normals): (Vec<[Point3; 3]>, Vec<Point3>) = (Vec::new(), Vec::new());
        for corners in triangles {
            let upwards = unit(normal(*corners));
            parts.extend(cut_pieces(*corners, longest, MAX_TRIANGLES.saturating_sub(parts.len())));
            normals.resize(parts.len(), upwards);
        }
        Self { tree: Tree::new(&parts), normals }
    }

    pub(crate) fn nearest(&self, at: Point3, reach: f64) -> Option<Nearest> {
        self.tree.nearest(at, reach)
    }

    pub(crate) fn normal(&self, triangle: u32) -> Point3 {
        self.normals[triangle as usize]
    }

    /// Whether a triangle stays within a distance of the surface, by samples.
    pub(crate) fn holds_triangle(&self, corners: [Point3; 3], reach: f64) -> bool {
        // neighbouring samples mostly lie on the same triangle: with it as a hint a search of the tree is rare
        let mut hint = None;
        triangle_samples(corners, sample_parts(corners, reach)).all(|p| {
            hint = self.tree.within(p, reach, hint);
            hint.is_some()
        })
    }

    /// Thickness of the wall below a face, and of the gap above it, near one of its corners; crossings nearer than `skip` are none.
    ///
    /// Origin and direction are the input's: a remeshed sliver's normal would look along its own surface.
    pub(crate) fn wall_and_gap(&self, corners: [Point3; 3], near: Point3, [skip, reach]: [f64; 2]) -> [f64; 2] {
        let offset = scale(sub(centroid(corners), near), OFFSET);
        let Some(foot) = self.nearest(add(near, offset), f64::INFINITY) else { return [f64::INFINITY; 2] };
        // the two faces of a sharp edge are no wall: seen from beside the edge, the other one is not farther than the edge
        let skip = skip.max(1.2 * norm(offset));
        let upwards = self.normal(foot.triangle);
        [scale(upwards, -1.0), upwards].map(|along| self.width_along(foot.point, along, [skip, reach]))
    }

    fn width_along(&self, from: Point3, along: Point3, [skip, reach]: [f64; 2]) -> f64 {
        let crossings = self.tree.ray_crossings(from, along, reach);
        let first =
            crossings.into_iter().filter(|(t, _)| *t > skip).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        match first {
            Some((t, triangle)) if dot(self.normal(triangle), along).abs() > PARALLEL => t,
            _ => f64::INFINITY,
        }
    }
}

/// Pieces of a triangle with sides up to a length; from so many pieces on they are cut no further.
pub(crate) fn cut_pieces(face: [Point3; 3], longest: f64, limit: usize) -> Vec<[Point3; 3]> {
    let (mut pieces, mut stack) = (Vec::new(), vec![face]);
    while let Some(piece) = stack.pop() {
        match cut_halves(piece, longest) {
            Some(halves) if pieces.len() < limit => stack.extend(halves),
            _ => pieces.push(piece),
        }
    }
    pieces
}

/// A triangle cut across its longest side, if that is too long.
fn cut_halves([a, b, c]: [Point3; 3], longest: f64) -> Option<[[Point3; 3]; 2]> {
    let sides = [(distance(a, b), [a, b, c]), (distance(b, c), [b, c, a]), (distance(c, a), [c, a, b])];
    let (length, [p, q, tip]) = sides.into_iter().max_by(|x, y| x.0.total_cmp(&y.0))?;
    let middle = scale(add(p, q), 0.5);
    (length > longest).then_some([[p, middle, tip], [middle, q, tip]])
}

fn sample_parts([a, b, c]: [Point3; 3], reach: f64) -> usize {
    let longest = distance(a, b).max(distance(b, c)).max(distance(c, a));
    (longest / (3.0 * reach)).ceil().clamp(1.0, MAX_PARTS) as usize
}
