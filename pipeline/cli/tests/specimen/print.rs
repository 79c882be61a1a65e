//! Prints of calibration boards, in poses before a camera of 384 px focal length and 320 × 240 px.

use track::Gray;

/// Width, height and focal length of the pictures, px.
const SIZE: [usize; 2] = [320, 240];
const FOCAL: f64 = 384.0;
/// Rays along each side of a pixel.
const FINE: usize = 3;

/// Tilts about the picture's axes (rad), roll (rad), and shift (px along the picture, and away from it) of a board.
pub type Posed = ([f64; 2], f64, [f64; 3]);

/// Poses in which a board is shown.
pub const POSES: usize = 12;

/// A board in a pose: `level` is that of the print at a place (px of the untilted picture from its middle, y down).
pub fn posed(level: &dyn Fn([f64; 2]) -> f64, pose: usize) -> Gray {
    let turn = pose as f64;
    let tilts = [0.45 * (1.3 * turn).sin(), 0.45 * (0.9 * turn + 0.5).cos()];
    let shift = [12.0 * (2.1 * turn).sin(), 9.0 * (1.7 * turn).cos(), 60.0 + 25.0 * (0.8 * turn).sin()];
    rendered(level, (tilts, 0.25 * (1.1 * turn).sin(), shift))
}

/// A board as a camera sees it.
pub fn rendered(level: &dyn Fn([f64; 2]) -> f64, ([a, b], roll, [x, y, away]): Posed) -> Gray {
    let (sin, cos) = ([a, b, roll].map(f64::sin), [a, b, roll].map(f64::cos));
    // columns of Rz Rx Ry: the print's axes and its normal before the camera
    let turned = |[u, v, w]: [f64; 3]| {
        let [u, w] = [cos[1] * u + sin[1] * w, cos[1] * w - sin[1] * u];
        let [v, w] = [cos[0] * v - sin[0] * w, sin[0] * v + cos[0] * w];
        [cos[2] * u - sin[2] * v, sin[2] * u + cos[2] * v, w]
    };
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(turned);
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let middle = [x, y, FOCAL + away];
    let seen = |u: f64, v: f64| {
        let ray = [(u - 159.5) / FOCAL, (v - 119.5) / FOCAL, 1.0];
        let reach = dot(axes[2], middle) / dot(axes[2], ray);
        let on_print = [0, 1, 2].map(|k| reach * ray[k] - middle[k]);
        level([dot(axes[0], on_print), dot(axes[1], on_print)])
    };
    Gray::from_fn(SIZE[0], SIZE[1], |u, v| {
        let offset = |k: usize| (k as f64 + 0.5) / FINE as f64 - 0.5;
        let rays = (0..FINE * FINE).map(|k| seen(u as f64 + offset(k % FINE), v as f64 + offset(k / FINE)));
        rays.sum::<f64>() / (FINE * FINE) as f64
    })
}

/// Squares of `side` px, the upper left one black, on a white sheet.
pub fn checkerboard([columns, rows]: [usize; 2], side: f64, [x, y]: [f64; 2]) -> f64 {
    let [i, j] = [x / side + 0.5 * columns as f64, y / side + 0.5 * rows as f64];
    let is_inside = (0.0..columns as f64).contains(&i) && (0.0..rows as f64).contains(&j);
    if is_inside && (i as usize + j as usize).is_multiple_of(2) { 30.0 } else { 220.0 }
}
