//! Drawn shapes by the general method: unions and differences of tori, boxes, helices and spheres, with noise and slits. Nearly all are
//! meshed, none wrongly in silence.
#![allow(clippy::unwrap_used)] // a panic fails the test

use std::f64::consts::TAU;

use mesh::{Assembly, Method, Settings, Surface, mesh_assembly};
use si::Point3;
use tetrahedralize::Winding;

/// The seed of the first shape; each has its own.
const SEED: u64 = 66;
/// Cells along the longest side, by which volumes are counted.
const CELLS: u32 = 40;

/// Numbers of a seed, between 0 and 1.
struct Draw(u64);

impl Draw {
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((mixed ^ mixed >> 31) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.number()
    }

    fn point(&mut self, size: f64) -> Point3 {
        [(); 3].map(|()| self.between(-size, size))
    }
}

/// Rows of points around a closed line, joined to a tube whose ends are joined to each other, or closed.
fn tube([rows, columns]: [u32; 2], closed: bool, place: impl Fn(f64, f64) -> Point3) -> Surface {
    let last = if closed { rows } else { rows - 1 };
    let share = |i: u32| f64::from(i) / f64::from(last);
    let grid = (0..rows).flat_map(|i| (0..columns).map(move |j| [i, j]));
    let mut points: Vec<Point3> = grid.map(|[i, j]| place(share(i), TAU * f64::from(j) / f64::from(columns))).collect();
    let number = |i: u32, j: u32| (i % rows) * columns + j % columns;
    let quads = (0..last).flat_map(|i| (0..columns).map(move |j| [i, j]));
    let halves = |[i, j]: [u32; 2]| {
        let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    let mut faces: Vec<[u32; 3]> = quads.flat_map(halves).collect();
    for (row, first) in [(0, true), (rows - 1, false)].into_iter().filter(|_| !closed) {
        let ring = || (0..columns).map(|j| points[number(row, j) as usize]);
        let middle = [0, 1, 2].map(|k| ring().map(|p| p[k]).sum::<f64>() / f64::from(columns));
        let tip = points.len() as u32;
        faces.extend((0..columns).map(|j| {
            let [p, q] = [number(row, j), number(row, j + 1)];
            if first { [tip, p, q] } else { [tip, q, p] }
        }));
        points.push(middle);
    }
    outwards(Surface { points, faces })
}

fn outwards(mut surface: Surface) -> Surface {
    if surface.volume() < 0.0 {
        surface.faces.iter_mut().for_each(|f| f.swap(1, 2));
    }
    surface
}

fn shape(draw: &mut Draw) -> Surface {
    let (size, centre) = (draw.between(6e-3, 14e-3), draw.point(8e-3));
    let about = |[x, y, z]: Point3| [centre[0] + x, centre[1] + y, centre[2] + z];
    match (draw.number() * 4.0) as u32 {
        0 => {
            let small = size * draw.between(0.25, 0.45);
            tube([24, 12], true, |s, v| {
                let (radius, u) = (size + small * v.cos(), TAU * s);
                about([radius * u.cos(), radius * u.sin(), small * v.sin()])
            })
        }
        1 => tube([9, 14], false, |s, v| {
            let polar = 0.15 + s * (TAU / 2.0 - 0.3);
            about([size * polar.sin() * v.cos(), size * polar.sin() * v.sin(), size * polar.cos()])
        }),
        2 => {
            let turns = draw.between(0.8, 1.6);
            tube([40, 10], false, |s, v| {
                let (u, radius) = (TAU * turns * s, size * (1.0 + 0.22 * v.cos()));
                about([radius * u.cos(), radius * u.sin(), size * (1.4 * s + 0.22 * v.sin())])
            })
        }
        _ => {
            let sides = [(); 3].map(|()| size * draw.between(0.4, 1.2));
            tube([2, 4], false, |s, v| {
                let (x, y) = ((v + TAU / 8.0).cos(), (v + TAU / 8.0).sin());
                about([sides[0] * x * 1.4, sides[1] * y * 1.4, sides[2] * (2.0 * s - 1.0)])
            })
        }
    }
}

/// Adds a shape to others, or its inside to the surroundings.
fn add_shape(all: &mut Surface, shape: Surface) {
    let first = all.points.len() as u32;
    all.points.extend(shape.points);
    all.faces.extend(shape.faces.into_iter().map(|f| f.map(|n| n + first)));
}

/// A body of one to three shapes, noisy or slit or neither, and a cavity or none.
fn body(seed: u64) -> (Surface, Option<Surface>) {
    let mut draw = Draw(seed);
    let mut body = Surface::default();
    for _ in 0..1 + (draw.number() * 3.0) as u32 {
        add_shape(&mut body, shape(&mut draw));
    }
    match (draw.number() * 4.0) as u32 {
        0 => body.points.iter_mut().for_each(|p| *p = [0, 1, 2].map(|k| p[k] + draw.between(-1e-4, 1e-4))),
        // a slit: a face is missing
        1 if body.faces.len() > 200 => drop(body.faces.remove((draw.number() * body.faces.len() as f64) as usize)),
        _ => {}
    }
    let cavity = (draw.number() < 0.4).then(|| shape(&mut draw));
    (body, cavity)
}

fn winding(surface: &Surface) -> Winding {
    Winding::new(&(0..surface.faces.len()).map(|f| surface.corners(f)).collect::<Vec<_>>())
}

/// The volume within the body and out of the cavity, counted by cells, m³, and the side of a cell, m; what lies within more shapes than `most`
/// is no part of the body.
fn counted(body: &Surface, cavity: Option<&Surface>, most: f64) -> (f64, f64) {
    let (low, _) = body.bounds();
    let cell = body.length() / f64::from(CELLS);
    let (solid, void) = (winding(body), cavity.map(winding));
    let axis = |k: usize, i: u32| low[k] + cell * (f64::from(i) + 0.5);
    let within = |place: Point3| {
        (0.5..most + 0.5).contains(&solid.number_at(place)) && void.as_ref().is_none_or(|v| v.number_at(place) <= 0.5)
    };
    let cells = (0..CELLS.pow(3)).map(|n| [axis(0, n % CELLS), axis(1, n / CELLS % CELLS), axis(2, n / CELLS / CELLS)]);
    (cells.filter(|place| within(*place)).count() as f64 * cell.powi(3), cell)
}

/// Meshes a shape; whether it was meshed.
fn is_meshed(seed: u64) -> bool {
    let (body, cavity) = body(seed);
    let edge = body.length() / 5.0;
    let parts = Assembly { body: &body, inserts: Vec::new(), cavities: cavity.iter().collect() };
    let set = Settings { method: Method::General, ..Settings::new(edge) };
    let outcome = mesh_assembly(&parts, &set, &|_| ());
    match outcome {
        Ok(chosen) => {
            // a shape wholly within another is taken for a cavity, and said to be one
            let is_cavity = |repair: &String| repair.ends_with("was taken for a cavity");
            let most = if chosen.report.repairs.iter().any(is_cavity) { 1.0 } else { f64::INFINITY };
            let (expected, cell) = counted(&body, cavity.as_ref(), most);
            let mesh = chosen.solid.into_corners();
            let volume: f64 = (0..mesh.tets.len()).map(|tet| mesh.volume(tet)).sum();
            // cells on the surface are within or not by chance: a tenth of a cell on all of it, and what a slit leaves open
            let allowed = 0.1 * cell * body.area() + 0.01 * expected;
            assert!((volume - expected).abs() < allowed, "seed {seed}: {volume:e} m³, {expected:e} m³ counted");
            true
        }
        Err(why) => {
            assert!(why.to_string().contains(" mm"), "seed {seed}: a refusal without a place: {why}");
            eprintln!("seed {seed}: {why}");
            false
        }
    }
}

/// Shapes that are drawn where `DRAWN_SHAPES` says no other number, from the one that `DRAWN_FIRST` says; two hundred take twenty minutes of one core.
const SHAPES: u64 = 5;
/// Shapes that were refused once: a slit wider than a quarter of the body, flat elements on the face of a box (two), a shape within another.
const HARD: [u64; 4] = [11, 64, 74, 78];

fn number_from(variable: &str) -> Option<u64> {
    std::env::var(variable).ok()?.parse().ok()
}

#[test]
fn of_drawn_shapes_at_most_two_in_a_hundred_are_refused() {
    let (first, count) = (number_from("DRAWN_FIRST").unwrap_or(0), number_from("DRAWN_SHAPES").unwrap_or(SHAPES));
    let refused = (first..first + count).filter(|number| !is_meshed(SEED + number)).count() as u64;
    assert!(50 * refused <= count, "{refused} of {count}");
}

#[test]
fn shapes_that_were_refused_once_are_meshed() {
    let refused: Vec<u64> = HARD.into_iter().filter(|number| !is_meshed(SEED + number)).collect();
    assert!(refused.is_empty(), "{refused:?}");
}
