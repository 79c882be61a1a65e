//! Labels whose interfaces are surfaces: specks take the label around them, and no edge joins four faces of the skin.
//!
//! A solver takes no body that hangs together by an edge. Of the parts around such an edge the smallest changes sides, whether it is solid or not:
//! mostly it is a splinter of a refused split; where bodies touch along a line they are welded there.

use std::collections::BTreeMap;

use crate::complex::{Complex, OUTSIDE};
use crate::delaunay::{SIDES, sorted_edge};
use crate::geometry::six_volumes;

/// Times that edges are looked at: each change may make another edge bad.
const ROUNDS: usize = 20;

/// Makes labels such that solids are joined by faces, and specks of less than a volume vanish.
pub(crate) fn clean_labels(complex: &mut Complex, speck: f64) {
    remove_specks(complex, speck);
    for _ in 0..ROUNDS {
        let edges = crowded_edges(complex);
        if edges.is_empty() {
            break;
        }
        edges.into_iter().for_each(|edge| change_least_part(complex, edge));
    }
    remove_specks(complex, speck);
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

/// Gives connected parts of less than a volume the label that most of their faces touch.
fn remove_specks(complex: &mut Complex, speck: f64) {
    let pairs = neighbour_pairs(complex);
    let mut root: Vec<u32> = (0..complex.tets.len() as u32).collect();
    for [a, b] in &pairs {
        if complex.labels[*a as usize] == complex.labels[*b as usize] {
            let (p, q) = (find_root(&mut root, *a), find_root(&mut root, *b));
            root[p.max(q) as usize] = p.min(q);
        }
    }
    let mut volumes: BTreeMap<u32, f64> = BTreeMap::new();
    let tets: Vec<u32> = complex.living_tets().collect();
    for tet in &tets {
        *volumes.entry(find_root(&mut root, *tet)).or_insert(0.0) += tet_volume(complex, *tet);
    }
    volumes.retain(|_, v| *v < speck);
    let mut touched: BTreeMap<u32, BTreeMap<u16, usize>> = BTreeMap::new();
    for [a, b] in pairs.iter().flat_map(|[a, b]| [[*a, *b], [*b, *a]]) {
        let (p, label) = (find_root(&mut root, a), complex.labels[b as usize]);
        if volumes.contains_key(&p) && label != complex.labels[a as usize] {
            *touched.entry(p).or_default().entry(label).or_insert(0) += 1;
        }
    }
    for tet in tets {
        let majority = touched.get(&find_root(&mut root, tet)).and_then(|t| t.iter().max_by_key(|(_, count)| **count));
        if let Some((label, _)) = majority {
            complex.labels[tet as usize] = *label;
        }
    }
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

/// Of the solid and empty parts around an edge, changes the one of the least volume.
fn change_least_part(complex: &mut Complex, edge: [u32; 2]) {
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
    let Some(least) = parts.into_iter().min_by(|a, b| size(a).total_cmp(&size(b)).then(a.cmp(b))) else { return };
    let filling = ring.iter().map(|t| complex.labels[*t as usize]).min().unwrap_or(OUTSIDE);
    let label = if solid(least[0]) { OUTSIDE } else { filling };
    least.into_iter().for_each(|t| complex.labels[t as usize] = label);
}
