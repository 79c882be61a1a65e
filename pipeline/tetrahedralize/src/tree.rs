//! A tree of boxes over triangles: nearest point, first crossing of a ray, winding number.

use si::Point3;
use si::vec3::{add, cross, dot, norm, scale, sub};

use crate::geometry::{centroid, distance, nearest_on_triangle, normal};

/// Triangles in a leaf.
const LEAF: usize = 4;
/// A branch is seen as a dipole from so many radii away; the winding number errs by some 1e-3 then [barill2018].
const FAR: f64 = 2.5;

#[derive(Debug, Clone)]
struct Branch {
    low: Point3,
    high: Point3,
    /// The first of its triangles in the tree's order, and their number.
    first: u32,
    count: u32,
    /// The second child; the first follows its parent. 0 in a leaf.
    second: u32,
    /// Sum of area vectors, and their centre by area.
    dipole: Point3,
    centre: Point3,
    radius: f64,
}

/// Triangles, sorted for searches.
#[derive(Debug, Clone)]
pub(crate) struct Tree {
    branches: Vec<Branch>,
    triangles: Vec<[Point3; 3]>,
    /// The number of each sorted triangle in the list that was given.
    numbers: Vec<u32>,
}

/// The nearest point of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Nearest {
    pub(crate) point: Point3,
    pub(crate) distance: f64,
    /// The triangle's number.
    pub(crate) triangle: u32,
}

impl Tree {
    pub(crate) fn new(triangles: &[[Point3; 3]]) -> Self {
        let mut numbers: Vec<u32> = (0..triangles.len() as u32).collect();
        let centres: Vec<Point3> = triangles.iter().map(|t| centroid(*t)).collect();
        let mut tree = Self { branches: Vec::new(), triangles: Vec::new(), numbers: Vec::new() };
        if !triangles.is_empty() {
            tree.grow_branch(triangles, &centres, (0, &mut numbers));
        }
        tree.triangles = numbers.iter().map(|n| triangles[*n as usize]).collect();
        tree.numbers = numbers;
        tree
    }

    fn grow_branch(
        &mut self,
        triangles: &[[Point3; 3]],
        centres: &[Point3],
        (first, part): (usize, &mut [u32]),
    ) -> u32 {
        let branch_number = self.branches.len();
        self.branches.push(branch_of(triangles, first, part));
        if part.len() > LEAF {
            let Branch { low, high, .. } = self.branches[branch_number];
            let axis = (0..3).max_by(|i, j| (high[*i] - low[*i]).total_cmp(&(high[*j] - low[*j]))).unwrap_or(0);
            let middle = part.len() / 2;
            let key = |n: &u32| (centres[*n as usize][axis], *n);
            part.select_nth_unstable_by(middle, |p, q| key(p).0.total_cmp(&key(q).0).then(p.cmp(q)));
            let (lower, upper) = part.split_at_mut(middle);
            self.grow_branch(triangles, centres, (first, lower));
            self.branches[branch_number].second = self.grow_branch(triangles, centres, (first + middle, upper));
        }
        branch_number as u32
    }

    /// The nearest point within `reach`.
    pub(crate) fn nearest(&self, at: Point3, reach: f64) -> Option<Nearest> {
        let mut best: Option<Nearest> = None;
        let mut stack = vec![(0u32, 0.0)];
        while let Some((place, gap)) = stack.pop() {
            let limit = best.map_or(reach, |b| b.distance);
            if gap > limit || self.branches.is_empty() {
                continue;
            }
            let branch = &self.branches[place as usize];
            if branch.second == 0 {
                self.nearest_in_leaf(branch, at, (&mut best, reach));
                continue;
            }
            let children = [place + 1, branch.second].map(|c| (c, self.box_gap(c, at)));
            let nearer = usize::from(children[1].1 < children[0].1);
            stack.extend([children[1 - nearer], children[nearer]]);
        }
        best
    }

    fn nearest_in_leaf(&self, branch: &Branch, at: Point3, (best, reach): (&mut Option<Nearest>, f64)) {
        for sorted in branch.first..branch.first + branch.count {
            let point = nearest_on_triangle(at, self.triangles[sorted as usize]);
            let candidate = Nearest { point, distance: distance(at, point), triangle: self.numbers[sorted as usize] };
            if candidate.distance <= best.map_or(reach, |b| b.distance) {
                *best = Some(candidate);
            }
        }
    }

    /// A triangle within `reach` of a point, the hinted one if it is; its place in the tree's order.
    pub(crate) fn within(&self, at: Point3, reach: f64, hint: Option<u32>) -> Option<u32> {
        let within_reach =
            |sorted: u32| distance(at, nearest_on_triangle(at, self.triangles[sorted as usize])) <= reach;
        if let Some(sorted) = hint.filter(|h| within_reach(*h)) {
            return Some(sorted);
        }
        let mut stack = if self.branches.is_empty() { vec![] } else { vec![0u32] };
        while let Some(place) = stack.pop() {
            let branch = &self.branches[place as usize];
            if self.box_gap(place, at) > reach {
                continue;
            }
            if branch.second != 0 {
                stack.extend([branch.second, place + 1]);
            } else if let Some(sorted) = (branch.first..branch.first + branch.count).find(|s| within_reach(*s)) {
                return Some(sorted);
            }
        }
        None
    }

