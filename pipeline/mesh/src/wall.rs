//! Wall: change of the distance between the outer wall of a tail and its sheet when the tail bends, and the rotation of its end.
//!
//! Measured in the section at mid height relative to the sheet, so that bending, which moves wall and sheet alike, does not count.

use std::collections::BTreeSet;

use crate::{QuadraticMesh, SPINE, Skin};
use serde::{Deserialize, Serialize};
use si::{Metre, Pascal, Point2, Point3, vec3};

/// Change of the distance between outer wall and sheet at mid height, and where.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Walls {
    /// Deepest dent of the side without pressure, m.
    pub dent_m: Metre,
    /// Where that is at rest, m.
    pub dent_at: Point3,
    /// Highest bulge of the side under pressure, m.
    pub bulge_m: Metre,
}

/// A section of wall and sheet, by nodes of the mesh.
pub struct Section {
    /// On the outside, by side: y above zero, y below.
    outer: [Vec<u32>; 2],
    /// On the sheet's face, by side, along x.
    sheet: [Vec<u32>; 2],
    rest: Vec<Point3>,
}

/// Nodes nearer to mid height than this belong to the section, m.
// Single precision in an STL rounds coordinates of 100 mm to 7 nm; the smallest cells are a hundred times longer than
// this.
const NEAR: Metre = 1e-6;

impl Section {
    /// The section of a mesh at mid height; nothing where no nodes lie there.
    pub fn of(solid: &QuadraticMesh) -> Option<Self> {
        let level = |node: &u32| solid.nodes[*node as usize][2].abs() < NEAR;
        let skin = solid.skin.iter().filter(|f| f.on == Skin::Outer).flat_map(|f| f.nodes().iter().copied());
        let spine = solid.elements.iter().zip(&solid.regions).filter(|(_, r)| **r == SPINE);
        let spine = spine.flat_map(|(nodes, _)| nodes.iter().copied());
        let spine: BTreeSet<u32> = spine.filter(level).collect();
        let outer: BTreeSet<u32> = skin.filter(level).filter(|n| !spine.contains(n)).collect();
        let side = |candidates: &BTreeSet<u32>, sign: f64| {
            let is_on_side = |n: &&u32| sign * solid.nodes[**n as usize][1] > NEAR;
            let mut nodes: Vec<u32> = candidates.iter().filter(is_on_side).copied().collect();
            nodes.sort_by(|a, b| solid.nodes[*a as usize][0].total_cmp(&solid.nodes[*b as usize][0]));
            nodes
        };
        let sides = |candidates: &BTreeSet<u32>| [side(candidates, 1.0), side(candidates, -1.0)];
        let section = Self { outer: sides(&outer), sheet: sides(&spine), rest: solid.nodes.clone() };
        let is_complete = section.sheet.iter().all(|s| s.len() > 1) && section.outer.iter().all(|o| !o.is_empty());
        is_complete.then_some(section)
    }

    /// Displacement of the walls: `filled` says whether the side of positive y is under pressure.
    pub fn walls(&self, moved: &[Point3], filled: bool) -> Walls {
        let (full, empty) = if filled { (0, 1) } else { (1, 0) };
        let smaller = |best: (Metre, Point3), next: (Metre, Point3)| if next.0 < best.0 { next } else { best };
        let (dent, dent_at) = self.wall_change(moved, empty).fold((0.0, [0.0; 3]), smaller);
        let bulge_m = self.wall_change(moved, full).map(|(by, _)| by).fold(0.0, f64::max);
        Walls { dent_m: -dent, dent_at, bulge_m }
    }

    /// Change of the distance from the sheet of each node of one side's wall, m, and its position at rest.
    fn wall_change<'a>(&'a self, moved: &'a [Point3], side: usize) -> impl Iterator<Item = (Metre, Point3)> + 'a {
        let distance_from_sheet = move |nodes: &[Point3], wall: u32| {
            distance_from_line(in_plane(nodes[wall as usize]), &self.sheet[side], nodes)
        };
        self.outer[side]
            .iter()
            .map(move |&n| (distance_from_sheet(moved, n) - distance_from_sheet(&self.rest, n), self.rest[n as usize]))
    }
}

