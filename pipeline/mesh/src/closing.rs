//! Open surfaces closed before they are meshed: corners along gaps are welded, holes are covered by the triangulation of least area
//! [barequet1995].
//!
//! A closed surface is left as it is, to the bit. An open seam whose triangles have no area, as at a T-junction, is no hole.

use std::collections::{BTreeMap, BTreeSet};

use crate::surface::{Surface, place_text};
use si::vec3::{add, cross, dot, norm, sub};
use si::{Metre, Point3, SquareMetre};

/// Corners of a hole at most: the least area is sought in the cube of their number.
// Some 0.3 million triangles are weighed for that many; a hole of a thousand corners would take 170 million.
const MAX_CORNERS: usize = 120;
/// A hole wider than this part of the surface's length is an opening that was meant, unless it is of three corners, where a face is missing, or
/// plane, as where the side that a body stands on is missing: there is one way to cover these.
const WIDEST: f64 = 0.35;
/// Corners of a plane hole are off their plane by no more than this part of its width.
const PLANE: f64 = 1e-3;

/// What was changed of an open surface, in a line each.
pub(crate) type Repairs = Vec<String>;

/// The surface with gaps below `tolerance` (m) welded and holes covered; none where it is closed.
pub(crate) fn closed_surface(surface: &Surface, tolerance: Metre) -> Option<(Surface, Repairs)> {
    let open = open_edges(&surface.faces);
    if open.is_empty() {
        return None;
    }
    let (faces, welded) = weld_seams(surface, &open, tolerance);
    let mut closed = Surface { points: surface.points.clone(), faces };
    let mut repairs: Repairs = Vec::new();
    if welded > 0 {
        repairs.push(format!("{welded} corners along gaps were moved by less than {:.4} mm", tolerance * 1e3));
    }
    let (length, mut covered, mut largest) = (surface.length(), 0, (0.0, [0.0; 3]));
    for corners in loops(&open_edges(&closed.faces)) {
        let places: Vec<Point3> = corners.iter().map(|corner| closed.points[*corner as usize]).collect();
        let width = widest(&places);
        let is_opening = width > WIDEST * length && distance_from_plane(&places) > PLANE * width;
        if corners.len() > MAX_CORNERS || is_opening {
            continue;
        }
        let cover = least_cover(&places);
        let area: SquareMetre = cover.iter().map(|triangle| area(triangle.map(|corner| places[corner]))).sum();
        if area <= tolerance * width {
            continue;
        }
        closed.faces.extend(cover.into_iter().map(|triangle| triangle.map(|corner| corners[corner])));
        covered += 1;
        if width > largest.0 {
            largest = (width, places[0]);
        }
    }
    if covered > 0 {
        let (width, corner) = (largest.0 * 1e3, place_text(&largest.1));
        repairs.push(format!("{covered} holes were covered, the widest of {width:.2} mm at {corner}"));
    }
    (!repairs.is_empty()).then_some((closed, repairs))
}

/// Edges of one face alone.
fn open_edges(faces: &[[u32; 3]]) -> BTreeSet<[u32; 2]> {
    let mut counts: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for [a, b, c] in faces {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            *counts.entry([*p.min(q), *p.max(q)]).or_default() += 1;
        }
    }
    counts.into_iter().filter(|(_, count)| *count == 1).map(|(edge, _)| edge).collect()
}

