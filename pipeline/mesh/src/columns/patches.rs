//! Patches: the parts of a surface that are height fields h = f(p, q) over the plan.
//!
//! A face is a *wall* when it runs along the sheet's normal; the others, joined across edges where their normals
//! agree in direction, are patches. Walls only bound patches; they follow from the outlines and are not meshed as surfaces.

use crate::distance::Nearest;
use crate::frame::Frame;
use crate::surface::{SharedEdge, connected_components};
use crate::{Shell, Surface, SurfaceError};
use si::vec3::norm;
use si::{Metre, Point2, Point3};

/// A face is a wall when the sine of the angle between it and the sheet's normal is below this: over a height of 10 mm
/// it deviates by 20 µm in the plan, which is the tolerance of a 100 mm body.
const WALL: f64 = 0.002;

/// A closed surface with its shells and edges.
pub(crate) struct Part<'a> {
    pub surface: &'a Surface,
    pub shells: Vec<Shell>,
    pub shell_of: Vec<u32>,
    pub shared_edges: Vec<SharedEdge>,
}

impl<'a> Part<'a> {
    pub fn new(surface: &'a Surface) -> Result<Self, SurfaceError> {
        let (shells, shell_of) = surface.shells()?;
        Ok(Self { surface, shells, shell_of, shared_edges: surface.shared_edges()? })
    }

    /// No sheet at all.
    pub(crate) fn without_surface(empty: &'a Surface) -> Self {
        Self { surface: empty, shells: Vec::new(), shell_of: Vec::new(), shared_edges: Vec::new() }
    }

    /// Sign of the normal component along the frame's normal; 0 for a wall.
    pub(crate) fn face_direction(&self, frame: Frame, face: u32) -> i8 {
        let normal = self.surface.normal(face as usize);
        let lean = normal[frame.normal] / norm(normal).max(f64::MIN_POSITIVE);
        if lean.abs() < WALL { 0 } else { lean.signum() as i8 }
    }
}

/// The axes, by decreasing projected area; the first one of a sheet is its normal.
pub(crate) fn dominant_axes(surface: &Surface) -> [Frame; 3] {
    let mut areas = [0.0; 3];
    for face in 0..surface.faces.len() {
        let normal = surface.normal(face);
        (0..3).for_each(|k| areas[k] += normal[k].abs());
    }
    let mut axes = [0, 1, 2];
    axes.sort_by(|a, b| areas[*b].total_cmp(&areas[*a]));
    axes.map(|normal| Frame { normal })
}

/// The axes in the order in which a body without a sheet is divided into columns along them: first those along which it is a prism,
/// because its outlines are then its own edges and no column ends at a grazing wall.
pub(crate) fn column_axes(surface: &Surface) -> [Frame; 3] {
    let mut frames = dominant_axes(surface);
    frames.sort_by_key(|frame| !is_prism(surface, *frame));
    frames
}

/// Whether every face is a wall along the axis or normal to it.
fn is_prism(surface: &Surface, along: Frame) -> bool {
    (0..surface.faces.len()).map(|face| surface.normal(face)).all(|normal| {
        let plan = norm(along.join(along.split(normal).0, 0.0));
        normal[along.normal].abs().min(plan) < WALL * norm(normal)
    })
}

/// A height field, part of one surface.
pub(crate) struct Patch {
    /// 0 body, 1 spine.
    pub part: usize,
    /// Shell of that surface.
    pub shell: u32,
    /// Whether the solid lies below the patch.
    pub up: bool,
    /// A point on it, for messages, m.
    pub place: Point3,
    flat: Nearest,
    heights: Vec<[Metre; 3]>,
    low: Point2,
    high: Point2,
}

impl Patch {
    /// Height at a plan point, and the point's distance from the patch in the plan, m.
    pub(crate) fn height_and_distance(&self, point: Point2) -> (Metre, Metre) {
        match self.flat.find([point[0], point[1], 0.0]) {
            Some(hit) => {
                let heights = self.heights[hit.face];
                ((0..3).map(|k| hit.shares[k] * heights[k]).sum(), hit.distance)
            }
            None => (0.0, f64::INFINITY),
        }
    }

