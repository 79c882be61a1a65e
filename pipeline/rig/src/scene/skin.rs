//! The skin: the tail itself in the picture, lit from one side, by depth.
//!
//! The outer faces of the half mesh and their mirror images below are drawn as small triangles, four samples a pixel,
//! the nearest surface winning. The back is flat and catches the light; the sheet behind the silicone is white.
//!
//! Stands on: `shape` (the mesh's skin), the canvas, the camera. Never knows: what moves the skin.

use shape::{QuadraticMesh, SPINE, Skin as On};
use si::{Point2, Point3, vec3};

use super::Canvas;
use crate::camera::{Passing, View};

/// Samples along each side of a pixel.
const SAMPLES: usize = 2;
/// Grey of silicone and of the sheet, lit squarely, 0 to 255.
const SILICONE: f32 = 172.0;
const SHEET: f32 = 232.0;
/// Share of a surface's light that comes from everywhere.
const AMBIENT: f64 = 0.45;
/// Towards the lamp over the bench.
const SUN: Point3 = [-0.35, 0.42, 0.84];
/// A face whose normal leans away from the camera by more than this (cosine) is not drawn; water makes rays steeper, so
/// some that lean away a little are seen.
const AWAY: f64 = -0.3;

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
#[derive(Debug, Clone, Copy)]
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

    /// Nodes of the mesh that lie on the skin, rising.
    pub fn nodes(&self) -> &[u32] {
        &self.used
    }

    /// Draws the skin of the body as it passes in a frame.
    pub fn draw(&self, canvas: &mut Canvas, view: &View, by: &Passing) {
        let places = |node: &u32| [0, 1, 2].map(|k| by.nodes[k][*node as usize]);
        let upper: Vec<[Point3; 3]> = self.used.iter().map(places).collect();
        let mut halves = vec![(upper, 1.0)];
        if self.mirrored {
            halves.push((halves[0].0.iter().map(|three| three.map(|[x, y, z]| [x, y, -z])).collect(), -1.0));
        }
        let seen = halves.iter().filter_map(|(half, turn)| self.facing(view, by, half, *turn));
        let faces: Vec<[Corner; 3]> = seen.flatten().collect();
        let Some(mut samples) = Samples::around(faces.iter().flatten()) else { return };
        faces.into_iter().for_each(|face| samples.draw(face));
        samples.resolve(canvas);
    }

    /// The triangles that are turned towards the camera, in the picture, lit by their normals; `turn` is −1 for the mirror
    /// image, whose faces turn the other way.
    fn facing(&self, view: &View, by: &Passing, points: &[[Point3; 3]], turn: f64) -> Option<Vec<[Corner; 3]>> {
        let (mut upright, eye) = (vec![[0.0; 3]; points.len()], view.camera.eye());
        let mut front = Vec::with_capacity(self.triangles.len());
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|k| points[k as usize][1]);
            let normal = vec3::scale(vec3::cross(vec3::sub(b, a), vec3::sub(c, a)), turn);
            triangle.iter().for_each(|k| upright[*k as usize] = vec3::add(upright[*k as usize], normal));
            let ray = vec3::sub(eye, a);
            if vec3::dot(normal, ray) > AWAY * vec3::norm(normal) * vec3::norm(ray) {
                front.push(triangle);
            }
        }
        let mut known: Vec<Option<Corner>> = vec![None; points.len()];
        for k in front.iter().flat_map(|t| t.iter()).map(|k| *k as usize) {
            if known[k].is_none() {
                known[k] = Some(self.corner(view, by, points[k], upright[k], self.grey[k])?);
            }
        }
        front.into_iter().map(|t| Some([known[t[0] as usize]?, known[t[1] as usize]?, known[t[2] as usize]?])).collect()
    }

    /// A node in the picture, lit by the normal `upright` of any length.
    fn corner(&self, view: &View, by: &Passing, places: [Point3; 3], upright: Point3, grey: f32) -> Option<Corner> {
        let (at, there) = view.glimpse(by, places)?;
        let slant = vec3::dot(upright, SUN) / (vec3::norm(SUN) * vec3::norm(upright).max(1e-30));
        let lit = AMBIENT + (1.0 - AMBIENT) * slant.max(0.0);
        let scale = SAMPLES as f64;
        let at = [(at[0] + 0.5) * scale - 0.5, (at[1] + 0.5) * scale - 0.5];
        Some(Corner { at, depth: view.camera.depth(there), grey: grey * lit as f32 })
    }
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

    /// Draws one triangle where it is nearest, row by row; it may turn either way.
    fn draw(&mut self, [a, b, c]: [Corner; 3]) {
        let [p, q] = [b, c].map(|v| [v.at[0] - a.at[0], v.at[1] - a.at[1]]);
        let area = p[0] * q[1] - p[1] * q[0];
        if area.abs() < 1e-12 {
            return;
        }
        // a value that is linear over the triangle grows by this much a column and a row
        let rise = |u: f64, v: f64| [(u * q[1] - v * p[1]) / area, (v * p[0] - u * q[0]) / area];
        let depth = rise(b.depth - a.depth, c.depth - a.depth);
        let grey = rise(f64::from(b.grey - a.grey), f64::from(c.grey - a.grey));
        let edges = [(a, b), (b, c), (c, a)].map(|(from, to)| Edge::between(from.at, to.at));
        let (low, high) = (a.at[1].min(b.at[1]).min(c.at[1]), a.at[1].max(b.at[1]).max(c.at[1]));
        for row in up(low)..=down(high) {
            let (first, last) = crossed(&edges, row as f64);
            if last < first {
                continue;
            }
            let off = [first as f64 - a.at[0], row as f64 - a.at[1]];
            let here = (row - self.corner[1]) as usize * self.size[0] + (first - self.corner[0]) as usize;
            let start = (a.depth + depth[0] * off[0] + depth[1] * off[1]) as f32;
            let level = a.grey + (grey[0] * off[0] + grey[1] * off[1]) as f32;
            let count = (last - first + 1) as usize;
            let nearest = self.depth[here..here + count].iter_mut().zip(&mut self.grey[here..here + count]);
            for (k, (nearest, seen)) in nearest.enumerate() {
                let depth = start + depth[0] as f32 * k as f32;
                if depth < *nearest {
                    *nearest = depth;
                    *seen = level + grey[0] as f32 * k as f32;
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

/// An edge of a triangle, ready to be crossed row by row.
#[derive(Clone, Copy)]
struct Edge {
    rows: [f64; 2],
    /// Column at row 0, and columns a row.
    line: [f64; 2],
}

impl Edge {
    /// None along a row: its ends are those of the other two.
    fn between([x, y]: Point2, [u, v]: Point2) -> Option<Self> {
        let slope = (u - x) / (v - y);
        slope.is_finite().then(|| Self { rows: [y.min(v), y.max(v)], line: [x - slope * y, slope] })
    }
}

/// First and last whole column inside a triangle on a row; the last is before the first where there is none.
fn crossed(edges: &[Option<Edge>; 3], row: f64) -> (i64, i64) {
    let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
    for edge in edges.iter().flatten().filter(|e| e.rows[0] <= row && row <= e.rows[1]) {
        let at = edge.line[0] + edge.line[1] * row;
        (left, right) = (left.min(at), right.max(at));
    }
    if left <= right { (up(left), down(right)) } else { (0, -1) }
}

/// ⌈x⌉ and ⌊x⌋ without a call: there are millions.
fn up(x: f64) -> i64 {
    let whole = x as i64;
    whole + i64::from(x > whole as f64)
}

fn down(x: f64) -> i64 {
    let whole = x as i64;
    whole - i64::from(x < whole as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_is_filled_with_its_area_and_its_slope_of_grey() {
        let corner = |x: f64, y: f64| Corner { at: [x, y], depth: 0.1, grey: (2.0 * x + 3.0 * y) as f32 };
        let face = [corner(3.2, 4.1), corner(81.7, 20.4), corner(30.5, 66.9)];
        let mut samples = Samples::around(face.iter()).unwrap();
        samples.draw(face);
        let [a, b, c] = face.map(|corner| corner.at);
        let area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
        let met: Vec<usize> = (0..samples.depth.len()).filter(|i| samples.depth[*i].is_finite()).collect();
        // as many samples as area, but for half a perimeter's worth of chance
        assert!((met.len() as f64 - area).abs() < 30.0, "{} {area}", met.len());
        for i in met {
            let (x, y) = (i % samples.size[0], i / samples.size[0]);
            let at = [(x as i64 + samples.corner[0]) as f64, (y as i64 + samples.corner[1]) as f64];
            assert!((f64::from(samples.grey[i]) - 2.0 * at[0] - 3.0 * at[1]).abs() < 1e-3);
        }
    }

    #[test]
    fn the_nearer_of_two_triangles_is_seen() {
        let face = |depth: f64, grey: f32| [[2.0, 2.0], [40.0, 3.0], [20.0, 30.0]].map(|at| Corner { at, depth, grey });
        for order in [[(0.2, 50.0), (0.1, 90.0)], [(0.1, 90.0), (0.2, 50.0)]] {
            let faces = order.map(|(depth, grey)| face(depth, grey));
            let mut samples = Samples::around(faces.iter().flatten()).unwrap();
            faces.into_iter().for_each(|face| samples.draw(face));
            assert!(samples.grey.iter().all(|grey| *grey == 0.0 || *grey == 90.0));
        }
    }
}