/// The faces with corners of open edges that are nearer than `tolerance` made one, and how many corners went.
fn weld_seams(surface: &Surface, open: &BTreeSet<[u32; 2]>, tolerance: Metre) -> (Vec<[u32; 3]>, usize) {
    // Corners of open edges alone: welding all that are near would collapse thin walls and slits of the part that is
    // closed.
    let corners: BTreeSet<u32> = open.iter().flatten().copied().collect();
    let cell = |point: &Point3| point.map(|x| (x / tolerance).floor() as i64);
    let mut kept: BTreeMap<[i64; 3], Vec<u32>> = BTreeMap::new();
    let mut moved: BTreeMap<u32, u32> = BTreeMap::new();
    for corner in corners {
        let point = surface.points[corner as usize];
        let near = neighbour_cells(cell(&point)).filter_map(|cell| kept.get(&cell)).flatten().copied();
        let is_near = |other: &u32| norm(sub(surface.points[*other as usize], point)) <= tolerance;
        match near.filter(is_near).min() {
            Some(first) => drop(moved.insert(corner, first)),
            None => kept.entry(cell(&point)).or_default().push(corner),
        }
    }
    let mut distinct = BTreeSet::new();
    let target = |corner: u32| moved.get(&corner).copied().unwrap_or(corner);
    let faces = surface.faces.iter().map(|face| face.map(target)).filter(|face| {
        let mut key = *face;
        key.sort_unstable();
        key[0] != key[1] && key[1] != key[2] && distinct.insert(key)
    });
    (faces.collect(), moved.len())
}

fn neighbour_cells([x, y, z]: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    let steps = || -1..=1;
    steps().flat_map(move |i| steps().flat_map(move |j| steps().map(move |k| [x + i, y + j, z + k])))
}

/// Closed loops of edges, corner by corner. An edge that is in none is left out.
fn loops(edges: &BTreeSet<[u32; 2]>) -> Vec<Vec<u32>> {
    let mut neighbours: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
    for [a, b] in edges {
        neighbours.entry(*a).or_default().insert(*b);
        neighbours.entry(*b).or_default().insert(*a);
    }
    let mut found = Vec::new();
    while let Some(start) = neighbours.iter().find(|(_, others)| !others.is_empty()).map(|(corner, _)| *corner) {
        let mut path = vec![start];
        while let Some(next) = path.last().and_then(|end| neighbours[end].first().copied()) {
            let end = path[path.len() - 1];
            for (corner, other) in [(end, next), (next, end)] {
                neighbours.entry(corner).or_default().remove(&other);
            }
            // where the path meets itself a loop is complete, and the path goes on from there
            match path.iter().position(|corner| *corner == next) {
                Some(first) => found.push(path.drain(first + 1..).chain([next]).collect()),
                None => path.push(next),
            }
        }
    }
    found
}

/// The triangulation of a polygon with the least area, by corner numbers.
fn least_cover(places: &[Point3]) -> Vec<[usize; 3]> {
    let count = places.len();
    let mut best = vec![vec![(0.0, 0); count]; count];
    for span in 2..count {
        for first in 0..count - span {
            let last = first + span;
            let with_apex = |apex: usize| {
                let own = area([first, apex, last].map(|corner| places[corner]));
                (best[first][apex].0 + best[apex][last].0 + own, apex)
            };
            let least = (first + 1..last).map(with_apex).min_by(|a, b| a.0.total_cmp(&b.0));
            best[first][last] = least.unwrap_or((0.0, first + 1));
        }
    }
    let (mut triangles, mut spans) = (Vec::new(), vec![(0, count - 1)]);
    while let Some((first, last)) = spans.pop() {
        if last - first >= 2 {
            let apex = best[first][last].1;
            triangles.push([first, apex, last]);
            spans.extend([(first, apex), (apex, last)]);
        }
    }
    triangles
}

/// The largest distance of a polygon's corners from the plane through their middle, normal to the polygon's area vector, m.
fn distance_from_plane(places: &[Point3]) -> Metre {
    let middle = [0, 1, 2].map(|k| places.iter().map(|p| p[k]).sum::<f64>() / places.len() as f64);
    let arms: Vec<Point3> = places.iter().map(|p| sub(*p, middle)).collect();
    let sides = arms.iter().zip(arms.iter().cycle().skip(1));
    let normal = sides.map(|(a, b)| cross(*a, *b)).fold([0.0; 3], add);
    let length = norm(normal).max(f64::MIN_POSITIVE);
    arms.iter().map(|arm| dot(*arm, normal).abs() / length).fold(0.0, f64::max)
}

fn area([a, b, c]: [Point3; 3]) -> SquareMetre {
    0.5 * norm(cross(sub(b, a), sub(c, a)))
}