    /// Height where the line through a plan point meets the patch, m.
    pub fn crossing_height(&self, point: Point2) -> Option<Metre> {
        let inside = (0..2).all(|k| point[k] >= self.low[k] && point[k] <= self.high[k]);
        // a tenth of a micrometre: more than rounding, less than any feature
        inside.then(|| self.height_and_distance(point)).filter(|h| h.1 < 1e-7).map(|h| h.0)
    }
}

/// The patches of one part.
pub(crate) fn find_patches(part: &Part, index: usize, frame: Frame) -> Vec<Patch> {
    let surface = part.surface;
    let direction: Vec<i8> = (0..surface.faces.len() as u32).map(|f| part.face_direction(frame, f)).collect();
    let joined = part.shared_edges.iter().map(|j| j.faces);
    let joined =
        joined.filter(|[a, b]| direction[*a as usize] != 0 && direction[*a as usize] == direction[*b as usize]);
    let (of_face, count) = connected_components(surface.faces.len(), joined);
    let mut faces: Vec<Vec<usize>> = vec![Vec::new(); count as usize];
    (0..of_face.len()).filter(|&f| direction[f] != 0).for_each(|f| faces[of_face[f] as usize].push(f));
    let patch = |faces: &Vec<usize>| {
        let split: Vec<_> = faces.iter().map(|&f| surface.corners(f).map(|c| frame.split(c))).collect();
        let plan = split.iter().flatten().map(|c| c.0);
        let bound = |least: fn(f64, f64) -> f64, from: f64| {
            plan.clone().fold([from; 2], |b, p| [least(b[0], p[0]), least(b[1], p[1])])
        };
        Patch {
            part: index,
            shell: part.shell_of[faces[0]],
            up: direction[faces[0]] > 0,
            place: surface.corners(faces[0])[0],
            low: bound(f64::min, f64::INFINITY),
            high: bound(f64::max, f64::NEG_INFINITY),
            flat: Nearest::new(split.iter().map(|c| c.map(|(p, _)| [p[0], p[1], 0.0])).collect()),
            heights: split.iter().map(|c| c.map(|(_, h)| h)).collect(),
        }
    };
    faces.iter().filter(|f| !f.is_empty()).map(patch).collect()
}

/// Edges where patches end or have a crease, as segments of the plan.
pub(crate) fn find_seams(part: &Part, frame: Frame) -> Vec<[Point2; 2]> {
    let seam = |shared: &&SharedEdge| {
        let [a, b] = shared.faces.map(|f| part.face_direction(frame, f));
        a != b || (a != 0 && is_creased(part.surface, shared.faces))
    };
    let plan = |p: u32| frame.split(part.surface.points[p as usize]).0;
    part.shared_edges.iter().filter(seam).map(|shared| shared.edge.map(plan)).collect()
}

/// Whether two faces meet under more than 30 degrees.
fn is_creased(surface: &Surface, faces: [u32; 2]) -> bool {
    let [a, b] = faces.map(|f| surface.normal(f as usize));
    let size = norm(a) * norm(b);
    // Below 30 degrees an edge is one of a tessellated curve with twelve pieces a turn or more, and a line of the plan
    // along each would cut it to strips.
    size > 0.0 && si::vec3::dot(a, b) < 0.866 * size
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::tests::{block, with_cavity};

    #[test]
    fn a_hollow_box_has_four_patches_and_their_outlines_are_seams() {
        let hollow = with_cavity(block([0.0; 3], [0.04, 0.01, 0.03]), [0.01, 0.002, 0.01], [0.02, 0.008, 0.02]);
        let part = Part::new(&hollow).unwrap();
        let [frame, ..] = dominant_axes(&hollow);
        assert_eq!(frame.normal, 1);
        let patches = find_patches(&part, 0, frame);
        assert_eq!(patches.len(), 4);
        let mut heights: Vec<_> = patches.iter().filter_map(|p| p.crossing_height([0.015, 0.015])).collect();
        heights.sort_by(f64::total_cmp);
        assert!(heights.iter().zip([0.0, 0.002, 0.008, 0.01]).all(|(a, b)| (a - b).abs() < 1e-15), "{heights:?}");
        assert_eq!(find_seams(&part, frame).len(), 16);
    }
}
