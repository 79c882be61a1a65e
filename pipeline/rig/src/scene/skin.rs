//! The skin: the tail itself in the picture, lit from one side, by depth.
//!
//! The outer faces of the half mesh and their mirror images below are drawn as small triangles, four samples a pixel,
//! the nearest surface winning. The back is flat and catches the light; the sheet behind the silicone is white.
//!
//! Stands on: `shape` (the mesh's skin), the canvas, the camera. Never knows: what moves the skin.

use shape::{QuadraticMesh, SPINE, Skin as On};
use si::{Point2, Point3, vec3};

use super::Canvas;
use crate::camera::Camera;

/// Samples along each side of a pixel.
const SAMPLES: usize = 2;
/// Grey of silicone and of the sheet, lit squarely, 0 to 255.
const SILICONE: f32 = 172.0;
const SHEET: f32 = 232.0;
/// Share of a surface's light that comes from everywhere.
const AMBIENT: f64 = 0.45;
/// Towards the lamp over the bench.
const SUN: Point3 = [-0.35, 0.42, 0.84];
/// The outer skin of a body, ready to be drawn in any shape.
pub struct Skin {
    /// Corners in `used`, as places in it.
    triangles: Vec<[u32; 3]>,
    /// Nodes of the mesh that lie on the skin.
    used: Vec<u32>,
    /// Grey of each used node.
    grey: Vec<f32>,
    mirrored: bool,
}

/// A corner in the picture: sample coordinates, depth (m) and grey.
#[derive(Clone, Copy)]
struct Corner {
    at: Point2,
    depth: f64,
    grey: f32,
}

/// Samples of a part of the picture.
struct Samples {
    corner: [i64; 2],
    size: [usize; 2],
    depth: Vec<f32>,
    grey: Vec<f32>,
}

impl Skin {
    /// The outer skin of `mesh`.
    pub fn new(mesh: &QuadraticMesh) -> Self {
        let outer: Vec<[u32; 6]> = mesh.skin.iter().filter(|f| f.on == On::Outer).map(|f| f.nodes).collect();
        let mut used: Vec<u32> = outer.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let place = |node: u32| used.partition_point(|u| *u < node) as u32;
        let split = |f: &[u32; 6]| {
            let [a, b, c, ab, bc, ca] = f.map(place);
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        let triangles: Vec<[u32; 3]> = outer.iter().flat_map(split).collect();
        let grey = greys(mesh, &used);
        Self { triangles, used, grey, mirrored: mesh.half }
    }

    /// Draws the skin of the body whose nodes are at `nodes` (m).
    pub fn draw(&self, canvas: &mut Canvas, camera: &Camera, nodes: &[Point3]) {
        let upper: Vec<Point3> = self.used.iter().map(|node| nodes[*node as usize]).collect();
        let lower: Vec<Point3> = upper.iter().map(|[x, y, z]| [*x, *y, -z]).collect();
        let halves = if self.mirrored { vec![(upper, 1.0), (lower, -1.0)] } else { vec![(upper, 1.0)] };
        let lit: Vec<(Vec<Corner>, f64)> =
            halves.iter().filter_map(|(half, turn)| Some((self.corners(camera, half, *turn)?, *turn))).collect();
        let Some(mut samples) = Samples::around(lit.iter().flat_map(|(corners, _)| corners)) else { return };
        for (corners, _) in &lit {
            for triangle in &self.triangles {
                samples.draw(triangle.map(|k| corners[k as usize]));
            }
        }
        samples.resolve(canvas);
    }

    /// Every used node in the picture, lit by its normal; `turn` is −1 for the mirror image, whose faces turn the other way.
    fn corners(&self, camera: &Camera, points: &[Point3], turn: f64) -> Option<Vec<Corner>> {
        let normals = normals(points, &self.triangles);
        let sun = vec3::scale(SUN, turn / vec3::norm(SUN));
        let corner = |i: usize| {
            let at = camera.pixel(points[i])?;
            let lit = AMBIENT + (1.0 - AMBIENT) * vec3::dot(normals[i], sun).max(0.0);
            let scale = SAMPLES as f64;
            let at = [(at[0] + 0.5) * scale - 0.5, (at[1] + 0.5) * scale - 0.5];
            Some(Corner { at, depth: camera.depth(points[i]), grey: self.grey[i] * lit as f32 })
        };
        (0..points.len()).map(corner).collect()
    }
}

/// Unit normals at points, from the triangles around them weighted by area.
fn normals(points: &[Point3], triangles: &[[u32; 3]]) -> Vec<Point3> {
    let mut sums = vec![[0.0; 3]; points.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|k| points[k as usize]);
        let normal = vec3::cross(vec3::sub(b, a), vec3::sub(c, a));
        for k in triangle {
            sums[*k as usize] = vec3::add(sums[*k as usize], normal);
        }
    }
    sums.into_iter().map(|n| vec3::scale(n, 1.0 / vec3::norm(n).max(1e-30))).collect()
}

