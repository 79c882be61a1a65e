//! Faces that look the wrong way: flipped patches are turned, and a shell within a shell is a cavity.

use std::collections::BTreeMap;

use si::Point3;
use si::vec3::{cross, dot, norm};

use crate::Part;
use crate::delaunay::sorted_edge;
use crate::geometry::normal;
use crate::tree::Tree;

/// Shells beyond so many are not compared with each other.
pub(crate) const MAX_SHELLS: usize = 200;

/// Winding number of a surface (absolute) above which a point lies within it, and below one less this outside.
const WITHIN: f64 = 0.9;

/// What was changed of a surface before it was meshed.
#[derive(Debug, Clone, PartialEq)]
pub enum Repair {
    /// Faces that looked the other way than their neighbours.
    Turned {
        /// How many.
        faces: usize,
        /// A corner of the first, m.
        at: Point3,
    },
    /// A closed part within another, normals outwards: it was taken for a cavity.
    Cavity {
        /// A corner of it, m.
        at: Point3,
    },
}

impl std::fmt::Display for Repair {
    fn fmt(&self, out: &mut std::fmt::Formatter) -> std::fmt::Result {
        let place_mm = |[x, y, z]: Point3| format!("({:.2}, {:.2}, {:.2}) mm", x * 1e3, y * 1e3, z * 1e3);
        match self {
            Self::Turned { faces, at } => write!(out, "{faces} faces were turned, the first at {}", place_mm(*at)),
            Self::Cavity { at } => write!(out, "the closed part at {} was taken for a cavity", place_mm(*at)),
        }
    }
}

/// Turns faces of a part until neighbours look the same way and solids outwards.
pub(crate) fn orient_part(part: &Part) -> (Part, Vec<Repair>) {
    let mut part = part.clone();
    let (shell, turned) = consistent_shells(&part.faces);
    let mut repairs = Vec::new();
    let count = shell.iter().max().map_or(0, |m| *m as usize + 1);
    let mut flips = vec![0usize; count];
    let mut sizes = vec![0usize; count];
    for (face, number) in shell.iter().enumerate() {
        sizes[*number as usize] += 1;
        flips[*number as usize] += usize::from(turned[face]);
    }
    // the smaller side of a shell is the one that was flipped
    let changed: Vec<usize> = (0..part.faces.len())
        .filter(|f| {
            let number = shell[*f] as usize;
            turned[*f] == (2 * flips[number] <= sizes[number]) && flips[number] > 0
        })
        .collect();
    if let Some(first) = changed.first() {
        repairs.push(Repair::Turned { faces: changed.len(), at: part.points[part.faces[*first][0] as usize] });
        changed.iter().for_each(|f| part.faces[*f].swap(1, 2));
    }
    repairs.extend(turn_shells(&mut part, &shell, count));
    (part, repairs)
}

/// The shell of each face, joined across edges of two faces, and whether the face looks the other way than the shell's first.
pub(crate) fn consistent_shells(faces: &[[u32; 3]]) -> (Vec<u32>, Vec<bool>) {
    let mut edges: BTreeMap<[u32; 2], Vec<(usize, bool)>> = BTreeMap::new();
    for (number, [a, b, c]) in faces.iter().enumerate() {
        for [p, q] in [[*a, *b], [*b, *c], [*c, *a]] {
            edges.entry(sorted_edge([p, q])).or_default().push((number, p < q));
        }
    }
    let mut links: Vec<Vec<(usize, bool)>> = vec![Vec::new(); faces.len()];
    for pair in edges.values().filter(|pair| pair.len() == 2) {
        let [(f, forwards), (g, backwards)] = [pair[0], pair[1]];
        let against = forwards == backwards;
        links[f].push((g, against));
        links[g].push((f, against));
    }
    let (mut shell, mut turned, mut count) = (vec![u32::MAX; faces.len()], vec![false; faces.len()], 0);
    for first in 0..faces.len() {
        if shell[first] != u32::MAX {
            continue;
        }
        shell[first] = count;
        let mut stack = vec![first];
        while let Some(face) = stack.pop() {
            for (other, against) in &links[face] {
                if shell[*other] == u32::MAX {
                    shell[*other] = count;
                    turned[*other] = turned[face] != *against;
                    stack.push(*other);
                }
            }
        }
        count += 1;
    }
    (shell, turned)
}

