//! Resolution of places: the nodes, edges and faces of a mesh that a place of the case selects.

use std::collections::BTreeMap;

use mesh::foreign::{self, NamedSurface};
use mesh::{Skin, Solid};
use si::vec3::{norm, sub};
use si::{Metre, Point3};

use crate::case::Place;
use diagnostics::{Diagnostic, Result};

/// Largest distance of a requested point from the body, relative to the body's size.
const OFF: f64 = 0.05;

/// A solid with the data for resolving places.
pub(super) struct Reach<'a> {
    pub solid: &'a Solid,
    /// Longest side of its box, m.
    pub size: Metre,
}

impl Reach<'_> {
    /// The node nearest to a point that `name` asks for; the first of equally near ones.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the point is off the body.
    pub(crate) fn nearest_node(&self, name: &str, point: Point3) -> Result<u32> {
        let distance_to = |node: &Point3| norm(sub(*node, point));
        let nodes = self.solid.nodes().iter().enumerate();
        let node = nodes.min_by(|a, b| distance_to(a.1).total_cmp(&distance_to(b.1))).map_or(0, |(node, _)| node);
        self.on_body(name, distance_to(&self.solid.nodes()[node])).map(|()| node as u32)
    }

    /// # Errors
    /// A [`Diagnostic`] when `name` asks for a point this far (m) from what it means.
    pub(crate) fn on_body(&self, name: &str, apart: Metre) -> Result<()> {
        if apart <= OFF * self.size {
            return Ok(());
        }
        Err(Diagnostic::new(
            format!("{name} is {:.3} mm off the body", 1e3 * apart),
            format!(
                "the limit is {:.3} mm, a twentieth of the body's size; {}",
                1e3 * OFF * self.size,
                self.extent_text()
            ),
            "correct its place: metres, in the frame of the mesh",
        ))
    }

    pub(crate) fn holds_node(&self, place: &Place, node: u32) -> bool {
        place.holds(self.solid.nodes()[node as usize], self.size)
    }

    /// The nodes in a place.
    pub(crate) fn nodes_in(&self, place: &Place) -> Vec<u32> {
        (0..self.solid.nodes().len() as u32).filter(|&node| self.holds_node(place, node)).collect()
    }

    /// The nodes of one of the mesh file's surfaces, by its name or tag.
    ///
    /// # Errors
    /// A [`Diagnostic`] with the names that there are.
    pub(crate) fn on_surface(&self, surfaces: &[NamedSurface], word: &str) -> Result<Vec<u32>> {
        let elements = (0..self.solid.len()).map(|element| self.solid.element(element));
        Ok(foreign::surface(surfaces, word)?.nodes(elements))
    }

    /// Faces of the outer skin whose corners all lie in a place.
    pub(crate) fn faces_in(&self, place: &Place) -> Vec<Vec<u32>> {
        let corners = |nodes: &[u32]| if nodes.len() == 8 { 4 } else { 3 };
        let within = |nodes: &[u32]| nodes[..corners(nodes)].iter().all(|&node| self.holds_node(place, node));
        let faces = self.solid.faces().into_iter().filter(|(nodes, on)| *on == Skin::Outer && within(nodes));
        faces.map(|(nodes, _)| nodes.to_vec()).collect()
    }

    /// Edges of the outer skin whose ends both lie in a place: two ends, and the middle node if there is one.
    pub(crate) fn edges_in(&self, place: &Place) -> Vec<Vec<u32>> {
        let mut edges = BTreeMap::new();
        for (nodes, _) in self.solid.faces().into_iter().filter(|face| face.1 == Skin::Outer) {
            let corners = if nodes.len() == 8 { 4 } else { 3 };
            for (side, (a, b)) in (0..corners).map(|n| (n, (n + 1) % corners)).enumerate() {
                let (low, high) = (nodes[a].min(nodes[b]), nodes[a].max(nodes[b]));
                if self.holds_node(place, low) && self.holds_node(place, high) {
                    edges.insert((low, high), nodes.get(corners + side).copied());
                }
            }
        }
        edges
            .into_iter()
            .map(|((low, high), middle)| [Some(low), Some(high), middle].into_iter().flatten().collect())
            .collect()
    }

    /// The box around all nodes in words, for messages.
    pub(crate) fn extent_text(&self) -> String {
        let axis = |k: usize| {
            let places = self.solid.nodes().iter().map(|node| node[k]);
            let (low, high) = (places.clone().fold(f64::INFINITY, f64::min), places.fold(f64::NEG_INFINITY, f64::max));
            format!("{} from {low:.6} to {high:.6}", ["x", "y", "z"][k])
        };
        format!("the mesh has {}, {}, {} m", axis(0), axis(1), axis(2))
    }
}
