//! Surfaces: welded triangles, the check that they are closed, and their connected shells.
//!
//! A shell with positive volume bounds a solid from outside, one with negative volume is a cavity: a chamber.

use si::vec3::{cross, dot, norm, sub};
use si::{CubicMetre, Metre, Point3};

/// Triangles that share their corners; normals (right hand) point out of the solid.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Surface {
    /// Corner positions, m.
    pub points: Vec<Point3>,
    /// Three corners a face.
    pub faces: Vec<[u32; 3]>,
}

/// A connected part of a closed surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Shell {
    /// Enclosed volume, m³; negative for a cavity.
    pub volume: CubicMetre,
    /// Centroid of the enclosed space, m.
    pub centroid: Point3,
}

/// An edge of a closed surface with the two faces that it joins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SharedEdge {
    /// The faces.
    pub faces: [u32; 2],
    /// The edge's corners.
    pub edge: [u32; 2],
}

/// A surface that does not bound a solid.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SurfaceError {
    /// No faces.
    #[error(
        "the surface has no faces\n  why: a solid needs at least 4\n  do:  export the part again, as a solid and not as a sketch"
    )]
    Empty,
    /// A face with a corner that does not exist.
    #[error(
        "face {face} refers to point {point}\n  why: the surface has {points} points, counted from 0\n  do:  check whether the numbers were counted from 1"
    )]
    NoSuchPoint {
        /// Which face, from 0.
        face: usize,
        /// The point's number.
        point: u32,
        /// Number of points.
        points: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("point {point} lies at ({:e}, {:e}, {:e}) m\n  why: every coordinate must be a finite number\n  do:  check the surface's file at this point", .at[0], .at[1], .at[2])]
    PointNotFinite {
        /// Which point, from 0.
        point: usize,
        /// Where it lies, m.
        at: Point3,
    },
    /// An edge that does not join exactly two faces of opposite direction.
    #[error(
        "face {face} has {} edge from {} to {}, one of {count} such edges\n  why: the edge joins {faces} faces; in a closed surface every edge joins 2, in opposite directions\n  do:  {}", edge_kind(*.faces), place_text(.from), place_text(.to), repair_advice(*.faces)
    )]
    Open {
        /// Number of the first face with such an edge, in the file's order, from 0.
        face: usize,
        /// Start of the edge, m.
        from: Point3,
        /// End of the edge, m.
        to: Point3,
        /// Faces that the edge joins.
        faces: usize,
        /// Number of such edges in the surface.
        count: usize,
    },
    /// A closed part within another, both with normals outwards.
    #[error(
        "the closed part at {} lies within another, and the normals of both point outwards\n  why: the normals of a cavity point into it; two solids in one place are none\n  do:  turn the normals of the cavity, or take the inner part out, and export again", place_text(.at)
    )]
    Nested {
        /// A corner of it, m.
        at: Point3,
    },
    /// Normals point inwards.
    #[error(
        "the surface is inside out: its volume is {volume_mm3:.1} mm³\n  why: normals must point out of the solid, which makes the volume positive\n  do:  flip the normals and export again"
    )]
    InvertedSurface {
        /// Signed volume, mm³.
        volume_mm3: f64,
    },
}

fn edge_kind(faces: usize) -> &'static str {
    match faces {
        1 => "an open",
        2 => "a turned",
        _ => "a crowded",
    }
}

/// What to do about an edge that joins so many faces.
fn repair_advice(faces: usize) -> &'static str {
    match faces {
        1 => "close the hole in the CAD program and export again",
        2 => "turn the normals of all faces outwards in the CAD program and export again",
        _ => "join the parts that touch there, or part them, and take out faces that lie twice; nothing is open",
    }
}

/// A place in millimetres, for messages.
pub(crate) fn place_text(point: &Point3) -> String {
    format!("({:.2}, {:.2}, {:.2}) mm", point[0] * 1e3, point[1] * 1e3, point[2] * 1e3)
}

impl Surface {
    /// Whether every face has corners that exist, and every point lies somewhere. The other methods panic at a corner that does not exist.
    ///
    /// # Errors
    /// [`SurfaceError::NoSuchPoint`] or [`SurfaceError::PointNotFinite`].
    pub fn check(&self) -> Result<(), SurfaceError> {
        let points = self.points.len();
        for (face, corners) in self.faces.iter().enumerate() {
            if let Some(&point) = corners.iter().find(|point| **point as usize >= points) {
                return Err(SurfaceError::NoSuchPoint { face, point, points });
            }
        }
        match self.points.iter().position(|at| at.iter().any(|x| !x.is_finite())) {
            Some(point) => Err(SurfaceError::PointNotFinite { point, at: self.points[point] }),
            None => Ok(()),
        }
    }

    /// The three corners of a face, m.
    pub fn corners(&self, face: usize) -> [Point3; 3] {
        self.faces[face].map(|p| self.points[p as usize])
    }

