//! ChArUco boards as OpenCV prints them are found in pictures as a camera takes them, whole, in part and of either print.

#![allow(clippy::unwrap_used)] // a test may unwrap

mod noise;

use noise::Noise;
use si::Point2;
use track::Gray;
use track::board::charuco::{Charuco, find};
use track::board::{Board, BoardError, Target};
use track::calibrate::{View, calibrate};
use track::lens::{Distortion, Lens};
use track::pose::Pose;
use track::refraction::RefractiveCamera;

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
const SIZE: (usize, usize) = (800, 600);

/// A print of OpenCV at 32 px a square, and its board.
struct Print {
    picture: Gray,
    board: Charuco,
}

fn print(file: &str, (columns, rows): (usize, usize), dictionary: &str) -> Print {
    let path = format!("{}/tests/data/charuco/{file}.png", env!("CARGO_MANIFEST_DIR"));
    let picture = Gray::from_png(&std::fs::read(path).unwrap()).unwrap();
    let (square, marker) = (0.04, 0.03);
    Print { picture, board: Charuco { columns, rows, square, marker, dictionary: dictionary.parse().unwrap() } }
}

fn small() -> Print {
    print("dict_4x4_50_7x5", (7, 5), "DICT_4X4_50")
}

impl Print {
    /// The level at a place of the board's frame, m: its corner (0, 0) is at the lower left of the print. White around it.
    fn level(&self, [x, y]: Point2) -> f64 {
        let u = (x / self.board.square + 1.0) * 32.0;
        let v = ((self.board.rows as f64 - 1.0) - y / self.board.square) * 32.0;
        let is_inside = (0.0..self.picture.width as f64).contains(&u) && (0.0..self.picture.height as f64).contains(&v);
        if is_inside { 40.0 + 0.65 * self.picture.pixel_level(u as usize, v as usize) } else { 206.0 }
    }

    /// What a camera sees: 4 × 4 rays a pixel and noise of 1.5 grey levels.
    fn seen(&self, pose: &Pose, seed: u64) -> Gray {
        let (mut random, fine) = (Noise(seed), 4);
        let camera = RefractiveCamera { lens: LENS, pose: *pose, water: None };
        Gray::from_fn(SIZE.0, SIZE.1, |x, y| {
            let at = |i: f64, j: f64| camera.intersect([x as f64 + i, y as f64 + j], 0.0).unwrap();
            let (o, a, b) = (at(0.0, 0.0), at(0.5, 0.0), at(0.0, 0.5));
            let ray = |k: usize| {
                let [i, j] = [k % fine, k / fine].map(|n| 2.0 * ((n as f64 + 0.5) / fine as f64 - 0.5));
                self.level([0, 1].map(|d| o[d] + i * (a[d] - o[d]) + j * (b[d] - o[d])))
            };
            (0..fine * fine).map(ray).sum::<f64>() / (fine * fine) as f64 + 1.5 * random.next()
        })
    }

    /// The largest distance of the corners of a view from where they are, px.
    fn largest_miss(&self, view: &View, pose: &Pose) -> f64 {
        let points = view.points(&Target::Charuco(self.board).points());
        assert_eq!(points.len(), view.corners.len());
        let miss = |(point, seen): (&[f64; 3], &Point2)| {
            let truth = LENS.project(pose.apply(*point)).unwrap();
            (truth[0] - seen[0]).hypot(truth[1] - seen[1])
        };
        points.iter().zip(&view.corners).map(miss).fold(0.0, f64::max)
    }
}

/// A camera over a place of the board, tilted by `tilt` towards `around`, rolled by `roll` (rad), `far` away (m).
fn above(place: Point2, tilt: f64, around: f64, roll: f64, far: f64) -> Pose {
    let product = |a: [[f64; 3]; 3], b: [[f64; 3]; 3]| {
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
    };
    let turn = |v| Pose::from_vector(v, [0.0; 3]).rotation;
    let down = turn([std::f64::consts::PI, 0.0, 0.0]);
    let tilted = turn([tilt * around.cos(), tilt * around.sin(), 0.0]);
    let rotation = product(tilted, product(turn([0.0, 0.0, roll]), down));
    let middle = Pose { rotation, translation: [0.0; 3] }.apply([place[0], place[1], 0.0]);
    Pose { rotation, translation: [-middle[0], -middle[1], far - middle[2]] }
}

#[test]
fn every_corner_of_whole_boards_of_three_dictionaries_is_found_to_a_fifth_of_a_pixel() {
    let boards = [
        (small(), 0.42),
        (print("dict_5x5_100_8x6_legacy", (8, 6), "DICT_5X5_100"), 0.5),
        (print("dict_6x6_250_6x4", (6, 4), "DICT_6X6_250"), 0.36),
    ];
    for (print, far) in boards {
        let middle = [0.5 * 0.04 * (print.board.columns as f64 - 2.0), 0.5 * 0.04 * (print.board.rows as f64 - 2.0)];
        for (k, tilt) in [0.0, 0.3, 0.55].into_iter().enumerate() {
            let pose = above(middle, tilt, 1.3 * k as f64, 1.9 * k as f64, far);
            let view = find(&print.seen(&pose, 3 + k as u64), &print.board).unwrap();
            let all = (print.board.columns - 1) * (print.board.rows - 1);
            assert_eq!(view.corners.len(), all, "{} tilted by {tilt}", print.board.dictionary);
            let miss = print.largest_miss(&view, &pose);
            assert!(miss < 0.2, "{} tilted by {tilt}: {miss} px", print.board.dictionary);
        }
    }
}

