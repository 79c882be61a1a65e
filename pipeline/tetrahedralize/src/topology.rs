//! Labels whose interfaces are surfaces: specks take the label around them, and no edge joins four faces of the skin.
//!
//! A solver takes no body that hangs together by an edge. Of the parts around such an edge the smallest changes sides, whether it is solid or not:
//! mostly it is a splinter of a refused split; where bodies touch along a line they are welded there.
//!
//! A flat tetrahedron in the surface's plane has its centroid on the surface, and its label by chance. Where that leaves it standing on the body as
//! a flap without volume no operation removes it, and a solver refuses the mesh.

use std::collections::BTreeMap;

use si::vec3::norm;

use crate::complex::{Complex, OUTSIDE};
use crate::delaunay::{SIDES, sorted_edge};
use crate::geometry::{distortion, normal, six_volumes};

/// Times that labels are looked at: each change may make others bad.
const ROUNDS: usize = 20;
/// Rounds in which the smallest part around an edge changes sides, whichever it is; then the smallest empty one.
// Two edges that reverse each other's change go on for ever. What is filled stays so: that ends.
const EITHER: usize = 8;

/// Tetrahedra of a larger distortion have their centroid on the surface when their corners are.
const FLAT: f64 = 1e3;
/// Areas that differ by less than this share are one.
const EQUAL_AREA: f64 = 1e-9;

/// Parts that vanish.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Speck {
    /// Of less than this volume, m³.
    pub(crate) volume: f64,
    /// Or thinner than this (m): between surfaces that should be one.
    pub(crate) thickness: f64,
}

/// Makes labels such that solids are joined by faces, and specks vanish.
pub(crate) fn clean_labels(complex: &mut Complex, speck: Speck) {
    unfold_flat(complex, |_| true);
    remove_specks(complex, speck);
    for round in 0..10 * ROUNDS {
        let edges = crowded_edges(complex);
        if edges.is_empty() {
            break;
        }
        edges.into_iter().for_each(|edge| change_least_part(complex, edge, round < EITHER));
    }
}

/// Gives flat tetrahedra the label with the least area between unlike labels, until none has more than it must.
///
/// Labels that are not `allowed` are given to none.
pub(crate) fn unfold_flat(complex: &mut Complex, allowed: fn(u16) -> bool) {
    let flat: Vec<u32> = complex.living_tets().filter(|t| distortion(complex.corners_of(*t)) > FLAT).collect();
    for _ in 0..ROUNDS {
        let mut changed = false;
        for tet in &flat {
            changed |= relabel_flat(complex, *tet, allowed) || unfold_pair(complex, *tet, allowed);
        }
        if !changed {
            break;
        }
    }
}

/// Changes the label of a tetrahedron where that leaves less area between unlike labels; returns whether it did.
fn relabel_flat(complex: &mut Complex, tet: u32, allowed: fn(u16) -> bool) -> bool {
    let better = other_labels(complex, tet).into_iter().find(|(gain, label)| *gain > 0 && allowed(*label));
    better.inspect(|(_, label)| complex.labels[tet as usize] = *label).is_some()
}

/// The same for two of a fold, of which either alone leaves as much area as before; returns whether it did.
fn unfold_pair(complex: &mut Complex, tet: u32, allowed: fn(u16) -> bool) -> bool {
    let own_label = complex.labels[tet as usize];
    let equal_labels = other_labels(complex, tet).into_iter().filter(|(gain, label)| *gain == 0 && allowed(*label));
    for (_, label) in equal_labels.collect::<Vec<_>>() {
        complex.labels[tet as usize] = label;
        let neighbours = sides_of(complex, tet).map(|(_, neighbour)| neighbour);
        let is_flat = |t: &u32| distortion(complex.corners_of(*t)) > FLAT;
        let fold: Vec<u32> = neighbours.into_iter().flatten().filter(is_flat).collect();
        if fold.into_iter().any(|neighbour| relabel_flat(complex, neighbour, allowed)) {
            return true;
        }
        complex.labels[tet as usize] = own_label;
    }
    false
}

/// The labels around a tetrahedron that are not its own, each with the sign of the area between unlike labels that it would save.
fn other_labels(complex: &Complex, tet: u32) -> Vec<(i8, u16)> {
    let own_label = complex.labels[tet as usize];
    let label_of = |neighbour: Option<u32>| neighbour.map_or(OUTSIDE, |t| complex.labels[t as usize]);
    let sides = sides_of(complex, tet).map(|(area, neighbour)| (area, label_of(neighbour)));
    let area_beside = |label: u16| sides.iter().filter(|(_, other)| *other == label).map(|(area, _)| area).sum::<f64>();
    let total_area: f64 = sides.iter().map(|(area, _)| area).sum();
    let mut labels: Vec<u16> = sides.iter().map(|(_, label)| *label).filter(|label| *label != own_label).collect();
    labels.sort_unstable();
    labels.dedup();
    let sign = |saved: f64| if saved.abs() <= EQUAL_AREA * total_area { 0 } else { saved.signum() as i8 };
    labels.into_iter().map(|label| (sign(area_beside(label) - area_beside(own_label)), label)).collect()
}

