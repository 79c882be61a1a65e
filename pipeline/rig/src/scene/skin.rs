//! The skin of the tail, rendered with a depth buffer and one directional light.
//!
//! The outer faces of the half mesh and their mirror images are drawn as triangles. The silicone is grey, the sheet
//! behind it white.

use mesh::{QuadraticMesh, SPINE, Skin as On};
use si::{Point3, vec3};

use super::Canvas;
use super::raster::{Corner, SAMPLES, Samples};
use crate::camera::{FrameMotion, View};

/// Grey of silicone and of the sheet, lit squarely, 0 to 255.
const SILICONE: f32 = 172.0;
const SHEET: f32 = 232.0;
/// Ambient fraction of the light.
const AMBIENT: f64 = 0.45;
/// Towards the lamp over the bench.
const SUN: Point3 = [-0.35, 0.42, 0.84];
/// Faces whose normal has a smaller cosine with the direction to the camera are culled. The limit is below zero because refraction makes
/// rays steeper.
const CULLING_COSINE: f64 = -0.3;

/// The outer skin of a body.
pub struct Skin {
    /// Corners, as indices into `used`.
    triangles: Vec<[u32; 3]>,
    /// Nodes of the mesh that lie on the skin.
    used: Vec<u32>,
    /// Grey of each used node.
    grey: Vec<f32>,
    mirrored: bool,
}

/// A node of the skin.
struct Vertex {
    /// Positions at the three times of a frame, m.
    places: [Point3; 3],
    /// Of any length.
    normal: Point3,
    grey: f32,
}

impl Skin {
    /// The outer skin of `mesh`.
    pub fn new(mesh: &QuadraticMesh) -> Self {
        let outer: Vec<_> = mesh.skin.iter().filter(|f| f.on == On::Outer).collect();
        let mut used: Vec<u32> = outer.iter().flat_map(|f| f.nodes()).copied().collect();
        used.sort_unstable();
        used.dedup();
        let index_of_node = |node: u32| used.partition_point(|u| *u < node) as u32;
        let triangles = outer.iter().flat_map(|f| f.triangles()).map(|corners| corners.map(index_of_node)).collect();
        let grey = node_greys(mesh, &used);
        Self { triangles, used, grey, mirrored: mesh.half }
    }

    /// Nodes of the mesh that lie on the skin, ascending.
    pub(crate) fn skin_nodes(&self) -> &[u32] {
        &self.used
    }

    /// Draws the skin in a frame.
    pub fn draw_in_frame(&self, canvas: &mut Canvas, view: &View, motion: &FrameMotion) {
        let places = |node: &u32| [0, 1, 2].map(|k| motion.nodes[k][*node as usize]);
        let upper: Vec<[Point3; 3]> = self.used.iter().map(places).collect();
        let mut halves = vec![(upper, 1.0)];
        if self.mirrored {
            halves.push((halves[0].0.iter().map(|three| three.map(|[x, y, z]| [x, y, -z])).collect(), -1.0));
        }
        let visible = halves.iter().filter_map(|(half, turn)| self.facing_triangles(view, motion, half, *turn));
        let faces: Vec<[Corner; 3]> = visible.flatten().collect();
        let Some(mut samples) = Samples::around_corners(faces.iter().flatten()) else { return };
        faces.into_iter().for_each(|face| samples.draw_triangle(face));
        samples.blend_into(canvas);
    }

    /// The projected triangles that face the camera, shaded by their normals; `turn` is −1 for the mirror image, whose orientation is
    /// reversed.
    fn facing_triangles(
        &self,
        view: &View,
        motion: &FrameMotion,
        points: &[[Point3; 3]],
        turn: f64,
    ) -> Option<Vec<[Corner; 3]>> {
        let (mut normals, eye) = (vec![[0.0; 3]; points.len()], view.camera.centre_of_projection());
        let mut front = Vec::with_capacity(self.triangles.len());
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|k| points[k as usize][1]);
            let normal = vec3::scale(vec3::cross(vec3::sub(b, a), vec3::sub(c, a)), turn);
            triangle.iter().for_each(|k| normals[*k as usize] = vec3::add(normals[*k as usize], normal));
            let ray = vec3::sub(eye, a);
            if vec3::dot(normal, ray) > CULLING_COSINE * vec3::norm(normal) * vec3::norm(ray) {
                front.push(triangle);
            }
        }
        let mut corners: Vec<Option<Corner>> = vec![None; points.len()];
        for k in front.iter().flat_map(|t| t.iter()).map(|k| *k as usize) {
            if corners[k].is_none() {
                corners[k] = Some(Self::projected_corner(
                    view,
                    motion,
                    &Vertex { places: points[k], normal: normals[k], grey: self.grey[k] },
                )?);
            }
        }
        front
            .into_iter()
            .map(|t| Some([corners[t[0] as usize]?, corners[t[1] as usize]?, corners[t[2] as usize]?]))
            .collect()
    }

    /// A projected and shaded vertex.
    fn projected_corner(view: &View, motion: &FrameMotion, vertex: &Vertex) -> Option<Corner> {
        let Vertex { places, normal, grey } = *vertex;
        let (at, there) = view.project_skin(motion, places)?;
        let slant = vec3::dot(normal, SUN) / (vec3::norm(SUN) * vec3::norm(normal).max(1e-30));
        let lit = AMBIENT + (1.0 - AMBIENT) * slant.max(0.0);
        let scale = SAMPLES as f64;
        let at = [(at[0] + 0.5) * scale - 0.5, (at[1] + 0.5) * scale - 0.5];
        Some(Corner { at, depth: view.camera.depth_of_point(there), grey: grey * lit as f32 })
    }
}

/// Grey of each used node: silicone's where silicone touches it, else the sheet's.
fn node_greys(mesh: &QuadraticMesh, used: &[u32]) -> Vec<f32> {
    let mut silicone = vec![false; mesh.nodes.len()];
    for (nodes, _) in mesh.elements.iter().zip(&mesh.regions).filter(|(_, region)| **region != SPINE) {
        nodes.iter().for_each(|node| silicone[*node as usize] = true);
    }
    used.iter().map(|node| if silicone[*node as usize] { SILICONE } else { SHEET }).collect()
}
