//! The checkerboard in the camera's hand: its squares, its white margin, and the poses in which it is shown.
//!
//! Stands on: `track` (the board's layout), the canvas, the camera. Never knows: what a calibration makes of it.

use si::{Point3, Radian, vec3};
use track::board::Board;
use track::pose::Pose;

use super::Canvas;
use crate::camera::Camera;
use crate::draw::Draw;
use crate::settings;

/// Grey levels, 0 to 255.
const PAPER: f32 = 214.0;
const INK: f32 = 28.0;
/// White margin around the squares, in squares.
const MARGIN: f64 = 0.8;
/// Corners along a side of a square, so that the lens may bend it.
const BENDS: usize = 4;
/// A pose is shown when every corner of the paper lies this far inside the picture, px.
const INSIDE: f64 = 14.0;

/// Where the board is: board frame → CAD frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place(pub Pose);

/// The board of the settings.
pub fn layout(plane: &settings::Plane) -> Board {
    Board { columns: plane.columns, rows: plane.rows, square: plane.square }
}

/// The board flat on the plane, its corner (0, 0) where the settings lay it down, columns along x and rows along y.
pub fn flat(plane: &settings::Plane) -> Place {
    let [x, y] = plane.corner;
    Place(Pose { rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], translation: [x, y, plane.height] })
}

/// Draws the board.
pub fn draw(canvas: &mut Canvas, camera: &Camera, board: &Board, place: &Place) {
    fill(canvas, camera, board, place, paper(board), PAPER);
    for row in 0..board.rows {
        for column in (0..board.columns).filter(|column| board.black(*column, row)) {
            let (left, top) = (column as f64 - 1.0, row as f64 - 1.0);
            fill(canvas, camera, board, place, [left, top, left + 1.0, top + 1.0], INK);
        }
    }
}

/// `count` places that fill the picture between them, tilted every way, whole in the picture.
pub fn poses(camera: &Camera, board: &Board, count: usize, draw: &mut Draw) -> Vec<Place> {
    let mut places = Vec::with_capacity(count);
    while places.len() < count {
        let place = tilted(camera, board, places.len(), draw);
        if whole(camera, board, &place) {
            places.push(place);
        }
    }
    places
}

/// A place between two others: the shift in a straight line, the turn by its vector.
pub fn between(from: &Place, to: &Place, share: f64) -> Place {
    let mix = |a: Point3, b: Point3| vec3::add(vec3::scale(a, 1.0 - share), vec3::scale(b, share));
    Place(Pose::from_vector(mix(from.0.turn(), to.0.turn()), mix(from.0.translation, to.0.translation)))
}

/// Place `index`: its middle wanders over nine fields of the picture, its tilt over the directions.
fn tilted(camera: &Camera, board: &Board, index: usize, draw: &mut Draw) -> Place {
    let field = [index % 3, (index / 3) % 3].map(|k| (k as f64 - 1.0) * 0.6 + draw.between([-0.2, 0.2]));
    let depth = draw.between([0.17, 0.26]);
    let [u, v] = [field[0] * 0.32 * camera.width as f64, field[1] * 0.32 * camera.height as f64];
    let middle = camera.pose.undo([u / camera.lens.fx * depth, v / camera.lens.fy * depth, depth]);
    let (lean, way, spin) = (draw.between([15.0, 38.0]), draw.between([0.0, 360.0]), draw.between([-20.0, 20.0]));
    let turn = leaning(lean.to_radians(), way.to_radians(), spin.to_radians());
    let (columns, rows) = (board.columns as f64 - 2.0, board.rows as f64 - 2.0);
    let half = [0.5 * columns * board.square, 0.5 * rows * board.square, 0.0];
    Place(Pose { translation: vec3::sub(middle, turn.apply(half)), ..turn })
}

/// A turn by `spin` in its own plane, then by `lean` about the direction `way`.
fn leaning(lean: Radian, way: Radian, spin: Radian) -> Pose {
    let about = Pose::from_vector([lean * way.cos(), lean * way.sin(), 0.0], [0.0; 3]);
    let flat = Pose::from_vector([0.0, 0.0, spin], [0.0; 3]);
    let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| about.apply(flat.apply(axis)));
    Pose { rotation: [0, 1, 2].map(|i| columns.map(|column| column[i])), translation: [0.0; 3] }
}

fn whole(camera: &Camera, board: &Board, place: &Place) -> bool {
    let corners = ring(paper(board)).map(|[x, y]| place.0.apply([x * board.square, y * board.square, 0.0]));
    let (right, bottom) = (camera.width as f64 - INSIDE, camera.height as f64 - INSIDE);
    let inside = |[u, v]: [f64; 2]| (INSIDE..right).contains(&u) && (INSIDE..bottom).contains(&v);
    corners.into_iter().all(|corner| camera.pixel(corner).is_some_and(inside))
}

/// The paper's corners in squares: left, top, right, bottom.
fn paper(board: &Board) -> [f64; 4] {
    [-1.0 - MARGIN, -1.0 - MARGIN, board.columns as f64 - 1.0 + MARGIN, board.rows as f64 - 1.0 + MARGIN]
}

/// Points around a rectangle of the board, in squares.
fn ring([left, top, right, bottom]: [f64; 4]) -> [[f64; 2]; 4 * BENDS] {
    let corners = [[left, top], [right, top], [right, bottom], [left, bottom]];
    std::array::from_fn(|i| {
        let (from, to) = (corners[i / BENDS], corners[(i / BENDS + 1) % 4]);
        let share = (i % BENDS) as f64 / BENDS as f64;
        [0, 1].map(|k| from[k] + share * (to[k] - from[k]))
    })
}

fn fill(canvas: &mut Canvas, camera: &Camera, board: &Board, place: &Place, rectangle: [f64; 4], level: f32) {
    let corners = ring(rectangle).map(|[x, y]| place.0.apply([x * board.square, y * board.square, 0.0]));
    if let Some(outline) = camera.outline(&corners) {
        canvas.fill(&outline, level);
    }
}