    /// Normal times twice the area of a face, m².
    pub fn normal(&self, face: usize) -> Point3 {
        let [a, b, c] = self.corners(face);
        cross(sub(b, a), sub(c, a))
    }

    /// Area of all faces, m².
    pub fn area(&self) -> f64 {
        (0..self.faces.len()).map(|f| norm(self.normal(f)) / 2.0).sum()
    }

    /// Signed volume of the enclosed space, m³ (cavities count negative).
    pub fn volume(&self) -> CubicMetre {
        (0..self.faces.len()).map(|f| self.cone_volume(f)).sum()
    }

    /// Lowest and highest corner of the bounding box, m.
    pub fn bounds(&self) -> (Point3, Point3) {
        let mut low = [f64::INFINITY; 3];
        let mut high = [f64::NEG_INFINITY; 3];
        for p in &self.points {
            for k in 0..3 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        (low, high)
    }

    /// Longest side of the bounding box, m.
    pub fn length(&self) -> Metre {
        let (low, high) = self.bounds();
        (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max)
    }

    fn cone_volume(&self, face: usize) -> f64 {
        let [a, b, c] = self.corners(face);
        dot(a, cross(b, c)) / 6.0
    }

    /// Every edge with its face: (low corner, high corner, face, runs upwards), sorted.
    fn directed_edges(&self) -> Vec<(u32, u32, u32, bool)> {
        let edges_of_face = |f: usize| {
            let [a, b, c] = self.faces[f];
            [(a, b), (b, c), (c, a)].map(|(s, e)| (s.min(e), s.max(e), f as u32, s < e))
        };
        let mut edges: Vec<_> = (0..self.faces.len()).flat_map(edges_of_face).collect();
        edges.sort_unstable();
        edges
    }

    /// The ends of edges whose faces' normals have an angle of this cosine or a lower one, or that do not join two faces.
    pub(crate) fn creases(&self, cosine: f64) -> Vec<[Point3; 2]> {
        let edges = self.directed_edges();
        let is_crease = |[a, b]: [u32; 2]| {
            let (p, q) = (self.normal(a as usize), self.normal(b as usize));
            dot(p, q) <= cosine * norm(p) * norm(q)
        };
        let groups = edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
        let creases = groups.filter(|g| g.len() != 2 || is_crease([g[0].2, g[1].2]));
        creases.map(|g| [g[0].0, g[0].1].map(|p| self.points[p as usize])).collect()
    }

    /// The edges of a closed surface.
    ///
    /// # Errors
    /// [`SurfaceError::Open`] with the first open edge and the number of them.
    pub(crate) fn shared_edges(&self) -> Result<Vec<SharedEdge>, SurfaceError> {
        let edges = self.directed_edges();
        let groups: Vec<_> = edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).collect();
        let open = |g: &&&[(u32, u32, u32, bool)]| g.len() != 2 || g[0].3 == g[1].3;
        let bad: Vec<_> = groups.iter().filter(open).collect();
        if let Some(first) = bad.iter().min_by_key(|g| g[0].2) {
            let point_of = |p: u32| self.points[p as usize];
            let (from, to) = (point_of(first[0].0), point_of(first[0].1));
            return Err(SurfaceError::Open {
                face: first[0].2 as usize,
                from,
                to,
                faces: first.len(),
                count: bad.len(),
            });
        }
        Ok(groups.iter().map(|g| SharedEdge { faces: [g[0].2, g[1].2], edge: [g[0].0, g[0].1] }).collect())
    }

    /// The connected parts of a closed surface, and for each face the part that it belongs to.
    ///
    /// # Errors
    /// [`SurfaceError`] when the surface is empty, open, or has no part of positive volume.
    pub fn shells(&self) -> Result<(Vec<Shell>, Vec<u32>), SurfaceError> {
        if self.faces.is_empty() {
            return Err(SurfaceError::Empty);
        }
        self.check()?;
        let shared_edges = self.shared_edges()?;
        let (of_face, count) = connected_components(self.faces.len(), shared_edges.iter().map(|j| j.faces));
        let shells: Vec<_> = (0..count).map(|s| self.shell_of(&of_face, s)).collect();
        if shells.iter().all(|s| s.volume <= 0.0) {
            return Err(SurfaceError::InvertedSurface { volume_mm3: self.volume() * 1e9 });
        }
        self.check_nested(&shells, &of_face)?;
        Ok((shells, of_face))
    }

