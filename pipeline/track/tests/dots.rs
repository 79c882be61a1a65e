//! A board of dots is found in pictures as a camera takes them, and a lens comes out of them.

#![allow(clippy::unwrap_used)] // a test may unwrap

mod noise;

use noise::Noise;
use si::Point2;
use track::Gray;
use track::board::asymmetric::{self, AsymmetricDots};
use track::board::dots::{Dots, find};
use track::board::{BoardError, Target};
use track::calibrate::{View, calibrate};
use track::lens::{Distortion, Lens};
use track::pose::Pose;
use track::refraction::RefractiveCamera;

const BOARD: Dots = Dots { columns: 9, rows: 6, pitch: 0.016 };
/// Of a dot, m.
const RADIUS: f64 = 0.004;
const SIZE: (usize, usize) = (800, 600);
const LENS: Lens = Lens {
    fx: 760.0,
    fy: 764.0,
    cx: 405.0,
    cy: 292.0,
    k1: -0.1,
    k2: 0.03,
    p1: 3e-4,
    p2: -2e-4,
    k3: 0.0,
    k4: 0.0,
    distortion: Distortion::BrownConrady,
};

/// A camera over the board's middle, tilted by `tilt` towards `around`, rolled by `roll` (rad), `far` away (m).
fn above(tilt: f64, around: f64, roll: f64, far: f64) -> Pose {
    let product = |a: [[f64; 3]; 3], b: [[f64; 3]; 3]| {
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
    };
    let turn = |v| Pose::from_vector(v, [0.0; 3]).rotation;
    let down = turn([std::f64::consts::PI, 0.0, 0.0]);
    let tilted = turn([tilt * around.cos(), tilt * around.sin(), 0.0]);
    let rotation = product(tilted, product(turn([0.0, 0.0, roll]), down));
    let middle = Pose { rotation, translation: [0.0; 3] }.apply([0.064, 0.04, 0.0]);
    let aside = [0.02 * around.sin(), 0.015 * around.cos()];
    Pose { rotation, translation: [aside[0] - middle[0], aside[1] - middle[1], far - middle[2]] }
}

/// The level of the board's plane at a place, m: dots on a white sheet on a grey table.
fn paint([x, y]: Point2) -> f64 {
    let (i, j) = ((x / BOARD.pitch).round(), (y / BOARD.pitch).round());
    let on_board = (0.0..=8.0).contains(&i) && (0.0..=5.0).contains(&j);
    let sheet = (-0.02..0.148).contains(&x) && (-0.02..0.1).contains(&y);
    match (x - i * BOARD.pitch).hypot(y - j * BOARD.pitch) < RADIUS {
        true if on_board => 40.0,
        _ if sheet => 205.0 + 150.0 * x,
        _ => 120.0,
    }
}

/// What the camera sees: 5 × 5 rays a pixel, and noise of 1.5 grey levels.
fn render(pose: &Pose, seed: u64) -> Gray {
    render_painted(pose, seed, paint)
}

fn render_painted(pose: &Pose, seed: u64, paint: fn(Point2) -> f64) -> Gray {
    let (mut random, fine) = (Noise(seed), 5);
    let sight = RefractiveCamera { lens: LENS, pose: *pose, water: None };
    Gray::from_fn(SIZE.0, SIZE.1, |x, y| {
        let at = |i: f64, j: f64| sight.intersect([x as f64 + i, y as f64 + j], 0.0).unwrap();
        let (o, a, b) = (at(0.0, 0.0), at(0.5, 0.0), at(0.0, 0.5));
        let ray = |k: usize| {
            let [i, j] = [k % fine, k / fine].map(|n| 2.0 * ((n as f64 + 0.5) / fine as f64 - 0.5));
            paint([0, 1].map(|d| o[d] + i * (a[d] - o[d]) + j * (b[d] - o[d])))
        };
        (0..fine * fine).map(ray).sum::<f64>() / (fine * fine) as f64 + 1.5 * random.next()
    })
}