/// The area of each face of a tetrahedron, and what is behind it.
fn sides_of(complex: &Complex, tet: u32) -> [(f64, Option<u32>); 4] {
    let nodes = complex.tets[tet as usize];
    SIDES.map(|side| {
        let [a, b, c] = side.map(|i| nodes[i]);
        let is_behind = |t: &u32| {
            let others = &complex.tets[*t as usize];
            *t != tet && others.contains(&b) && others.contains(&c)
        };
        (norm(normal(complex.positions_of([a, b, c]))), complex.star(a).iter().copied().find(is_behind))
    })
}

fn tet_volume(complex: &Complex, tet: u32) -> f64 {
    six_volumes(complex.corners_of(tet)) / 6.0
}

/// Pairs of tetrahedra with a common face.
fn neighbour_pairs(complex: &Complex) -> Vec<[u32; 2]> {
    let mut sides: Vec<([u32; 3], u32)> = Vec::new();
    for tet in complex.living_tets() {
        let nodes = complex.tets[tet as usize];
        for side in SIDES.iter().map(|s| s.map(|i| nodes[i])) {
            let mut key = side;
            key.sort_unstable();
            sides.push((key, tet));
        }
    }
    sides.sort_unstable();
    sides.chunk_by(|a, b| a.0 == b.0).filter(|g| g.len() == 2).map(|g| [g[0].1, g[1].1]).collect()
}

/// Gives specks the label that most of their faces touch.
fn remove_specks(complex: &mut Complex, speck: Speck) {
    let pairs = neighbour_pairs(complex);
    let mut root: Vec<u32> = (0..complex.tets.len() as u32).collect();
    for [a, b] in &pairs {
        if complex.labels[*a as usize] == complex.labels[*b as usize] {
            let (p, q) = (find_root(&mut root, *a), find_root(&mut root, *b));
            root[p.max(q) as usize] = p.min(q);
        }
    }
    let tets: Vec<u32> = complex.living_tets().collect();
    let mut sizes: BTreeMap<u32, [f64; 2]> = BTreeMap::new();
    for tet in &tets {
        sizes.entry(find_root(&mut root, *tet)).or_default()[0] += tet_volume(complex, *tet);
    }
    let mut touched: BTreeMap<u32, BTreeMap<u16, usize>> = BTreeMap::new();
    for [a, b] in pairs.iter().flat_map(|[a, b]| [[*a, *b], [*b, *a]]) {
        let (p, label) = (find_root(&mut root, a), complex.labels[b as usize]);
        if label != complex.labels[a as usize] {
            *touched.entry(p).or_default().entry(label).or_insert(0) += 1;
            sizes.entry(p).or_default()[1] += common_area(complex, [a, b]);
        }
    }
    let is_speck = |[volume, area]: [f64; 2]| volume < speck.volume || 2.0 * volume < speck.thickness * area;
    touched.retain(|root, _| is_speck(sizes[root]));
    for tet in tets {
        let majority = touched.get(&find_root(&mut root, tet)).and_then(|t| t.iter().max_by_key(|(_, count)| **count));
        if let Some((label, _)) = majority {
            complex.labels[tet as usize] = *label;
        }
    }
}

/// Area of the face that two tetrahedra share.
fn common_area(complex: &Complex, [a, b]: [u32; 2]) -> f64 {
    let (nodes, others) = (complex.tets[a as usize], complex.tets[b as usize]);
    let common =
        SIDES.map(|side| side.map(|i| nodes[i])).into_iter().find(|side| side.iter().all(|n| others.contains(n)));
    common.map_or(0.0, |side| norm(normal(complex.positions_of(side))) / 2.0)
}

fn find_root(root: &mut [u32], mut member: u32) -> u32 {
    while root[member as usize] != member {
        root[member as usize] = root[root[member as usize] as usize];
        member = root[member as usize];
    }
    member
}

