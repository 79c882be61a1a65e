//! Paint: dark marks on the back, which move with the skin they are painted on.
//!
//! A mark is a disc: its rim is embedded in the skin point by point, so that it bends and turns with it. Where the mark
//! is in the picture is the centroid of what is drawn; where it is in space is the point that was painted.
//!
//! Stands on: `shape` (embedding), the canvas, the camera. Never knows: what moves the skin.

use shape::{QuadraticMesh, Spot};
use si::{Metre, Point2, Point3};

use super::Canvas;
use super::canvas::centroid;
use crate::camera::{Camera, Passing, View, flat_disc};

/// Corners of a mark's rim.
const RIM: usize = 32;
/// Steps to the skin along z; each leaves the square of the slope's sine of the way, a tenth where a back slopes by 20°.
const LIFTS: usize = 6;
/// Grey level of the paint.
const PAINT: f32 = 22.0;

/// A mark on the skin.
pub struct Mark {
    centre: Spot,
    rim: Vec<Spot>,
}

impl Mark {
    /// A disc of `diameter` (m) around `at` (m), seen from above, on the skin of `mesh`; and how far `at` was from the skin, m.
    pub fn paint(mesh: &QuadraticMesh, at: Point3, diameter: Metre) -> (Self, Metre) {
        let (centre, off) = shape::embed(mesh, at);
        let corners = flat_disc(centre.at(&mesh.nodes), 0.5 * diameter, RIM);
        let rim = corners.into_iter().map(|corner| on_top(mesh, corner)).collect();
        (Self { centre, rim }, off)
    }

    /// Where the painted point is, m.
    pub fn at(&self, nodes: &[Point3]) -> Point3 {
        self.centre.at(nodes)
    }

    /// Nodes of the mesh that carry the mark.
    pub fn nodes(&self) -> impl Iterator<Item = u32> + '_ {
        self.rim.iter().chain([&self.centre]).flat_map(|spot| spot.weights.iter().map(|(node, _)| *node))
    }

    /// The mark's outline in a frame, px, each of its corners at its own row's time; none out of the camera's sight.
    fn outline(&self, view: &View, by: &Passing) -> Option<Vec<Point2>> {
        let places = |spot: &Spot| [0, 1, 2].map(|k| spot.at(&by.nodes[k]));
        self.rim.iter().map(|spot| view.passing(by, places(spot))).collect()
    }

    /// Where the mark is in a frame, px: the centroid of what is drawn.
    pub fn seen(&self, view: &View, by: &Passing) -> Option<Point2> {
        self.outline(view, by).map(|outline| centroid(&outline))
    }

    /// Where the mark is in the picture of a body at rest in air, px.
    pub fn pixel(&self, camera: &Camera, nodes: &[Point3]) -> Option<Point2> {
        let outline: Option<Vec<_>> = self.rim.iter().map(|spot| camera.pixel(spot.at(nodes))).collect();
        outline.map(|outline| centroid(&outline))
    }

    /// Draws the mark.
    pub fn draw(&self, canvas: &mut Canvas, view: &View, by: &Passing) {
        if let Some(outline) = self.outline(view, by) {
            canvas.fill(&outline, PAINT);
        }
    }
}

/// The spot of the skin over or under `corner`, by steps along z to the height of the nearest skin, so that slopes keep the
/// disc round and its middle where it was painted.
fn on_top(mesh: &QuadraticMesh, corner: Point3) -> Spot {
    let mut above = corner;
    for _ in 0..LIFTS {
        above[2] = shape::embed(mesh, above).0.at(&mesh.nodes)[2];
    }
    shape::embed(mesh, above).0
}