/// Where the dots are, in the order that the board's rule gives them.
fn truth(pose: &Pose) -> Vec<Point2> {
    let mut all: Vec<Point2> = BOARD.points().iter().map(|p| LENS.project(pose.apply(*p)).unwrap()).collect();
    let corner = |p: &Point2| p[0] + p[1];
    if corner(all.last().unwrap()) < corner(&all[0]) {
        all.reverse();
    }
    all
}

fn poses() -> Vec<Pose> {
    let one = |k: u32| {
        let turn = f64::from(k);
        above([0.1, 0.35, 0.5][k as usize % 3], 0.9 * turn, 0.2 + 0.6 * turn, 0.22 + 0.01 * turn)
    };
    (0..9).map(one).collect()
}

#[test]
fn dots_are_found_to_a_tenth_of_a_pixel_in_one_order_and_give_the_lens_back() {
    let mut views = Vec::new();
    for (k, pose) in poses().iter().enumerate() {
        let found = find(&render(pose, 5 + k as u64), &BOARD).unwrap_or_else(|e| panic!("{k}: {e}"));
        let squares = found.iter().zip(truth(pose)).map(|(f, t)| (f[0] - t[0]).powi(2) + (f[1] - t[1]).powi(2));
        let miss = (squares.sum::<f64>() / found.len() as f64).sqrt();
        // of it, up to 0.05 px are what a tilted disc's middle is off
        assert!(miss < 0.1, "view {k}: {miss} px");
        views.push(View::of_whole_board(found));
    }
    let found = calibrate(&views, &Target::Dots(BOARD).points(), Distortion::BrownConrady, SIZE).unwrap();
    assert!((found.lens.fx / LENS.fx - 1.0).abs() < 5e-3, "{}", found.lens.fx);
    assert!(found.reprojection_px < 0.2, "{}", found.reprojection_px);
}

#[test]
fn another_number_of_dots_and_a_square_board_are_refused() {
    let picture = render(&above(0.2, 1.0, 0.3, 0.24), 1);
    let other = Dots { columns: 8, ..BOARD };
    assert!(matches!(find(&picture, &other), Err(BoardError::NoDots { in_grid: 54, .. })));
    for (columns, rows) in [(6, BOARD.rows), (2, 7), (7, 2)] {
        assert!(matches!(find(&picture, &Dots { columns, rows, ..BOARD }), Err(BoardError::Square { .. })));
    }
    let empty = Gray::filled(400, 300, 180);
    assert!(matches!(find(&empty, &BOARD), Err(BoardError::NoDots { in_grid: 0, seen: 0, .. })));
}

const SHIFTED: AsymmetricDots = AsymmetricDots { columns: 4, rows: 11, square: 0.01 };

/// Rows of four dots of 3.5 mm, every second one shifted, on a white sheet.
fn paint_shifted([x, y]: Point2) -> f64 {
    let near = |p: &[f64; 3]| (x - p[0]).hypot(y - p[1]) < 0.0035;
    if SHIFTED.points().iter().any(near) { 40.0 } else { 205.0 + 150.0 * x }
}

#[test]
fn the_dots_of_an_asymmetric_grid_are_found_in_its_one_order_whichever_way_it_is_turned() {
    for k in 0..6 {
        let turn = f64::from(k);
        let pose = above([0.1, 0.3, 0.45][k as usize % 3], 0.9 * turn, 1.05 * turn, 0.26);
        let dots = asymmetric::find(&render_painted(&pose, 40 + k as u64, paint_shifted), &SHIFTED).unwrap();
        let truth = SHIFTED.points().into_iter().map(|p| LENS.project(pose.apply(p)).unwrap());
        let miss = dots.iter().zip(truth).map(|(p, q)| (p[0] - q[0]).hypot(p[1] - q[1])).fold(0.0, f64::max);
        assert!(dots.len() == 44 && miss < 0.3, "view {k}: {miss} px");
    }
    let picture = render_painted(&above(0.2, 1.0, 0.3, 0.26), 1, paint_shifted);
    let other = AsymmetricDots { columns: 5, ..SHIFTED };
    assert!(matches!(asymmetric::find(&picture, &other), Err(BoardError::NoDots { in_grid: 44, .. })));
}
