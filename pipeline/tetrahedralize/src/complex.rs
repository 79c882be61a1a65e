//! Tetrahedra that change: nodes know the tetrahedra around them, and nothing else is kept, so that an operation is a list of tetrahedra that go
//! and a list of those that come.

use si::Point3;

use crate::delaunay::SIDES;

/// A tetrahedron that is no more has this first node.
pub(crate) const GONE: u32 = u32::MAX;
/// The label of what is no solid.
pub(crate) const OUTSIDE: u16 = u16::MAX;

/// A face between unlike labels, normal out of the first.
pub(crate) type LabelledFace = ([u32; 3], [u16; 2]);

/// Tetrahedra with labels.
#[derive(Debug, Clone, Default)]
pub(crate) struct Complex {
    pub(crate) points: Vec<Point3>,
    pub(crate) tets: Vec<[u32; 4]>,
    pub(crate) labels: Vec<u16>,
    around: Vec<Vec<u32>>,
    free: Vec<u32>,
}

impl Complex {
    pub(crate) fn new(points: Vec<Point3>, tets: Vec<[u32; 4]>, labels: Vec<u16>) -> Self {
        let mut tets_at_node = vec![Vec::new(); points.len()];
        for (number, tet) in tets.iter().enumerate() {
            tet.iter().for_each(|n| tets_at_node[*n as usize].push(number as u32));
        }
        Self { points, tets, labels, around: tets_at_node, free: Vec::new() }
    }

    pub(crate) fn exists(&self, tet: u32) -> bool {
        self.tets[tet as usize][0] != GONE
    }

