//! A checkerboard is found in pictures as a camera takes them: tilted, distorted, blurred and noisy.

#![allow(clippy::unwrap_used)]

mod noise;

use noise::Noise;
use si::Point2;
use track::Gray;
use track::board::{Board, BoardError, find};
use track::lens::{Distortion, Lens};
use track::pose::Pose;
use track::refraction::RefractiveCamera;

const BOARD: Board = Board { columns: 9, rows: 6, square: 0.02 };
const LENS: Lens = Lens {
    fx: 900.0,
    fy: 905.0,
    cx: 645.0,
    cy: 355.0,
    k1: -0.12,
    k2: 0.04,
    p1: 4e-4,
    p2: -3e-4,
    k3: 0.0,
    k4: 0.0,
    distortion: Distortion::BrownConrady,
};
const SIZE: (usize, usize) = (1280, 720);
/// Samples along each side of a pixel.
const FINE: usize = 8;

/// A camera above the board that looks at its middle from `far` (m), tilted by `tilt` towards `around`, rolled by `roll` (rad).
fn above(tilt: f64, around: f64, roll: f64, far: f64, aside: Point2) -> Pose {
    let product = |a: [[f64; 3]; 3], b: [[f64; 3]; 3]| {
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
    };
    let turn = |v| Pose::from_vector(v, [0.0; 3]).rotation;
    let down = turn([std::f64::consts::PI, 0.0, 0.0]);
    let rotation =
        product(turn([tilt * around.cos(), tilt * around.sin(), 0.0]), product(turn([0.0, 0.0, roll]), down));
    let middle = Pose { rotation, translation: [0.0; 3] }.apply([0.07, 0.04, 0.0]);
    Pose { rotation, translation: [aside[0] - middle[0], aside[1] - middle[1], far - middle[2]] }
}

/// The board as the camera sees it: light ground, a wooden table around it, levels softened by `FINE`² rays a pixel.
fn render(board: &Board, pose: &Pose, seed: u64, noise: f64) -> Gray {
    let mut random = Noise(seed);
    let sight = RefractiveCamera { lens: LENS, pose: *pose, water: None };
    let intersect = |i: usize| sight.intersect([(i % (SIZE.0 + 1)) as f64, (i / (SIZE.0 + 1)) as f64], 0.0).unwrap();
    let grid: Vec<Point2> = (0..(SIZE.0 + 1) * (SIZE.1 + 1)).map(intersect).collect();
    // where the pixel's middle lies on the board, and what a pixel to the right and one down add
    let met = |x: usize, y: usize| {
        let at = |i: usize, j: usize| grid[(y + j) * (SIZE.0 + 1) + x + i];
        let step = |to: Point2| [to[0] - at(0, 0)[0], to[1] - at(0, 0)[1]];
        [at(0, 0), step(at(1, 0)), step(at(0, 1))]
    };
    Gray::from_fn(SIZE.0, SIZE.1, |x, y| {
        let offset = |k: usize| (k as f64 + 0.5) / FINE as f64 - 0.5;
        let [[u, v], [a, c], [b, d]] = met(x, y);
        let level = |[i, j]: Point2| paint(board, [u + a * i + b * j, v + c * i + d * j]);
        let corners = [[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]].map(level);
        let edge = corners.iter().any(|c| (c - corners[0]).abs() > 50.0);
        let rays = (0..FINE * FINE).map(|k| level([offset(k % FINE), offset(k / FINE)]));
        let light = if edge { rays.sum::<f64>() / (FINE * FINE) as f64 } else { corners.iter().sum::<f64>() / 4.0 };
        light + noise * random.next()
    })
}

/// The level of the world's plane at (x, y), m.
fn paint(board: &Board, [x, y]: Point2) -> f64 {
    let (u, v) = (x / board.square + 1.0, y / board.square + 1.0);
    let inside = |margin: f64| {
        (-margin..board.columns as f64 + margin).contains(&u) && (-margin..board.rows as f64 + margin).contains(&v)
    };
    if inside(0.0) {
        return if (u.floor() + v.floor()) as i64 % 2 == 0 { 35.0 } else { 215.0 };
    }
    if inside(0.7) { 220.0 } else { 110.0 + 25.0 * (300.0 * x + 40.0 * (90.0 * y).sin()).sin() }
}