/// The largest distance between two of the points, m.
fn widest(points: &[Point3]) -> Metre {
    let distances = points.iter().flat_map(|a| points.iter().map(move |b| norm(sub(*a, *b))));
    distances.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stl;

    /// A cube of 10 mm in twelve faces, each with corners of its own that are off by up to `gap` (m).
    fn loose_cube(gap: Metre) -> Surface {
        let corner = |n: usize| [n & 1, n >> 1 & 1, n >> 2].map(|bit| 0.01 * bit as f64);
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
        let off = |n: usize| [0, 1, 2].map(|k| gap * (1.7 * (n + 5 * k) as f64).sin());
        let points: Vec<Point3> = triangles
            .flatten()
            .enumerate()
            .map(|(n, number)| {
                let (place, off) = (corner(number), off(n));
                [0, 1, 2].map(|k| place[k] + off[k])
            })
            .collect();
        let faces = (0..12).map(|face| [0, 1, 2].map(|k| 3 * face + k)).collect();
        Surface { points, faces }
    }

    #[test]
    fn corners_along_gaps_become_one_and_the_cube_is_closed() {
        let (closed, repairs) = closed_surface(&loose_cube(2e-6), 1e-5).unwrap();
        assert!(open_edges(&closed.faces).is_empty() && closed.faces.len() == 12, "{repairs:?}");
        assert!((closed.volume() / 1e-6 - 1.0).abs() < 1e-3, "{}", closed.volume());
        assert!(repairs[0].starts_with("28 corners"), "{repairs:?}");
    }

    #[test]
    fn missing_faces_and_a_missing_plane_side_are_covered_and_a_wide_opening_is_not() {
        let (mut cube, _) = closed_surface(&loose_cube(0.0), 1e-6).unwrap();
        assert!(closed_surface(&cube, 1e-6).is_none(), "a closed surface is left as it is");
        let mut holed_cube = cube.clone();
        holed_cube.faces.truncate(10);
        let (closed, _) = closed_surface(&holed_cube, 1e-6).unwrap();
        assert!(open_edges(&closed.faces).is_empty());
        cube.faces.drain(6..10);
        assert!(closed_surface(&cube, 1e-6).is_none(), "two sides with a common edge are an opening");
        let mut holed = stl::read(&stl::write(&ball(24), 1e-3, "ball"), 1e-3).unwrap();
        holed.faces.drain(40..43);
        let (closed, repairs) = closed_surface(&holed, 1e-6).unwrap();
        assert!(open_edges(&closed.faces).is_empty() && repairs[0].contains("1 holes were covered"), "{repairs:?}");
    }

    #[test]
    fn the_seam_of_a_t_junction_is_no_hole() {
        let (mut cube, _) = closed_surface(&loose_cube(0.0), 1e-6).unwrap();
        let [a, b, c] = cube.faces.swap_remove(0);
        let middle = [0, 1, 2].map(|k| 0.5 * (cube.points[a as usize][k] + cube.points[b as usize][k]));
        cube.points.push(middle);
        let new = (cube.points.len() - 1) as u32;
        cube.faces.extend([[a, new, c], [new, b, c]]);
        assert!(closed_surface(&cube, 1e-6).is_none());
    }

    /// A ball of 10 mm by rows of `count` faces.
    fn ball(count: u32) -> Surface {
        let place = |row: u32, column: u32| {
            let (polar, turn) = (
                std::f64::consts::PI * f64::from(row) / f64::from(count),
                std::f64::consts::TAU * f64::from(column % count) / f64::from(count),
            );
            [0.01 * polar.sin() * turn.cos(), 0.01 * polar.sin() * turn.sin(), 0.01 * polar.cos()]
        };
        let mut surface = Surface::default();
        for (row, column) in (0..count).flat_map(|row| (0..count).map(move |column| (row, column))) {
            let quad = [place(row, column), place(row + 1, column), place(row + 1, column + 1), place(row, column + 1)];
            for triangle in [[0, 1, 2], [0, 2, 3]] {
                let first = surface.points.len() as u32;
                surface.points.extend(triangle.map(|k| quad[k]));
                surface.faces.push([first, first + 1, first + 2]);
            }
        }
        surface
    }
}
