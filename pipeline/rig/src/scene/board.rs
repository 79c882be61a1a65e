//! The checkerboard: its squares, its white margin and the poses of the calibration film.

use si::{Point2, Point3, Radian, vec3};
use track::board::Board;
use track::pose::Pose;

use super::Canvas;
use crate::camera::Camera;
use crate::random::RandomStream;
use crate::settings;

/// Grey levels, 0 to 255.
const PAPER: f32 = 214.0;
const INK: f32 = 28.0;
/// White margin around the squares, in squares.
const MARGIN: f64 = 0.8;
/// Points along a side of a square, so that lens distortion bends it.
const BENDS: usize = 4;
/// Distance from the picture's edge that every corner of the paper keeps, px.
const INSIDE: f64 = 14.0;

/// Pose of the board: board frame → CAD frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BoardPose(pub Pose);

/// The board of the settings.
pub(crate) fn board_layout(plane: &settings::Plane) -> Board {
    Board { columns: plane.columns, rows: plane.rows, square: plane.square }
}

/// The board flat on the plane, its corner (0, 0) at the settings' position, columns along x and rows along y.
pub(crate) fn flat_pose(plane: &settings::Plane) -> BoardPose {
    let [x, y] = plane.corner;
    BoardPose(Pose { rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], translation: [x, y, plane.height] })
}

/// Draws the board.
pub(crate) fn draw_board(canvas: &mut Canvas, camera: &Camera, board: &Board, pose: &BoardPose) {
    if let Some(outline) = rectangle_outline(camera, board, pose, paper_corners(board)) {
        canvas.fill_polygon(&outline, PAPER);
    }
    for row in 0..board.rows {
        for column in (0..board.columns).filter(|column| board.is_black(*column, row)) {
            let (left, top) = (column as f64 - 1.0, row as f64 - 1.0);
            if let Some(outline) = rectangle_outline(camera, board, pose, [left, top, left + 1.0, top + 1.0]) {
                canvas.fill_polygon(&outline, INK);
            }
        }
    }
}

/// `count` poses that together cover the picture, tilted in all directions, each completely inside.
pub(crate) fn calibration_poses(
    camera: &Camera,
    board: &Board,
    count: usize,
    random: &mut RandomStream,
) -> Vec<BoardPose> {
    let mut poses = Vec::with_capacity(count);
    while poses.len() < count {
        let pose = tilted_pose(camera, board, poses.len(), random);
        if is_inside(camera, board, &pose) {
            poses.push(pose);
        }
    }
    poses
}

/// A pose between two others: translation and rotation vector are interpolated linearly.
pub(crate) fn pose_between(from: &BoardPose, to: &BoardPose, fraction: f64) -> BoardPose {
    let mix = |a: Point3, b: Point3| vec3::add(vec3::scale(a, 1.0 - fraction), vec3::scale(b, fraction));
    BoardPose(Pose::from_vector(
        mix(from.0.rotation_vector(), to.0.rotation_vector()),
        mix(from.0.translation, to.0.translation),
    ))
}

/// Pose `index`: its centre cycles through nine fields of the picture; its tilt is random.
fn tilted_pose(camera: &Camera, board: &Board, index: usize, random: &mut RandomStream) -> BoardPose {
    let field = [index % 3, (index / 3) % 3].map(|k| (k as f64 - 1.0) * 0.6 + random.uniform([-0.2, 0.2]));
    let depth = random.uniform([0.17, 0.26]);
    let [u, v] = [field[0] * 0.32 * camera.width as f64, field[1] * 0.32 * camera.height as f64];
    let middle = camera.pose.to_world([u / camera.lens.fx * depth, v / camera.lens.fy * depth, depth]);
    let (lean, way, spin) = (random.uniform([15.0, 38.0]), random.uniform([0.0, 360.0]), random.uniform([-20.0, 20.0]));
    let turn = leaning_pose(lean.to_radians(), way.to_radians(), spin.to_radians());
    let (columns, rows) = (board.columns as f64 - 2.0, board.rows as f64 - 2.0);
    let half = [0.5 * columns * board.square, 0.5 * rows * board.square, 0.0];
    BoardPose(Pose { translation: vec3::sub(middle, turn.apply(half)), ..turn })
}

/// A rotation by `spin` in its own plane, then by `lean` about the in-plane direction `way`.
fn leaning_pose(lean: Radian, way: Radian, spin: Radian) -> Pose {
    let lean_rotation = Pose::from_vector([lean * way.cos(), lean * way.sin(), 0.0], [0.0; 3]);
    let spin_rotation = Pose::from_vector([0.0, 0.0, spin], [0.0; 3]);
    let columns =
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| lean_rotation.apply(spin_rotation.apply(axis)));
    Pose { rotation: [0, 1, 2].map(|i| columns.map(|column| column[i])), translation: [0.0; 3] }
}

fn is_inside(camera: &Camera, board: &Board, pose: &BoardPose) -> bool {
    let corners =
        rectangle_points(paper_corners(board)).map(|[x, y]| pose.0.apply([x * board.square, y * board.square, 0.0]));
    let (right, bottom) = (camera.width as f64 - INSIDE, camera.height as f64 - INSIDE);
    let inside = |[u, v]: [f64; 2]| (INSIDE..right).contains(&u) && (INSIDE..bottom).contains(&v);
    corners.into_iter().all(|corner| camera.pixel(corner).is_some_and(inside))
}

/// The paper's corners in squares: left, top, right, bottom.
fn paper_corners(board: &Board) -> [f64; 4] {
    [-1.0 - MARGIN, -1.0 - MARGIN, board.columns as f64 - 1.0 + MARGIN, board.rows as f64 - 1.0 + MARGIN]
}

/// Points around a rectangle of the board, in squares.
fn rectangle_points([left, top, right, bottom]: [f64; 4]) -> [[f64; 2]; 4 * BENDS] {
    let corners = [[left, top], [right, top], [right, bottom], [left, bottom]];
    std::array::from_fn(|i| {
        let (from, to) = (corners[i / BENDS], corners[(i / BENDS + 1) % 4]);
        let fraction = (i % BENDS) as f64 / BENDS as f64;
        [0, 1].map(|k| from[k] + fraction * (to[k] - from[k]))
    })
}

/// The outline of a rectangle of the board (in squares), px; none if a corner has no pixel.
fn rectangle_outline(camera: &Camera, board: &Board, pose: &BoardPose, rectangle: [f64; 4]) -> Option<Vec<Point2>> {
    let corners = rectangle_points(rectangle).map(|[x, y]| pose.0.apply([x * board.square, y * board.square, 0.0]));
    camera.outline(&corners)
}