#[test]
fn parts_of_a_board_give_the_lens_back() {
    let print = small();
    let mut parts = 0;
    let views: Vec<View> = (0..10)
        .map(|k| {
            let turn = f64::from(k);
            // over its ends, so that some of it is outside
            let place = [[0.0, 0.02], [0.2, 0.1], [0.1, 0.0], [0.06, 0.12], [0.18, 0.02]][k as usize % 5];
            let pose = above(place, [0.2, 0.45][k as usize % 2], 1.1 * turn, 0.7 * turn, 0.24 + 0.008 * turn);
            let view = find(&print.seen(&pose, 20 + k as u64), &print.board).unwrap();
            let miss = print.largest_miss(&view, &pose);
            assert!(miss < 0.2, "view {k}: {miss} px");
            parts += usize::from(view.corners.len() < 24);
            view
        })
        .collect();
    assert!(parts >= 8, "{parts} of 10 views show a part");
    let camera = calibrate(&views, &Target::Charuco(print.board).points(), Distortion::BrownConrady, SIZE).unwrap();
    let sigma = camera.sigma()[0];
    assert!((camera.lens.fx - LENS.fx).abs() < 4.0 * sigma && sigma < 3.0, "{} ± {sigma}", camera.lens.fx);
    assert!(camera.reprojection_px < 0.15, "{}", camera.reprojection_px);
}

#[test]
fn a_covered_corner_is_left_out_and_the_others_keep_their_numbers() {
    let print = small();
    let pose = above([0.1, 0.06], 0.3, 0.4, 0.2, 0.42);
    let mut picture = print.seen(&pose, 9);
    let covered = LENS.project(pose.apply([0.08, 0.08, 0.0])).unwrap();
    for (y, x) in (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| (y, x))) {
        if (x as f64 - covered[0]).hypot(y as f64 - covered[1]) < 25.0 {
            picture.pixels[y * SIZE.0 + x] = 130;
        }
    }
    let view = find(&picture, &print.board).unwrap();
    let numbers = view.numbers.clone().unwrap();
    assert!(!numbers.contains(&14) && numbers.len() >= 21, "{numbers:?}");
    assert!(print.largest_miss(&view, &pose) < 0.2);
}

#[test]
fn what_cannot_be_a_view_is_refused_with_its_reason() {
    let print = small();
    let pose = above([0.1, 0.06], 0.2, 0.4, 0.2, 0.42);
    let picture = print.seen(&pose, 9);
    let other = Charuco { dictionary: "DICT_5X5_100".parse().unwrap(), ..print.board };
    let refusal = find(&picture, &other).unwrap_err();
    assert!(matches!(refusal, BoardError::NoMarker { other: Some(seen), .. } if seen.side == 4), "{refusal}");
    let turned = Charuco { columns: 5, rows: 7, ..print.board };
    assert!(matches!(find(&picture, &turned), Err(BoardError::OtherBoard { markers: 17, .. })));
    let few = Charuco { columns: 15, ..print.board };
    assert!(matches!(find(&picture, &few), Err(BoardError::OtherBoard { .. })));
    let large = Charuco { columns: 30, ..print.board };
    assert!(matches!(find(&picture, &large), Err(BoardError::NoCharuco { .. })));
    let far = print.seen(&above([-0.02, -0.03], 0.1, 0.4, 0.2, 0.09), 9);
    assert!(matches!(find(&far, &print.board), Err(BoardError::FewCorners { .. } | BoardError::NoMarker { .. })));
    let empty = Gray::filled(400, 300, 180);
    assert!(matches!(find(&empty, &print.board), Err(BoardError::NoMarker { quads: 0, other: None, .. })));
    // a mirrored picture shows no marker
    let mirrored = Gray::from_fn(SIZE.0, SIZE.1, |x, y| picture.pixel_level(SIZE.0 - 1 - x, y));
    let refusal = find(&mirrored, &print.board).unwrap_err();
    assert!(!matches!(refusal, BoardError::FewCorners { .. }), "{refusal}");
}

#[test]
fn of_a_plain_checkerboard_a_part_is_refused_because_it_could_be_any() {
    let board = Board { columns: 7, rows: 4, square: 0.04 };
    let level = |x: usize, y: usize| if (x / 40 + y / 40).is_multiple_of(2) { 40.0 } else { 200.0 };
    let margin = |x: usize, y: usize| (40..320).contains(&x) && (40..200).contains(&y);
    let whole = Gray::from_fn(400, 260, |x, y| if margin(x, y) { level(x, y) } else { 200.0 });
    assert_eq!(track::board::find(&whole, &board).unwrap().len(), 18);
    let refusal = track::board::find(&whole.crop(90, 0, 310, 260), &board).unwrap_err().to_string();
    assert!(refusal.contains("of its 18 inner corners") && refusal.contains("a part cannot be told"), "{refusal}");
}
