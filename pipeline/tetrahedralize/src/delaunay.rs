//! Delaunay tetrahedra by incremental insertion [bowyer1981] [watson1981].
//!
//! With exact predicates and cavities of tetrahedra whose spheres strictly contain the new point, no tetrahedron of zero volume arises: a point
//! in the plane of a cavity's face, within one sphere through it, is within the other one too. So points need no perturbation.

use si::Point3;
use si::vec3::{add, scale, sub};

use crate::geometry::{in_sphere, orientation};

/// Corners of the face opposite to each corner, normals outwards.
pub(crate) const SIDES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];
const NONE: u32 = u32::MAX;
/// The enclosing box is larger than the points' by this fraction of its diagonal at each side.
const MARGIN: f64 = 0.6;

/// Points with tetrahedra that fill a box around them.
#[derive(Debug, Default)]
pub(crate) struct Delaunay {
    pub(crate) points: Vec<Point3>,
    pub(crate) tets: Vec<[u32; 4]>,
    /// The tetrahedron behind the face opposite to each corner.
    neighbours: Vec<[u32; 4]>,
    free: Vec<u32>,
    /// Which insertion last looked at a tetrahedron, and whether it is in the cavity.
    seen: Vec<(u32, bool)>,
    last: u32,
}

/// A face of a cavity, the tetrahedron behind it, and the tetrahedron that will fill it.
struct Wall {
    nodes: [u32; 3],
    behind: u32,
}

impl Delaunay {
    /// The box around points, in six tetrahedra.
    pub(crate) fn around(points: &[Point3]) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for k in 0..3 {
            low[k] = points.iter().fold(low[k], |l, p| l.min(p[k]));
            high[k] = points.iter().fold(high[k], |h, p| h.max(p[k]));
        }
        let diagonal = sub(high, low);
        let margin = MARGIN * si::vec3::norm(diagonal);
        let low = add(low, [-margin, -1.03 * margin, -1.07 * margin]);
        let size = add(diagonal, scale([2.0, 2.1, 2.2], margin));
        let corner = |i: usize| [0, 1, 2].map(|k| low[k] + if i >> k & 1 == 1 { size[k] } else { 0.0 });
        // Kuhn's six tetrahedra along the diagonal from 0 to 7
        let paths = [[1, 3], [3, 2], [2, 6], [6, 4], [4, 5], [5, 1]];
        let tets = paths.map(|[a, b]| [0, a, b, 7]).to_vec();
        let mut box_of = Self { points: (0..8).map(corner).collect(), tets, ..Self::default() };
        box_of.neighbours = vec![[NONE; 4]; 6];
        box_of.seen = vec![(0, false); 6];
        box_of.link_box();
        box_of
    }

    fn link_box(&mut self) {
        for t in 0..6u32 {
            let next = (t + 1) % 6;
            // tetrahedron t shares the face opposite to its second corner with the next one, opposite to whose third corner it lies
            self.neighbours[t as usize][1] = next;
            self.neighbours[next as usize][2] = t;
        }
        debug_assert!(self.tets.iter().all(|t| orientation(t.map(|n| self.points[n as usize])) > 0.0));
    }

    fn corners_of(&self, tet: u32) -> [Point3; 4] {
        self.tets[tet as usize].map(|n| self.points[n as usize])
    }

    /// The tetrahedron that holds a point, by a walk from the last one.
    fn locate_point(&self, at: Point3) -> u32 {
        let mut tet = self.last;
        let mut turn = 0usize;
        'walk: loop {
            let corners = self.corners_of(tet);
            for k in 0..4 {
                let k = (k + turn) % 4;
                let [a, b, c] = SIDES[k].map(|i| corners[i]);
                let behind = self.neighbours[tet as usize][k];
                if behind != NONE && orientation([a, b, c, at]) > 0.0 {
                    tet = behind;
                    // another order at each step: a fixed one can walk in circles through cospherical points
                    turn = (turn * 5 + 1) % 7;
                    continue 'walk;
                }
            }
            return tet;
        }
    }

    /// Inserts a point of the box; the number of the point that lies in the same place, if there is one.
    pub(crate) fn insert_point(&mut self, at: Point3) -> u32 {
        let first = self.locate_point(at);
        if let Some(same) = self.tets[first as usize].into_iter().find(|n| self.points[*n as usize] == at) {
            return same;
        }
        let number = self.points.len() as u32;
        self.points.push(at);
        let (cavity, walls) = self.find_cavity(first, number);
        self.fill_cavity(&cavity, &walls, number);
        number
    }

    fn find_cavity(&mut self, first: u32, number: u32) -> (Vec<u32>, Vec<Wall>) {
        let point = self.points[number as usize];
        let (mut cavity, mut walls) = (vec![first], Vec::new());
        self.seen[first as usize] = (number, true);
        let mut next = 0;
        while next < cavity.len() {
            let tet = cavity[next];
            next += 1;
            for (k, side) in SIDES.iter().enumerate() {
                let behind = self.neighbours[tet as usize][k];
                if behind != NONE && self.seen[behind as usize].0 != number {
                    let inside = in_sphere(self.corners_of(behind), point) > 0.0;
                    self.seen[behind as usize] = (number, inside);
                    cavity.extend(inside.then_some(behind));
                }
                if behind == NONE || !self.seen[behind as usize].1 {
                    walls.push(Wall { nodes: side.map(|i| self.tets[tet as usize][i]), behind });
                }
            }
        }
        (cavity, walls)
    }

    fn fill_cavity(&mut self, cavity: &[u32], walls: &[Wall], number: u32) {
        self.free.extend(cavity);
        let mut places = Vec::with_capacity(walls.len());
        for wall in walls {
            let slot = self.free.pop().unwrap_or_else(|| {
                self.tets.push([0; 4]);
                self.neighbours.push([NONE; 4]);
                self.seen.push((0, false));
                self.tets.len() as u32 - 1
            });
            places.push(slot);
            let [a, b, c] = wall.nodes;
            // a wall's normal points out of the cavity, away from the new point
            self.tets[slot as usize] = [a, c, b, number];
        }
        for (wall, place) in walls.iter().zip(&places) {
            self.neighbours[*place as usize] = [NONE, NONE, NONE, wall.behind];
            self.seen[*place as usize] = (number, false);
            if wall.behind != NONE {
                let back = self.side_of(wall.behind, wall.nodes);
                self.neighbours[wall.behind as usize][back] = *place;
            }
        }
        self.link_fan(walls, &places);
        self.last = places[0];
        for place in &self.free {
            self.tets[*place as usize] = [NONE; 4];
        }
    }

    /// The corner of a tetrahedron that is none of a face's.
    fn side_of(&self, tet: u32, face: [u32; 3]) -> usize {
        self.tets[tet as usize].iter().position(|n| !face.contains(n)).unwrap_or(0)
    }

    /// Joins the new tetrahedra around the edges of the cavity's wall.
    fn link_fan(&mut self, walls: &[Wall], places: &[u32]) {
        let mut edges: Vec<([u32; 2], u32, usize)> = Vec::with_capacity(3 * walls.len());
        for (wall, place) in walls.iter().zip(places) {
            let [a, b, c] = wall.nodes;
            // corners of the new one are a, c, b: opposite to a lies the edge bc
            edges.extend([([b, c], 0), ([a, b], 1), ([a, c], 2)].map(|(e, k)| (sorted_edge(e), *place, k)));
        }
        edges.sort_unstable();
        for pair in edges.chunks_exact(2) {
            let [(_, p, i), (_, q, j)] = [pair[0], pair[1]];
            self.neighbours[p as usize][i] = q;
            self.neighbours[q as usize][j] = p;
        }
    }

    /// Inserts many points, near ones after each other; the number of each.
    pub(crate) fn insert_all(&mut self, points: &[Point3]) -> Vec<u32> {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        let keys = morton_keys(points);
        order.sort_by_key(|n| (keys[*n as usize], *n));
        let mut numbers = vec![0; points.len()];
        for n in order {
            numbers[n as usize] = self.insert_point(points[n as usize]);
        }
        numbers
    }

    /// The tetrahedra that are.
    pub(crate) fn living_tetrahedra(&self) -> Vec<[u32; 4]> {
        self.tets.iter().copied().filter(|t| t[0] != NONE).collect()
    }
}