/// Rotation of the far third of a body in the plane, rad, positive towards y: the best fit to its nodes in the sense of least squares, so
/// that fluttering edges count little.
pub fn end_rotation(rest: &[Point3], moved: &[Point3]) -> f64 {
    let lengthwise = || rest.iter().map(|node| node[0]);
    let (low, high) = (lengthwise().fold(f64::INFINITY, f64::min), lengthwise().fold(f64::NEG_INFINITY, f64::max));
    let far = |x: f64| x > high - (high - low) / 3.0;
    let pairs: Vec<(Point2, Point2)> =
        rest.iter().zip(moved).filter(|(node, _)| far(node[0])).map(|(a, b)| (in_plane(*a), in_plane(*b))).collect();
    let mean =
        |component: &dyn Fn(&(Point2, Point2)) -> f64| pairs.iter().map(component).sum::<f64>() / pairs.len() as f64;
    let (a, b) = ([mean(&|p| p.0[0]), mean(&|p| p.0[1])], [mean(&|p| p.1[0]), mean(&|p| p.1[1])]);
    let (mut sine, mut cosine) = (0.0, 0.0);
    for (from, to) in &pairs {
        let ([x, y], [u, v]) = ([from[0] - a[0], from[1] - a[1]], [to[0] - b[0], to[1] - b[1]]);
        sine += x * v - y * u;
        cosine += x * u + y * v;
    }
    sine.atan2(cosine)
}

/// A wall that dents less than this has not buckled, m.
const LEAST_DENT: Metre = 1e-3;

/// The interval between the rising `pressures` (Pa) in which the dents `dents` (m) grow fastest, by the index of its lower end.
/// None where the deepest dent stays below a millimetre: the wall has not buckled.
// An imperfect wall has no bifurcation: its dent grows by degrees, and fastest near the critical pressure of the perfect one.
pub fn steepest_rise(pressures: &[Pascal], dents: &[Metre]) -> Option<usize> {
    let deepest = dents.iter().copied().fold(0.0, f64::max);
    let steepest = (1..pressures.len())
        .max_by(|a, b| dent_growth(pressures, dents, a - 1).total_cmp(&dent_growth(pressures, dents, b - 1)));
    steepest.filter(|_| deepest >= LEAST_DENT).map(|i| i - 1)
}

/// The pressure at which a wall buckles: where its dent grows fastest over the rising `pressures` (Pa), from the parabola through the three
/// steepest slopes between them of the dents `dents` (m).
/// None where the deepest dent stays below a millimetre.
pub fn buckling_pressure(pressures: &[Pascal], dents: &[Metre]) -> Option<Pascal> {
    let steepest = steepest_rise(pressures, dents)?;
    let middle = |i: usize| 0.5 * (pressures[i] + pressures[i + 1]);
    Some(match steepest > 0 && steepest + 2 < pressures.len() {
        true => parabola_vertex(
            [steepest - 1, steepest, steepest + 1].map(|i| [middle(i), dent_growth(pressures, dents, i)]),
        ),
        false => middle(steepest),
    })
}

/// The same of walls by rising pressure, Pa.
pub fn buckling_pressure_of(walls: impl Iterator<Item = (Pascal, Walls)>) -> Option<Pascal> {
    let (pressures, dents): (Vec<Pascal>, Vec<Metre>) = walls.map(|(pressure, walls)| (pressure, walls.dent_m)).unzip();
    buckling_pressure(&pressures, &dents)
}

/// Growth of the dents from one pressure to the next, m/Pa.
fn dent_growth(pressures: &[Pascal], dents: &[Metre], i: usize) -> f64 {
    (dents[i + 1] - dents[i]) / (pressures[i + 1] - pressures[i])
}

/// Where the parabola through three points, of which the middle one is the highest, is highest.
fn parabola_vertex([a, b, c]: [Point2; 3]) -> f64 {
    let (left, right) = ((b[1] - a[1]) / (b[0] - a[0]), (c[1] - b[1]) / (c[0] - b[0]));
    let curvature = (right - left) / (c[0] - a[0]);
    if curvature < 0.0 { 0.5 * (a[0] + b[0] - left / curvature) } else { b[0] }
}

fn in_plane(p: Point3) -> Point2 {
    [p[0], p[1]]
}

/// Least distance of a point from the line through nodes, m.
fn distance_from_line(point: Point2, line: &[u32], nodes: &[Point3]) -> Metre {
    let corner = |n: u32| in_plane(nodes[n as usize]);
    line.windows(2).map(|w| to_segment(point, corner(w[0]), corner(w[1]))).fold(f64::INFINITY, f64::min)
}