/// Root of the mean squared distance between found corners and the truth, px.
fn miss(found: &[Point2], pose: &Pose) -> f64 {
    let truth = BOARD.corner_points().into_iter().map(|c| LENS.project(pose.apply(c)).unwrap());
    let squares: f64 = truth.zip(found).map(|(t, f)| (t[0] - f[0]).powi(2) + (t[1] - f[1]).powi(2)).sum();
    (squares / found.len() as f64).sqrt()
}

fn blurred(picture: &Gray, passes: usize) -> Gray {
    (0..passes).fold(picture.clone(), |p, _| {
        let level = |x: usize, y: usize| p.interpolated_level([x as f64, y as f64]);
        let near = |c: usize, d: usize, n: usize| (c + d).saturating_sub(1).min(n - 1);
        Gray::from_fn(p.width, p.height, |x, y| {
            (0..9).map(|k| level(near(x, k % 3, p.width), near(y, k / 3, p.height))).sum::<f64>() / 9.0
        })
    })
}

#[test]
fn a_board_is_found_to_a_twentieth_of_a_pixel_at_every_tilt_and_turn() {
    for k in 0..8_u32 {
        let turn = f64::from(k);
        let tilt = [0.0, 0.25, 0.45, 0.61][k as usize % 4];
        let pose =
            above(tilt, 1.3 * turn, 0.1 + 0.55 * turn, 0.30 + 0.03 * turn, [0.03 * turn.sin(), 0.02 * turn.cos()]);
        let found = find(&render(&BOARD, &pose, u64::from(7 + k), 2.0), &BOARD).unwrap_or_else(|e| panic!("{k}: {e}"));
        let miss = miss(&found, &pose);
        assert!(miss < 0.05, "view {k}: {miss} px");
    }
}

#[test]
fn a_board_upside_down_gives_the_same_corners_in_the_same_order() {
    for roll in [0.2, 0.2 + std::f64::consts::PI] {
        let pose = above(0.3, 0.5, roll, 0.35, [0.0, 0.0]);
        let found = find(&render(&BOARD, &pose, 3, 1.0), &BOARD).unwrap();
        assert!(miss(&found, &pose) < 0.05);
    }
}

#[test]
fn a_board_out_of_focus_is_found_too() {
    let pose = above(0.3, 1.0, 0.3, 0.32, [0.0, 0.0]);
    let picture = blurred(&render(&BOARD, &pose, 3, 2.0), 12);
    assert!(miss(&find(&picture, &BOARD).unwrap(), &pose) < 0.1);
}

#[test]
fn a_small_and_noisy_board_in_a_corner_is_found_too() {
    let pose = above(0.4, 2.0, -0.4, 0.80, [-0.30, 0.15]);
    let found = find(&render(&BOARD, &pose, 11, 5.0), &BOARD).unwrap();
    assert!(miss(&found, &pose) < 0.15, "{}", miss(&found, &pose));
}

#[test]
fn a_board_half_outside_is_refused_with_the_number_of_corners_seen() {
    let pose = above(0.1, 0.0, 0.0, 0.3, [0.16, 0.0]);
    let error = find(&render(&BOARD, &pose, 1, 1.0), &BOARD).unwrap_err();
    assert!(matches!(error, BoardError::NotFound { in_grid: 8..=39, expected: 40, .. }), "{error}");
}

#[test]
fn a_board_of_another_size_is_refused() {
    let pose = above(0.2, 0.0, 0.0, 0.35, [0.0, 0.0]);
    let other = Board { columns: 7, rows: 6, square: 0.02 };
    let picture = render(&BOARD, &pose, 1, 1.0);
    let error = find(&picture, &other).unwrap_err();
    assert!(matches!(error, BoardError::NotFound { in_grid: 40, expected: 30, .. }));
    assert!(error.to_string().contains("a grid of 40 inner corners was seen where such a board has 30"), "{error}");
}

#[test]
fn a_picture_without_a_board_is_refused() {
    let table = Gray::from_fn(640, 360, |x, y| 110.0 + 60.0 * ((x as f64 * 0.2).sin() * (y as f64 * 0.13).cos()));
    assert!(matches!(find(&table, &BOARD), Err(BoardError::NotFound { .. })));
    assert!(matches!(
        find(&Gray::filled(640, 360, 128), &BOARD),
        Err(BoardError::NotFound { in_grid: 0, seen: 0, .. })
    ));
}

#[test]
fn a_board_that_looks_the_same_upside_down_is_refused() {
    let even = Board { columns: 8, rows: 6, square: 0.02 };
    assert!(matches!(find(&Gray::filled(64, 64, 0), &even), Err(BoardError::Ambiguous { columns: 8, rows: 6 })));
}