/// Edges with more than two faces between solid and nothing.
fn crowded_edges(complex: &Complex) -> Vec<[u32; 2]> {
    let (_, faces) = complex.whole_skin();
    let solid = |label: u16| label != OUTSIDE;
    let skin = faces.iter().filter(|(_, [a, b])| solid(*a) != solid(*b));
    let mut edges: Vec<[u32; 2]> =
        skin.flat_map(|([a, b, c], _)| [[*a, *b], [*b, *c], [*c, *a]].map(sorted_edge)).collect();
    edges.sort_unstable();
    edges.chunk_by(|a, b| a == b).filter(|g| g.len() > 2).map(|g| g[0]).collect()
}

/// Of the solid and empty parts around an edge, or of the empty ones alone, changes the one of the least volume.
fn change_least_part(complex: &mut Complex, edge: [u32; 2], either: bool) {
    let ring = complex.edge_ring(edge);
    let solid = |t: u32| complex.labels[t as usize] != OUTSIDE;
    let opposite_nodes =
        |t: u32| complex.tets[t as usize].into_iter().filter(|n| !edge.contains(n)).collect::<Vec<_>>();
    let mut parts: Vec<Vec<u32>> = Vec::new();
    let mut unvisited: Vec<u32> = ring.clone();
    while let Some(first) = unvisited.pop() {
        let mut part = vec![first];
        let mut next = 0;
        while next < part.len() {
            let opposite = opposite_nodes(part[next]);
            let joined = |t: &u32| solid(*t) == solid(first) && opposite_nodes(*t).iter().any(|n| opposite.contains(n));
            let (joined, left): (Vec<u32>, Vec<u32>) = unvisited.iter().partition(|t| joined(t));
            part.extend(joined);
            unvisited = left;
            next += 1;
        }
        parts.push(part);
    }
    let size = |part: &Vec<u32>| part.iter().map(|t| tet_volume(complex, *t)).sum::<f64>();
    if parts.len() <= 2 {
        return;
    }
    let candidates = parts.into_iter().filter(|part| either || !solid(part[0]));
    let Some(least) = candidates.min_by(|a, b| size(a).total_cmp(&size(b)).then(a.cmp(b))) else { return };
    let filling = ring.iter().map(|t| complex.labels[*t as usize]).min().unwrap_or(OUTSIDE);
    let label = if solid(least[0]) { OUTSIDE } else { filling };
    least.into_iter().for_each(|t| complex.labels[t as usize] = label);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::complex::tests::cubes;

    fn volume_of(complex: &Complex, label: u16) -> f64 {
        complex.living_tets().filter(|t| complex.labels[*t as usize] == label).map(|t| tet_volume(complex, t)).sum()
    }

    #[test]
    fn a_layer_thinner_than_a_speck_vanishes_and_a_thicker_one_stays() {
        for (thickness, left) in [(0.01, 0.0), (0.1, 0.9)] {
            // label 1 in all cubes of the middle level but those at the rim
            let inner = |[i, j, k]: [usize; 3]| u16::from(k == 1 && (1..4).contains(&i) && (1..4).contains(&j));
            let mut complex = cubes([5, 5], &[0.0, 1.0, 1.0 + thickness, 2.0], inner);
            assert!((volume_of(&complex, 1) - 9.0 * thickness).abs() < 1e-12);
            clean_labels(&mut complex, Speck { volume: 0.0, thickness: 0.05 });
            assert!((volume_of(&complex, 1) - left).abs() < 1e-12, "{thickness}: {}", volume_of(&complex, 1));
        }
    }

    #[test]
    fn two_solids_that_meet_in_an_edge_are_joined_by_faces_afterwards() {
        let checkered = |[i, j, _]: [usize; 3]| if (i + j) % 2 == 0 { 3 } else { OUTSIDE };
        let mut complex = cubes([4, 4], &[0.0, 1.0, 2.0, 3.0], checkered);
        assert_eq!(crowded_edges(&complex).len(), 27);
        clean_labels(&mut complex, Speck { volume: 0.0, thickness: 0.0 });
        assert!(crowded_edges(&complex).is_empty());
    }

    #[test]
    fn of_the_parts_around_an_edge_the_least_empty_one_is_filled_in_the_end() {
        let checkered = |[i, j, _]: [usize; 3]| if i == j { 3 } else { OUTSIDE };
        for (either, solid) in [(true, false), (false, true)] {
            let mut complex = cubes([2, 2], &[0.0, 1.0], checkered);
            // a solid cube narrower than the empty ones
            complex.points.iter_mut().for_each(|p| p.iter_mut().take(2).for_each(|x| *x = x.max(0.9)));
            let before = volume_of(&complex, 3);
            let edge = crowded_edges(&complex)[0];
            change_least_part(&mut complex, edge, either);
            assert_eq!(volume_of(&complex, 3) > before, solid, "{before} {}", volume_of(&complex, 3));
        }
    }
}