/// Turns shells that look inwards where nothing surrounds them, and shells that lie within an odd number of others and look outwards.
fn turn_shells(part: &mut Part, shell: &[u32], count: usize) -> Vec<Repair> {
    if count > MAX_SHELLS {
        return Vec::new();
    }
    let triangles = part.triangles();
    let members = |number: usize| (0..shell.len()).filter(move |f| shell[*f] as usize == number);
    let shells: Vec<Vec<[Point3; 3]>> = (0..count).map(|n| members(n).map(|f| triangles[f]).collect()).collect();
    let mut looks_outwards: Vec<bool> = shells.iter().map(|shell| enclosed_volume(shell) > 0.0).collect();
    let mut repairs = Vec::new();
    // a body that is inside out, whether or not its shells cross
    if !looks_outwards.contains(&true) {
        repairs.push(Repair::Turned { faces: part.faces.len(), at: triangles.first().map_or([0.0; 3], |t| t[0]) });
        part.faces.iter_mut().for_each(|face| face.swap(1, 2));
        looks_outwards.fill(true);
    }
    let nesting = if count == 1 { Vec::new() } else { nesting_depths(&shells) };
    for (number, depth) in nesting.into_iter().enumerate() {
        let first_corner = shells[number][0][0];
        let repair = match depth {
            Some(depth) if depth % 2 == 1 && looks_outwards[number] => Repair::Cavity { at: first_corner },
            Some(depth) if depth % 2 == 0 && !looks_outwards[number] => {
                Repair::Turned { faces: shells[number].len(), at: first_corner }
            }
            _ => continue,
        };
        repairs.push(repair);
        members(number).for_each(|f| part.faces[f].swap(1, 2));
    }
    repairs
}

fn enclosed_volume(shell: &[[Point3; 3]]) -> f64 {
    shell.iter().map(|[a, b, c]| dot(*a, cross(*b, *c)) / 6.0).sum()
}

/// In how many others each shell lies with every corner; none where it crosses one, touches it, or lies in the opening of one that is not
/// closed: parts that overlap are united instead, and a cavity behind a hole stays one.
fn nesting_depths(shells: &[Vec<[Point3; 3]>]) -> Vec<Option<usize>> {
    let trees: Vec<Tree> = shells.iter().map(|shell| Tree::new(shell)).collect();
    let is_within = |shell: &[[Point3; 3]], other: &Tree| {
        let windings = || shell.iter().map(|t| other.winding_number(t[0]).abs());
        let first = windings().next().unwrap_or(0.0);
        match first {
            within if within > WITHIN => windings().all(|winding| winding > WITHIN).then_some(true),
            outside if outside < 1.0 - WITHIN => windings().all(|winding| winding < 1.0 - WITHIN).then_some(false),
            _ => None,
        }
    };
    let depth = |number: usize| {
        let others = (0..shells.len()).filter(|other| *other != number);
        let within: Option<Vec<bool>> = others.map(|other| is_within(&shells[number], &trees[other])).collect();
        within.map(|within| within.into_iter().filter(|is_within| *is_within).count())
    };
    (0..shells.len()).map(depth).collect()
}

/// Faces of some area, once each.
pub(crate) fn without_degenerate(part: &Part) -> Part {
    let mut distinct = std::collections::BTreeSet::new();
    let first = |face: &[u32; 3]| {
        let mut key = *face;
        key.sort_unstable();
        let corners = face.map(|n| part.points[n as usize]);
        key[0] != key[1] && key[1] != key[2] && norm(normal(corners)) > 0.0 && distinct.insert(key)
    };
    let mut kept_faces = part.faces.clone();
    let mut first = first;
    kept_faces.retain(|face| first(face));
    Part { points: part.points.clone(), faces: kept_faces, fill: part.fill }
}