    pub(crate) fn living_tets(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.tets.len() as u32).filter(|t| self.exists(*t))
    }

    /// The tetrahedra around a node.
    pub(crate) fn star(&self, node: u32) -> &[u32] {
        &self.around[node as usize]
    }

    pub(crate) fn corners_of(&self, tet: u32) -> [Point3; 4] {
        self.positions_of(self.tets[tet as usize])
    }

    pub(crate) fn positions_of<const N: usize>(&self, nodes: [u32; N]) -> [Point3; N] {
        nodes.map(|n| self.points[n as usize])
    }

    /// The tetrahedra around an edge.
    pub(crate) fn edge_ring(&self, [a, b]: [u32; 2]) -> Vec<u32> {
        let (few, far_node) = if self.star(a).len() <= self.star(b).len() { (a, b) } else { (b, a) };
        self.star(few).iter().copied().filter(|t| self.tets[*t as usize].contains(&far_node)).collect()
    }

    pub(crate) fn add_point(&mut self, at: Point3) -> u32 {
        self.points.push(at);
        self.around.push(Vec::new());
        self.points.len() as u32 - 1
    }

    pub(crate) fn remove_tet(&mut self, tet: u32) {
        for node in self.tets[tet as usize] {
            let star = &mut self.around[node as usize];
            if let Some(place) = star.iter().position(|t| *t == tet) {
                star.swap_remove(place);
            }
        }
        self.tets[tet as usize] = [GONE; 4];
        self.free.push(tet);
    }

    /// Takes out all tetrahedra of a label.
    pub(crate) fn remove_label(&mut self, label: u16) {
        let tets: Vec<u32> = self.living_tets().filter(|t| self.labels[*t as usize] == label).collect();
        tets.into_iter().for_each(|t| self.remove_tet(t));
    }

    pub(crate) fn add_tet(&mut self, nodes: [u32; 4], label: u16) -> u32 {
        let slot = self.free.pop().unwrap_or_else(|| {
            self.tets.push([GONE; 4]);
            self.labels.push(label);
            self.tets.len() as u32 - 1
        });
        self.tets[slot as usize] = nodes;
        self.labels[slot as usize] = label;
        nodes.iter().for_each(|n| self.around[*n as usize].push(slot));
        slot
    }

    /// Tetrahedra go, others with their labels come.
    pub(crate) fn replace_tets(&mut self, old: &[u32], new: &[([u32; 4], u16)]) {
        old.iter().for_each(|t| self.remove_tet(*t));
        new.iter().for_each(|(nodes, label)| {
            self.add_tet(*nodes, *label);
        });
    }

    /// What splitting an edge at a node gives: the tetrahedra around it, and two for each.
    pub(crate) fn bisect_edge(&self, [a, b]: [u32; 2], node: u32) -> (Vec<u32>, Vec<([u32; 4], u16)>) {
        let ring = self.edge_ring([a, b]);
        let instead = |tet: u32, old: u32| {
            (self.tets[tet as usize].map(|n| if n == old { node } else { n }), self.labels[tet as usize])
        };
        let halves = ring.iter().flat_map(|t| [instead(*t, a), instead(*t, b)]).collect();
        (ring, halves)
    }

    /// The label behind a face of a tetrahedron.
    pub(crate) fn label_behind(&self, tet: u32, face: [u32; 3]) -> u16 {
        let [a, b, c] = face;
        let opposite = self.star(a).iter().find(|t| {
            let nodes = &self.tets[**t as usize];
            **t != tet && nodes.contains(&b) && nodes.contains(&c)
        });
        opposite.map_or(OUTSIDE, |t| self.labels[*t as usize])
    }

    /// The faces between unlike labels around a node, each once, normal out of the lower label.
    pub(crate) fn skin_faces(&self, node: u32) -> Vec<[u32; 3]> {
        self.labelled_faces(node).into_iter().map(|(face, _)| face).collect()
    }

    /// The same with the labels.
    pub(crate) fn labelled_faces(&self, node: u32) -> Vec<LabelledFace> {
        let mut faces = Vec::new();
        for tet in self.star(node) {
            let nodes = self.tets[*tet as usize];
            let label = self.labels[*tet as usize];
            for side in SIDES.iter().map(|s| s.map(|i| nodes[i])).filter(|s| s.contains(&node)) {
                let other_label = self.label_behind(*tet, side);
                if label < other_label {
                    faces.push((side, [label, other_label]));
                }
            }
        }
        faces
    }

    /// Whether each node lies on a face between unlike labels, and these faces, in the order of the tetrahedra.
    pub(crate) fn whole_skin(&self) -> (Vec<bool>, Vec<LabelledFace>) {
        let mut sides: Vec<([u32; 3], u16, [u32; 3])> = Vec::new();
        for tet in self.living_tets() {
            let nodes = self.tets[tet as usize];
            for side in SIDES.iter().map(|s| s.map(|i| nodes[i])) {
                let mut key = side;
                key.sort_unstable();
                sides.push((key, self.labels[tet as usize], side));
            }
        }
        sides.sort_unstable();
        let mut on_surface = vec![false; self.points.len()];
        let mut faces = Vec::new();
        for group in sides.chunk_by(|a, b| a.0 == b.0) {
            let behind = group.get(1).map_or(OUTSIDE, |g| g.1);
            if group[0].1 != behind {
                faces.push((group[0].2, [group[0].1, behind]));
                group[0].2.iter().for_each(|n| on_surface[*n as usize] = true);
            }
        }
        (on_surface, faces)
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A grid of cubes, six tetrahedra each, labelled by cube; z of its levels.
    pub(crate) fn cubes(counts: [usize; 2], levels: &[f64], label: impl Fn([usize; 3]) -> u16) -> Complex {
        let number = |[i, j, k]: [usize; 3]| ((k * (counts[1] + 1) + j) * (counts[0] + 1) + i) as u32;
        let place = |i: usize, j: usize, z: f64| -> Point3 { [i as f64, j as f64, z] };
        let rows = |z: f64| (0..=counts[1]).flat_map(move |j| (0..=counts[0]).map(move |i| place(i, j, z)));
        let points = levels.iter().flat_map(|z| rows(*z)).collect();
        let (mut tets, mut labels) = (Vec::new(), Vec::new());
        for cube in
            (0..levels.len() - 1).flat_map(|k| (0..counts[1]).flat_map(move |j| (0..counts[0]).map(move |i| [i, j, k])))
        {
            for path in [[0, 1, 2], [1, 2, 0], [2, 0, 1], [1, 0, 2], [0, 2, 1], [2, 1, 0]] {
                let mut corner = cube;
                let mut nodes = [number(cube); 4];
                for (node, axis) in nodes[1..].iter_mut().zip(path) {
                    corner[axis] += 1;
                    *node = number(corner);
                }
                // three of the six paths turn the other way
                if path[1] != (path[0] + 1) % 3 {
                    nodes.swap(0, 1);
                }
                tets.push(nodes);
                labels.push(label(cube));
            }
        }
        Complex::new(points, tets, labels)
    }

    #[test]
    fn a_grid_of_cubes_has_a_volume_of_one_each_and_faces_between_unlike_labels_on_both_sides() {
        let complex = cubes([2, 1], &[0.0, 1.0], |[i, ..]| i as u16);
        assert_eq!((complex.living_tets().count(), complex.whole_skin().1.len()), (12, 22));
        let volumes = complex.living_tets().map(|tet| crate::geometry::six_volumes(complex.corners_of(tet)));
        assert!(volumes.into_iter().all(|six_volumes| six_volumes == 1.0));
    }
}