pub(crate) fn sorted_edge([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Places along a curve that fills space: the bits of the coordinates in turn.
fn morton_keys(points: &[Point3]) -> Vec<u64> {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for k in 0..3 {
        low[k] = points.iter().fold(low[k], |l, p| l.min(p[k]));
        high[k] = points.iter().fold(high[k], |h, p| h.max(p[k]));
    }
    let size = (0..3).map(|k| high[k] - low[k]).fold(f64::MIN_POSITIVE, f64::max);
    let key = |p: &Point3| {
        let cells = [0, 1, 2].map(|k| ((p[k] - low[k]) / size * f64::from(0x1F_FFFF)) as u64);
        (0..21).rev().fold(0, |key, bit| cells.iter().fold(key, |key, c| key << 1 | (c >> bit & 1)))
    };
    points.iter().map(key).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::six_volumes;

    fn check(points: &[Point3]) -> Delaunay {
        let mut made = Delaunay::around(points);
        made.insert_all(points);
        let tets = made.living_tetrahedra();
        let place = |t: &[u32; 4]| t.map(|n| made.points[n as usize]);
        assert!(tets.iter().all(|t| orientation(place(t)) > 0.0));
        let volume: f64 = tets.iter().map(|t| six_volumes(place(t)) / 6.0).sum();
        let size = sub(made.points[7], made.points[0]);
        assert!((volume / size.iter().product::<f64>() - 1.0).abs() < 1e-9);
        made
    }

    #[test]
    fn cospherical_points_of_a_lattice_fill_the_box_with_positive_tetrahedra() {
        let lattice: Vec<Point3> = (0..216).map(|i| [(i % 6) as f64, (i / 6 % 6) as f64, (i / 36) as f64]).collect();
        check(&lattice);
    }

    #[test]
    fn no_point_lies_within_the_sphere_of_a_tetrahedron() {
        let mut seed = 7u64;
        let mut draw = || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        let cloud: Vec<Point3> = (0..120).map(|_| [draw(), draw(), draw()]).collect();
        let made = check(&cloud);
        for t in made.living_tetrahedra() {
            let corners = t.map(|n| made.points[n as usize]);
            assert!(made.points.iter().all(|p| corners.contains(p) || in_sphere(corners, *p) <= 0.0));
        }
    }
}