    /// Of a part within a part one is a cavity, whose normals point into it.
    fn check_nested(&self, shells: &[Shell], of_face: &[u32]) -> Result<(), SurfaceError> {
        let faces = |shell: usize| (0..self.faces.len()).filter(move |f| of_face[*f] as usize == shell);
        let parts = || (0..shells.len()).filter(|shell| shells[*shell].volume > 0.0);
        for inner in parts() {
            let Some(at) = faces(inner).next().map(|face| self.corners(face)[0]) else { continue };
            let holds = |outer: usize| {
                let angle: f64 = faces(outer).map(|face| solid_angle(self.corners(face), at)).sum();
                shells[outer].volume > shells[inner].volume && angle.abs() > 2.0 * std::f64::consts::PI
            };
            if parts().any(|outer| outer != inner && holds(outer)) {
                return Err(SurfaceError::Nested { at });
            }
        }
        Ok(())
    }

    fn shell_of(&self, of_face: &[u32], shell: u32) -> Shell {
        let (mut volume, mut moment) = (0.0, [0.0; 3]);
        for face in (0..self.faces.len()).filter(|&f| of_face[f] == shell) {
            let (cone, [a, b, c]) = (self.cone_volume(face), self.corners(face));
            volume += cone;
            (0..3).for_each(|k| moment[k] += cone * (a[k] + b[k] + c[k]) / 4.0);
        }
        Shell { volume, centroid: moment.map(|m| m / volume) }
    }
}

/// Signed solid angle of a triangle seen from a point.      [vanoosterom1983]
pub(crate) fn solid_angle(corners: [Point3; 3], at: Point3) -> f64 {
    let [a, b, c] = corners.map(|p| sub(p, at));
    let (la, lb, lc) = (norm(a), norm(b), norm(c));
    let below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    // `atan2` and not the quotient: near the face, half of the angle exceeds a right angle and `below` changes its
    // sign.
    2.0 * dot(a, cross(b, c)).atan2(below)
}

/// Components of a graph of `count` members, numbered by their lowest member.
pub(crate) fn connected_components(count: usize, links: impl Iterator<Item = [u32; 2]>) -> (Vec<u32>, u32) {
    let mut root: Vec<u32> = (0..count as u32).collect();
    for [a, b] in links {
        let (a, b) = (find_root(&mut root, a), find_root(&mut root, b));
        // The lower member becomes the root, and not that of the smaller tree: numbers then do not depend on the order
        // of the links.
        root[a.max(b) as usize] = a.min(b);
    }
    let (mut number, mut next) = (vec![0; count], 0);
    for member in 0..count as u32 {
        let top = find_root(&mut root, member);
        if top == member {
            number[member as usize] = next;
            next += 1;
        } else {
            number[member as usize] = number[top as usize];
        }
    }
    (number, next)
}

fn find_root(root: &mut [u32], mut member: u32) -> u32 {
    while root[member as usize] != member {
        root[member as usize] = root[root[member as usize] as usize];
        member = root[member as usize];
    }
    member
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A closed box, outwards.
    pub(crate) fn block(low: Point3, high: Point3) -> Surface {
        let corner = |i: u32| [0, 1, 2].map(|k| if i >> k & 1 == 1 { high[k] } else { low[k] });
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Surface { points: (0..8).map(corner).collect(), faces }
    }

    /// The same box as a cavity, added to a surface.
    pub(crate) fn with_cavity(mut solid: Surface, low: Point3, high: Point3) -> Surface {
        let (cavity, first) = (block(low, high), solid.points.len() as u32);
        solid.points.extend(cavity.points);
        solid.faces.extend(cavity.faces.iter().map(|&[a, b, c]| [a + first, c + first, b + first]));
        solid
    }

    #[test]
    fn a_box_with_a_cavity_has_one_positive_and_one_negative_shell() {
        let hollow = with_cavity(block([0.0; 3], [0.03; 3]), [0.01; 3], [0.02; 3]);
        let (shells, _) = hollow.shells().unwrap();
        assert_eq!(shells.len(), 2);
        assert!((shells[0].volume - 27e-6).abs() < 1e-15 && (shells[1].volume + 1e-6).abs() < 1e-15);
        assert!(shells[1].centroid.iter().all(|c| (c - 0.015).abs() < 1e-12));
    }

    #[test]
    fn a_missing_face_is_named_with_its_edge_and_the_number_of_open_edges() {
        let mut open = block([0.0; 3], [0.03; 3]);
        open.faces.remove(5);
        let error = open.shells().unwrap_err();
        assert!(matches!(error, SurfaceError::Open { count: 3, faces: 1, .. }));
        assert!(error.to_string().contains("mm, one of 3 such edges"));
    }

    #[test]
    fn a_box_with_inward_normals_is_refused() {
        let mut inside_out = block([0.0; 3], [0.03; 3]);
        inside_out.faces.iter_mut().for_each(|f| f.swap(1, 2));
        assert!(matches!(inside_out.shells(), Err(SurfaceError::InvertedSurface { .. })));
    }

    #[test]
    fn a_box_has_the_area_of_its_six_sides() {
        assert!((block([0.0; 3], [0.01, 0.02, 0.03]).area() - 22e-4).abs() < 1e-15);
    }
}
