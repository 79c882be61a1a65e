//! `study calibrate` on rendered pictures of a board: the lens comes back, from our file and from OpenCV's.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::PathBuf;

use instruments::calibrate::{self, Request};
use track::Gray;
use track::board::{Board, Target};
use track::lens::{Distortion, Lens, opencv};
use track::pose::Pose;
use track::refraction::RefractiveCamera;

const BOARD: Board = Board { columns: 9, rows: 6, square: 0.02 };
const SIZE: (usize, usize) = (640, 360);
const LENS: Lens = Lens {
    fx: 450.0,
    fy: 452.0,
    cx: 322.0,
    cy: 178.0,
    k1: -0.12,
    k2: 0.04,
    p1: 0.0,
    p2: 0.0,
    k3: 0.0,
    k4: 0.0,
    distortion: Distortion::BrownConrady,
};
/// Rays along each side of a pixel.
const FINE: usize = 4;

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let folder = Self(std::env::temp_dir().join(format!("calibrate-{name}-{}", std::process::id())));
        fs::create_dir_all(folder.0.join("board")).unwrap();
        folder
    }

    fn picture(&self, name: &str, gray: &Gray) {
        fs::write(self.0.join("board").join(name), gray.to_png().unwrap()).unwrap();
    }

    fn request(&self) -> Request {
        let (source, target) = (self.0.join("board"), Target::Checkerboard(BOARD));
        Request { source, target, fisheye: false, every: 1, out: Some(self.0.join("out")) }
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// The board seen by a camera that is tilted by a vector (rad).
fn view(tilt: [f64; 3]) -> Gray {
    let down = Pose::from_vector([std::f64::consts::PI, 0.0, 0.0], [0.0; 3]);
    let turned = down.rotated_and_shifted(tilt, [0.0; 3]);
    let middle = turned.apply([0.07, 0.04, 0.0]);
    let pose = Pose { translation: [-middle[0], -middle[1], 0.3 - middle[2]], ..turned };
    let camera = RefractiveCamera { lens: LENS, pose, water: None };
    let level = |u: f64, v: f64| {
        let [x, y] = camera.intersect([u, v], 0.0).unwrap();
        let (i, j) = ((x / BOARD.square).floor() as i64 + 1, (y / BOARD.square).floor() as i64 + 1);
        let inside = (0..BOARD.columns as i64).contains(&i) && (0..BOARD.rows as i64).contains(&j);
        if inside && (i + j) % 2 == 0 { 30.0 } else { 220.0 }
    };
    let offset = |k: usize| (k as f64 + 0.5) / FINE as f64 - 0.5;
    Gray::from_fn(SIZE.0, SIZE.1, |u, v| {
        let rays = (0..FINE * FINE).map(|k| level(u as f64 + offset(k % FINE), v as f64 + offset(k / FINE)));
        rays.sum::<f64>() / (FINE * FINE) as f64
    })
}

#[test]
fn the_lens_of_a_folder_of_pictures_comes_back_in_both_files() {
    let folder = Folder::new("lens");
    let tilts =
        [[0.0, 0.0, 0.0], [0.4, 0.0, 0.1], [-0.4, 0.1, 0.0], [0.0, 0.4, 0.2], [0.1, -0.4, 0.0], [0.3, 0.3, 0.0]];
    for (k, tilt) in tilts.iter().enumerate() {
        folder.picture(&format!("{k}.png"), &view(*tilt));
    }
    folder.picture("9.png", &Gray::filled(SIZE.0, SIZE.1, 120));
    let said = {
        let request = folder.request();
        calibrate::camera(&request, None).unwrap().summary(&request.out.unwrap())
    };
    assert!(said.contains("6 views (1 pictures without the whole board)"), "{said}");
    let read = |name: &str| fs::read_to_string(folder.0.join("out").join(name)).unwrap();
    let lens = opencv::read(&read("camera.yaml"), false).unwrap().lens;
    assert!((lens.fx - LENS.fx).abs() < 2.0 && (lens.cx - LENS.cx).abs() < 1.0, "{lens:?}");
    // coefficients are correlated: what they do to a ray near the board's corner counts
    let [found, truth] = [lens, LENS].map(|lens| lens.project([0.25, 0.15, 1.0]).unwrap());
    assert!((found[0] - truth[0]).hypot(found[1] - truth[1]) < 0.5, "{found:?} {truth:?}");
    let own: toml::Table = read("camera.toml").parse().unwrap();
    let [value, sigma] = [0, 1].map(|k| own["fx"][k].as_float().unwrap());
    assert!((value - lens.fx).abs() < 1e-4 && (value - LENS.fx).abs() < 5.0 * sigma, "{value} ± {sigma}");
    assert!(own["reprojection_px"].as_float().unwrap() < 0.1);
    assert_eq!(read("views.csv").lines().count(), 7);
    assert!(said.contains("left out: 9.png: no board of 9 × 6 squares is in the picture; 0 of its 40"), "{said}");
    assert!(read("left_out.csv").contains("\"9.png\",\"no board of 9 × 6 squares"), "{}", read("left_out.csv"));
    assert!(read("camera.svg").starts_with("<svg"));
}

#[test]
fn pictures_of_two_sizes_and_a_folder_without_a_board_are_refused() {
    let folder = Folder::new("sizes");
    folder.picture("0.png", &Gray::filled(320, 240, 120));
    let said = calibrate::camera(&folder.request(), None).err().unwrap().to_string();
    assert!(said.contains("no board of 9 × 6 squares") && said.contains("0.png"), "{said}");
    folder.picture("1.png", &Gray::filled(640, 480, 120));
    let said = calibrate::camera(&folder.request(), None).err().unwrap().to_string();
    assert!(said.contains("1.png: picture 1.png has 640 × 480 px"), "{said}");
}

#[test]
fn of_pictures_of_two_sizes_the_odd_one_is_named_though_it_comes_first() {
    let folder = Folder::new("odd");
    folder.picture("0.png", &Gray::filled(320, 240, 120));
    ["1.png", "2.png", "3.png"].iter().for_each(|name| folder.picture(name, &Gray::filled(640, 480, 120)));
    let refused = calibrate::camera(&folder.request(), None).err().unwrap().to_string();
    assert!(refused.contains("0.png: picture 0.png has 320 × 240 px"), "{refused}");
    assert!(refused.contains("3 of 4 pictures have 640 × 480 px"), "{refused}");
}

#[test]
fn copies_of_a_picture_count_once() {
    let folder = Folder::new("copies");
    let tilts = [[0.0, 0.0, 0.0], [0.4, 0.0, 0.1], [-0.4, 0.1, 0.0], [0.0, 0.4, 0.2], [0.1, -0.4, 0.0]];
    let views: Vec<Gray> = tilts.iter().map(|tilt| view(*tilt)).collect();
    views.iter().enumerate().for_each(|(k, gray)| folder.picture(&format!("{k}.png"), gray));
    let camera = || calibrate::camera(&folder.request(), None).unwrap();
    let once = camera().calibration.sigma();
    for k in 5..20 {
        folder.picture(&format!("{k}.png"), &views[k % 5]);
    }
    let copied = camera();
    assert_eq!(copied.calibration.sigma(), once);
    let summary = copied.summary(&folder.0);
    assert!(
        summary.contains("5 views (0 pictures without the whole board, 15 that repeat another view left out)"),
        "{summary}"
    );
    let own = fs::read_to_string(folder.0.join("out/camera.toml")).unwrap();
    assert!(own.contains("repeated = 15\n"), "{own}");
}

/// Six views, each moved by whole pixels a few at a time, with noise: many points and a picture that does not compress.
#[test]
fn of_many_pictures_everything_is_written_in_the_natural_order_of_their_names() {
    let folder = Folder::new("many");
    let tilts =
        [[0.0, 0.0, 0.0], [0.4, 0.0, 0.1], [-0.4, 0.1, 0.0], [0.0, 0.4, 0.2], [0.1, -0.4, 0.0], [0.3, 0.3, 0.0]];
    for (k, tilt) in tilts.iter().enumerate() {
        let whole = view(*tilt);
        for shift in 0..28 {
            let noise = |u: usize, v: usize| ((u * 7919 + v * 104_729 + shift * 31) % 13) as f64 - 6.0;
            let from = |u: usize, v: usize| whole.interpolated_level([u as f64 - 3.0 + shift as f64 / 4.0, v as f64]);
            let gray = Gray::from_fn(SIZE.0, SIZE.1, |u, v| from(u, v) + noise(u, v));
            folder.picture(&format!("board {}.png", 6 * shift + k), &gray);
        }
    }
    let camera = calibrate::camera(&folder.request(), None).unwrap();
    assert!(camera.views().len() > 150, "{}", camera.views().len());
    let read = |name: &str| fs::read_to_string(folder.0.join("out").join(name)).unwrap();
    let views: Vec<String> =
        read("views.csv").lines().skip(1).map(|line| line.split(',').next().unwrap().to_owned()).collect();
    assert_eq!(views, camera.views());
    let numbers: Vec<usize> = views.iter().map(|name| name["board ".len()..name.len() - 4].parse().unwrap()).collect();
    assert!(numbers.is_sorted(), "{numbers:?}");
    let figure = read("camera.svg");
    assert!(figure.starts_with("<svg") && figure.len() < 409_600, "{}", figure.len());
}