/// Grey of each used node: silicone's where silicone touches it, else the sheet's.
fn greys(mesh: &QuadraticMesh, used: &[u32]) -> Vec<f32> {
    let mut silicone = vec![false; mesh.nodes.len()];
    for (tet, _) in mesh.tets.iter().zip(&mesh.regions).filter(|(_, region)| **region != SPINE) {
        tet.iter().for_each(|node| silicone[*node as usize] = true);
    }
    used.iter().map(|node| if silicone[*node as usize] { SILICONE } else { SHEET }).collect()
}

impl Samples {
    /// Empty samples over the box around `corners`.
    fn around<'a>(corners: impl Iterator<Item = &'a Corner> + Clone) -> Option<Self> {
        let end = |k: usize, start: f64, pick: fn(f64, f64) -> f64| corners.clone().map(|c| c.at[k]).fold(start, pick);
        let low = [0, 1].map(|k| end(k, f64::INFINITY, f64::min));
        let high = [0, 1].map(|k| end(k, f64::NEG_INFINITY, f64::max));
        if !low.iter().chain(&high).all(|x| x.abs() < 20_000.0) {
            return None;
        }
        let step = SAMPLES as i64;
        let corner = low.map(|x| (x.floor() as i64).div_euclid(step) * step);
        let size = [0, 1].map(|k| ((high[k].ceil() as i64 - corner[k]) / step + 1) as usize * SAMPLES);
        let count = size[0] * size[1];
        Some(Self { corner, size, depth: vec![f32::INFINITY; count], grey: vec![0.0; count] })
    }

    /// Draws one triangle where it is nearest; it may turn either way.
    fn draw(&mut self, [a, b, c]: [Corner; 3]) {
        let area = (b.at[0] - a.at[0]) * (c.at[1] - a.at[1]) - (b.at[1] - a.at[1]) * (c.at[0] - a.at[0]);
        if area.abs() < 1e-12 {
            return;
        }
        let span = |k: usize| {
            let low = a.at[k].min(b.at[k]).min(c.at[k]).ceil() as i64;
            let high = a.at[k].max(b.at[k]).max(c.at[k]).floor() as i64;
            low - self.corner[k]..=high - self.corner[k]
        };
        let (columns, rows) = (span(0), span(1));
        for row in rows {
            for column in columns.clone() {
                let p = [(column + self.corner[0]) as f64, (row + self.corner[1]) as f64];
                let weight = |u: &Corner, v: &Corner| {
                    ((u.at[0] - p[0]) * (v.at[1] - p[1]) - (u.at[1] - p[1]) * (v.at[0] - p[0])) / area
                };
                let (wa, wb, wc) = (weight(&b, &c), weight(&c, &a), weight(&a, &b));
                if wa >= 0.0 && wb >= 0.0 && wc >= 0.0 {
                    let depth = (wa * a.depth + wb * b.depth + wc * c.depth) as f32;
                    let here = row as usize * self.size[0] + column as usize;
                    if depth < self.depth[here] {
                        self.depth[here] = depth;
                        self.grey[here] = wa as f32 * a.grey + wb as f32 * b.grey + wc as f32 * c.grey;
                    }
                }
            }
        }
    }

    /// Blends the samples into the canvas, each pixel by the share of its samples that were met.
    fn resolve(&self, canvas: &mut Canvas) {
        let each = (SAMPLES * SAMPLES) as f32;
        for row in (0..self.size[1]).step_by(SAMPLES) {
            for column in (0..self.size[0]).step_by(SAMPLES) {
                let places = (0..SAMPLES * SAMPLES)
                    .map(|k| (row + k / SAMPLES) * self.size[0] + column + k % SAMPLES)
                    .filter(|i| self.depth[*i].is_finite());
                let (sum, met) = places.fold((0.0, 0.0), |(sum, met), i| (sum + self.grey[i], met + 1.0));
                if met > 0.0 {
                    let at = [0, 1].map(|k| (self.corner[k] + [column, row][k] as i64).div_euclid(SAMPLES as i64));
                    canvas.blend(at[0], at[1], sum / met, met / each);
                }
            }
        }
    }
}