fn to_segment(at: Point2, a: Point2, b: Point2) -> Metre {
    let lift = |p: Point2| [p[0], p[1], 0.0];
    let (way, from) = (vec3::sub(lift(b), lift(a)), vec3::sub(lift(at), lift(a)));
    let length = vec3::dot(way, way);
    let part = if length > 0.0 { (vec3::dot(from, way) / length).clamp(0.0, 1.0) } else { 0.0 };
    vec3::norm(vec3::sub(from, vec3::scale(way, part)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sheet along x with a wall 10 mm to either side of it.
    fn section() -> Section {
        let row = |y: f64| (0..11).map(move |i| [0.01 * f64::from(i), y, 0.0]);
        let rest = row(0.01).chain(row(-0.01)).chain(row(0.0)).collect();
        let sheet: Vec<u32> = (22..33).collect();
        Section { outer: [(0..11).collect(), (11..22).collect()], sheet: [sheet.clone(), sheet], rest }
    }

    #[test]
    fn a_wall_pushed_in_is_a_dent_and_one_blown_out_a_bulge() {
        let section = section();
        let mut moved = section.rest.clone();
        moved[15][1] += 2e-3;
        moved[4][1] += 3e-3;
        let walls = section.walls(&moved, true);
        // distances of 10 mm in doubles: round-off alone
        assert!((walls.dent_m - 2e-3).abs() < 1e-12 && (walls.bulge_m - 3e-3).abs() < 1e-12, "{walls:?}");
        assert_eq!(walls.dent_at, [0.04, -0.01, 0.0]);
    }

    #[test]
    fn turning_the_whole_tail_dents_nothing() {
        let section = section();
        let (s, c) = 0.6f64.sin_cos();
        let moved: Vec<Point3> = section.rest.iter().map(|p| [c * p[0] - s * p[1], s * p[0] + c * p[1], 0.0]).collect();
        let walls = section.walls(&moved, true);
        assert!(walls.dent_m < 1e-12 && walls.bulge_m < 1e-12, "{walls:?}");
    }

    #[test]
    fn the_end_of_a_body_turns_by_the_angle_of_a_rotation_about_any_point() {
        let rest: Vec<Point3> = (0..40).map(|i| [0.003 * f64::from(i), 0.002 * f64::from(i % 5), 0.0]).collect();
        let turned = |angle: f64| -> Vec<Point3> {
            let (s, c) = angle.sin_cos();
            rest.iter().map(|p| [0.01 + c * p[0] - s * p[1], s * p[0] + c * p[1] - 0.02, 0.003]).collect()
        };
        for angle in [-2.0, -0.4, 0.0, 1.2] {
            assert!((end_rotation(&rest, &turned(angle)) - angle).abs() < 1e-12);
        }
        // what lies before the far third does not count
        let mut bent = turned(0.3);
        bent[..20].iter_mut().for_each(|p| p[1] += 0.01);
        assert!((end_rotation(&rest, &bent) - 0.3).abs() < 1e-12);
    }

    #[test]
    fn a_wall_buckles_where_its_dent_grows_fastest_and_a_shallow_dent_is_none() {
        let pressures: Vec<f64> = (1..=10).map(|i| 2.5e3 * f64::from(i)).collect();
        let dents: Vec<f64> = pressures.iter().map(|p| 3e-3 * (1.0 + ((p - 1.93e4) / 3e3).tanh())).collect();
        let found = buckling_pressure(&pressures, &dents).expect("it buckles");
        // the middle of the steepest interval is 550 Pa off
        assert!((found - 1.93e4).abs() < 200.0, "{found}");
        let shallow: Vec<f64> = dents.iter().map(|dent| 0.1 * dent).collect();
        assert_eq!(buckling_pressure(&pressures, &shallow), None);
        assert_eq!(buckling_pressure(&[], &[]), None);
        let few = [[0.0, 5e3, 1e4, 1.5e4, 2e4], [0.0, 0.0, 1e-4, 2.1e-3, 3e-3]];
        assert_eq!(
            (steepest_rise(&few[0], &few[1]), buckling_pressure(&few[0][..4], &few[1][..4])),
            (Some(2), Some(1.25e4))
        );
    }

    #[test]
    fn the_vertex_of_a_parabola_is_found_and_a_line_has_its_middle() {
        let parabola = |x: f64| [x, 3.0 - 2.0 * (x - 1.25).powi(2)];
        assert!((parabola_vertex([0.0, 1.0, 3.0].map(parabola)) - 1.25).abs() < 1e-12);
        assert_eq!(parabola_vertex([0.0, 1.0, 3.0].map(|x| [x, 2.0 * x])), 1.0);
    }
}