    /// Distance of a point from a branch's box.
    fn box_gap(&self, place: u32, at: Point3) -> f64 {
        let Branch { low, high, .. } = &self.branches[place as usize];
        let gap = |k: usize| (low[k] - at[k]).max(at[k] - high[k]).max(0.0);
        norm([gap(0), gap(1), gap(2)])
    }

    /// The distances at which a ray along a unit vector crosses triangles within `reach`, with their numbers, unsorted.
    pub(crate) fn ray_crossings(&self, from: Point3, along: Point3, reach: f64) -> Vec<(f64, u32)> {
        let mut hits = Vec::new();
        let mut stack = if self.branches.is_empty() { vec![] } else { vec![0u32] };
        while let Some(place) = stack.pop() {
            let branch = &self.branches[place as usize];
            if !crosses_box(branch, from, along, reach) {
                continue;
            }
            if branch.second != 0 {
                stack.extend([place + 1, branch.second]);
                continue;
            }
            for sorted in branch.first..branch.first + branch.count {
                let hit = ray_crossing(self.triangles[sorted as usize], from, along);
                hits.extend(hit.filter(|t| (0.0..=reach).contains(t)).map(|t| (t, self.numbers[sorted as usize])));
            }
        }
        hits
    }

    /// Generalised winding number: 1 inside of a closed surface with normals outwards, 0 outside [barill2018].
    pub(crate) fn winding_number(&self, at: Point3) -> f64 {
        let mut angle = 0.0;
        let mut stack = if self.branches.is_empty() { vec![] } else { vec![0u32] };
        while let Some(place) = stack.pop() {
            let branch = &self.branches[place as usize];
            let away = sub(branch.centre, at);
            let length = norm(away);
            if length > FAR * branch.radius {
                angle += dot(branch.dipole, away) / length.powi(3);
            } else if branch.second != 0 {
                stack.extend([place + 1, branch.second]);
            } else {
                let leaf = branch.first as usize..(branch.first + branch.count) as usize;
                angle += self.triangles[leaf].iter().map(|t| solid_angle(*t, at)).sum::<f64>();
            }
        }
        angle / (4.0 * std::f64::consts::PI)
    }
}

fn branch_of(triangles: &[[Point3; 3]], first: usize, part: &[u32]) -> Branch {
    let members = || part.iter().map(|n| triangles[*n as usize]);
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let (mut dipole, mut moment, mut area) = ([0.0; 3], [0.0; 3], 0.0);
    for corners in members() {
        for k in 0..3 {
            low[k] = corners.iter().fold(low[k], |l, p| l.min(p[k]));
            high[k] = corners.iter().fold(high[k], |h, p| h.max(p[k]));
        }
        let vector = scale(normal(corners), 0.5);
        dipole = add(dipole, vector);
        moment = add(moment, scale(centroid(corners), norm(vector)));
        area += norm(vector);
    }
    let centre = if area > 0.0 { scale(moment, 1.0 / area) } else { scale(add(low, high), 0.5) };
    let radius = members().flatten().map(|p| distance(p, centre)).fold(0.0, f64::max);
    Branch { low, high, first: first as u32, count: part.len() as u32, second: 0, dipole, centre, radius }
}

fn crosses_box(Branch { low, high, .. }: &Branch, from: Point3, along: Point3, reach: f64) -> bool {
    let (mut enter, mut leave) = (0.0f64, reach);
    for k in 0..3 {
        if along[k].abs() < 1e-300 {
            if from[k] < low[k] || from[k] > high[k] {
                return false;
            }
            continue;
        }
        let (s, t) = ((low[k] - from[k]) / along[k], (high[k] - from[k]) / along[k]);
        enter = enter.max(s.min(t));
        leave = leave.min(s.max(t));
    }
    // rounding of a box that is as flat as a face
    enter <= leave * (1.0 + 1e-12) + 1e-300
}

/// Where a ray crosses a triangle [moller1997].
fn ray_crossing([a, b, c]: [Point3; 3], from: Point3, along: Point3) -> Option<f64> {
    let (ab, ac) = (sub(b, a), sub(c, a));
    let p = cross(along, ac);
    let determinant = dot(ab, p);
    if determinant.abs() < 1e-12 * norm(ab) * norm(ac) {
        return None;
    }
    let s = sub(from, a);
    let u = dot(s, p) / determinant;
    let q = cross(s, ab);
    let v = dot(along, q) / determinant;
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| dot(ac, q) / determinant)
}

/// Signed solid angle of a triangle seen from a point, 4π in all from inside [vanoosterom1983].
fn solid_angle(corners: [Point3; 3], at: Point3) -> f64 {
    let [a, b, c] = corners.map(|p| sub(p, at));
    let (la, lb, lc) = (norm(a), norm(b), norm(c));
    let below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
    2.0 * dot(a, cross(b, c)).atan2(below)
}
