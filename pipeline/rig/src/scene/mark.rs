//! Dark marks on the back, which move with the skin.
//!
//! A mark is a disc whose rim is embedded in the skin point by point, so that it deforms with it. Its true pixel is the centroid of the drawn
//! area; its true position in space is its centre.

use mesh::{QuadraticMesh, Spot};
use si::{Metre, Point2, Point3};

use super::Canvas;
use super::canvas::area_centroid;
use crate::camera::{Camera, FrameMotion, View, flat_disc};

/// Corners of a mark's rim.
const RIM: usize = 32;
/// Fixed-point steps along z to the skin; each reduces the distance to sin² of the slope, a tenth at 20°.
const PROJECTION_STEPS: usize = 6;
/// Grey level of the paint.
const PAINT: f32 = 22.0;

/// A mark on the skin.
pub struct Mark {
    centre: Spot,
    rim: Vec<Spot>,
}

impl Mark {
    /// A disc of `diameter` (m) around `at` (m), seen from above, on the skin of `mesh`, with the distance of `at` from the skin, m.
    pub fn paint_on_skin(mesh: &QuadraticMesh, centre_point: Point3, diameter: Metre) -> (Self, Metre) {
        let (centre, distance) = mesh::embed(mesh, centre_point);
        let corners = flat_disc(centre.at(&mesh.nodes), 0.5 * diameter, RIM);
        let rim = corners.into_iter().map(|corner| above_skin(mesh, corner)).collect();
        (Self { centre, rim }, distance)
    }

    /// Position of its centre, m.
    pub fn centre_position(&self, nodes: &[Point3]) -> Point3 {
        self.centre.at(nodes)
    }

    /// Nodes of the mesh that carry the mark.
    pub fn nodes(&self) -> impl Iterator<Item = u32> + '_ {
        self.rim.iter().chain([&self.centre]).flat_map(|spot| spot.weights.iter().map(|(node, _)| *node))
    }

    /// The mark's outline in a frame, px, each corner at its own row's time; none outside the field of view.
    fn outline_in_frame(&self, view: &View, motion: &FrameMotion) -> Option<Vec<Point2>> {
        let places = |spot: &Spot| [0, 1, 2].map(|k| spot.at(&motion.nodes[k]));
        self.rim.iter().map(|spot| view.project_moving(motion, places(spot))).collect()
    }

    /// The mark's pixel in a frame: the centroid of the drawn area.
    pub fn pixel_in_frame(&self, view: &View, motion: &FrameMotion) -> Option<Point2> {
        self.outline_in_frame(view, motion).map(|outline| area_centroid(&outline))
    }

    /// The mark's pixel for a body at rest in air.
    pub fn pixel_at_rest(&self, camera: &Camera, nodes: &[Point3]) -> Option<Point2> {
        let outline: Option<Vec<_>> = self.rim.iter().map(|spot| camera.pixel(spot.at(nodes))).collect();
        outline.map(|outline| area_centroid(&outline))
    }

    /// Draws the mark.
    pub fn draw_in_frame(&self, canvas: &mut Canvas, view: &View, motion: &FrameMotion) {
        if let Some(outline) = self.outline_in_frame(view, motion) {
            canvas.fill_polygon(&outline, PAINT);
        }
    }
}

/// The point of the skin above or below `corner`, by steps along z to the height of the nearest skin, so that the disc is round in plan
/// view on sloping skin too.
fn above_skin(mesh: &QuadraticMesh, corner: Point3) -> Spot {
    let mut above = corner;
    for _ in 0..PROJECTION_STEPS {
        above[2] = mesh::embed(mesh, above).0.at(&mesh.nodes)[2];
    }
    mesh::embed(mesh, above).0
}
