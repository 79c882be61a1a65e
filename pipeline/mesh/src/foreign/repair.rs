//! Repairs before the checks: unused nodes, the unit, the orientation of elements, nodes near the plane of symmetry.

use super::defect::MeshDefect;
use super::jacobian::volume_and_least;
use super::raw_mesh::RawMesh;
use si::Metre;
use si::vec3::scale;

/// Largest and smallest body that is simulated, m.
const SIZES: std::ops::RangeInclusive<Metre> = 1e-4..=10.0;
/// Nodes closer to the plane of a half model than this fraction of the size are moved onto it.
const NEAR: f64 = 1e-6;

impl RawMesh {
    /// Drops nodes that no element uses; also returns the number of each node now, `u32::MAX` where it is dropped.
    pub(super) fn drop_unused(&mut self) -> (Option<String>, Vec<u32>) {
        let mut number = vec![u32::MAX; self.nodes.len()];
        self.corners.iter().for_each(|&node| number[node as usize] = 0);
        let used: Vec<usize> = (0..number.len()).filter(|&node| number[node] == 0).collect();
        let dropped = self.nodes.len() - used.len();
        let first = (0..number.len()).find(|&node| number[node] != 0).map(|node| self.node_labels[node]);
        used.iter().enumerate().for_each(|(place, &node)| number[node] = place as u32);
        self.nodes = used.iter().map(|&node| self.nodes[node]).collect();
        self.node_labels = used.iter().map(|&node| self.node_labels[node]).collect();
        self.corners.iter_mut().for_each(|node| *node = number[*node as usize]);
        self.triangles.retain(|(nodes, _)| nodes.iter().all(|&node| number[node as usize] != u32::MAX));
        self.triangles.iter_mut().flat_map(|(nodes, _)| nodes).for_each(|node| *node = number[*node as usize]);
        let note = |first| format!("{dropped} nodes that no element uses are dropped, the first of them node {first}");
        (first.map(note), number)
    }

    /// Converts coordinates to metres; returns the longest side of their box.
    pub(super) fn scale_to_metres(&mut self, unit: Metre) -> Result<Metre, MeshDefect> {
        self.nodes.iter_mut().for_each(|point| *point = scale(*point, unit));
        let span = |k: usize| {
            let axis = self.nodes.iter().map(|point| point[k]);
            axis.clone().fold(f64::NEG_INFINITY, f64::max) - axis.fold(f64::INFINITY, f64::min)
        };
        let size = span(0).max(span(1)).max(span(2));
        if SIZES.contains(&size) { Ok(size) } else { Err(MeshDefect::Size { size, unit }) }
    }

    /// Reorders the nodes of all elements when all are left-handed.
    pub(super) fn reorient_elements(&mut self) -> Option<String> {
        let is_left_handed = |element| volume_and_least(&self.node_places(element)[..4]).0 < 0.0;
        // Only where all are: one that differs from its neighbours is a defect, which turning it would hide.
        if !(0..self.len()).all(is_left_handed) {
            return None;
        }
        for nodes in self.corners.chunks_exact_mut(self.each) {
            nodes.swap(1, 2);
            if nodes.len() == 10 {
                nodes.swap(4, 6);
                nodes.swap(8, 9);
            }
        }
        Some("the file's elements are left-handed; their nodes are reordered".to_owned())
    }

    /// Moves nodes near the plane of a half model onto it.
    pub(super) fn move_to_symmetry_plane(&mut self, size: Metre) -> Result<(), MeshDefect> {
        for (at, &node) in self.nodes.iter_mut().zip(&self.node_labels) {
            if at[2] < -NEAR * size {
                return Err(MeshDefect::BelowPlane { node, z: at[2] });
            }
            // A file in single precision scatters nodes of the plane by 6e-8 of its size; the smallest element is far
            // larger than this.
            at[2] = if at[2] < NEAR * size { 0.0 } else { at[2] };
        }
        Ok(())
    }
}
