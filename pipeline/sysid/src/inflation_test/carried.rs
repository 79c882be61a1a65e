//! Markers that stand on a body: each on its arm, which turns with the nodes around the point that carries it.

use nalgebra::Vector3;
use si::{Metre, Point3};

use super::page::Page;
use crate::rigid;
use diagnostics::{Diagnostic, Result};
use simulate::Loaded;

/// Nodes within this distance of the point that carries a marker turn it: about a quarter of the arm's diameter, so that their rotation
/// is not that of one element.
const PATCH: Metre = 0.010;

/// A marker on its arm, with the nodes around the point that carries it: their number, and −1 for a mirror image at z < 0.
pub(crate) struct Carried {
    at: Vector3<f64>,
    patch: Vec<(usize, f64)>,
}

/// Mean displacement of markers, which turn with the nodes that carry them, m.
pub(crate) fn mean_marker_displacement(markers: &[Carried], nodes: &[Point3], displacement: &[f64]) -> Vector3<f64> {
    let marker_displacement = |marker: &Carried| {
        let initial: Vec<_> = marker.patch.iter().map(|node| node_position(nodes, *node)).collect();
        let node_displacement = |node: &(usize, f64)| {
            let u = &displacement[3 * node.0..3 * node.0 + 3];
            Vector3::new(u[0], u[1], node.1 * u[2])
        };
        let deformed: Vec<_> = initial.iter().zip(&marker.patch).map(|(x, node)| x + node_displacement(node)).collect();
        let deformed_marker = rigid::best_rotation(&initial, &deformed) * (marker.at - rigid::mean_point(&initial))
            + rigid::mean_point(&deformed);
        deformed_marker - marker.at
    };
    markers.iter().map(marker_displacement).sum::<Vector3<f64>>() / markers.len() as f64
}

fn node_position(nodes: &[Point3], (node, side): (usize, f64)) -> Vector3<f64> {
    let [x, y, z] = nodes[node];
    Vector3::new(x, y, side * z)
}

pub(crate) fn carried_markers(page: &Page, loaded: &Loaded) -> Result<Vec<Carried>> {
    let nodes = loaded.solid.nodes();
    // The mirror image as well: the nodes of one half turn out of the plane of symmetry, those of both do not.
    let sides: &[f64] = if loaded.solid.half() { &[1.0, -1.0] } else { &[1.0] };
    let mut markers = Vec::new();
    for marker in page.marker.iter().filter(|marker| marker.compared) {
        let Some(carrier) = marker.on.map(Vector3::from) else { continue };
        let candidates = (0..nodes.len()).flat_map(|node| sides.iter().map(move |side| (node, *side)));
        let patch: Vec<_> = candidates.filter(|node| (node_position(nodes, *node) - carrier).norm() < PATCH).collect();
        if patch.len() < 4 {
            let message = format!("the marker {} stands on no body: {carrier:?} m", marker.names.join(", "));
            let reason = format!("{} nodes lie within {PATCH} m of it", patch.len());
            return Err(Diagnostic::new(message, reason, "correct `on` of the [[marker]] on the page"));
        }
        markers.push(Carried { at: Vector3::from(marker.at), patch });
    }
    Ok(markers)
}
