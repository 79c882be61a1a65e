//! A lens and its poses come back from synthetic corners, clean and noisy.

#![allow(clippy::unwrap_used)]

mod noise;

use noise::Noise;
use si::Point2;
use track::board::Board;
use track::calibrate::{
    CalibrateError, View, calibrate, focal_difference, joint_covariance, pose_from_plane, reprojection_error,
};
use track::lens::{Distortion, Lens};
use track::pose::Pose;

const BOARD: Board = Board { columns: 9, rows: 6, square: 0.025 };
const SIZE: (usize, usize) = (1920, 1080);
const LENS: Lens = Lens {
    fx: 1473.0,
    fy: 1478.0,
    cx: 969.0,
    cy: 541.0,
    k1: -0.12,
    k2: 0.04,
    p1: 4e-4,
    p2: -3e-4,
    k3: -0.01,
    k4: 0.0,
    distortion: Distortion::BrownConrady,
};

/// Poses that look down on the board in different tilts, as a person holds it.
fn poses() -> Vec<Pose> {
    let mut tilted_poses = Vec::new();
    for k in 0..15 {
        let angle = f64::from(k) * 2.4;
        let tilt = 0.15 + 0.03 * f64::from(k);
        let downward = Pose::from_vector([std::f64::consts::PI, 0.0, 0.0], [0.0; 3]);
        let tilted = Pose::from_vector([tilt * angle.cos(), tilt * angle.sin(), 0.2 * angle.sin()], [0.0; 3]);
        let rotation =
            [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).map(|m| tilted.rotation[i][m] * downward.rotation[m][j]).sum()));
        let turned = Pose { rotation, translation: [0.0; 3] };
        let middle = turned.apply([0.0875, 0.05, 0.0]);
        let centre = [0.09 * angle.sin(), 0.04 * (1.7 * angle).cos(), 0.42 + 0.01 * f64::from(k)];
        tilted_poses.push(Pose { rotation, translation: [0, 1, 2].map(|i| centre[i] - middle[i]) });
    }
    tilted_poses
}

fn views(noise: f64, seed: u64) -> Vec<View> {
    let mut random = Noise(seed);
    let mut blur = |p: Point2| [p[0] + noise * random.next(), p[1] + noise * random.next()];
    let see =
        |pose: &Pose| BOARD.corner_points().iter().map(|&c| LENS.project(pose.apply(c)).unwrap()).collect::<Vec<_>>();
    poses().iter().map(|pose| View::of_whole_board(see(pose).into_iter().map(&mut blur).collect())).collect()
}

#[test]
fn clean_corners_give_the_lens_back() {
    let calibration = calibrate(&views(0.0, 0), &BOARD.corner_points(), Distortion::BrownConrady, SIZE).unwrap();
    let (a, b) = (calibration.lens, LENS);
    for (name, x, y) in [("fx", a.fx, b.fx), ("fy", a.fy, b.fy), ("cx", a.cx, b.cx), ("cy", a.cy, b.cy)] {
        assert!((x / y - 1.0).abs() < 1e-6, "{name} {x} {y}");
    }
    for (x, y) in [(a.k1, b.k1), (a.k2, b.k2), (a.p1, b.p1), (a.p2, b.p2), (a.k3, b.k3)] {
        assert!((x - y).abs() < 1e-6, "{x} {y}");
    }
    for (pose, truth) in calibration.poses.iter().zip(poses()) {
        assert!(si::vec3::norm(si::vec3::sub(pose.centre(), truth.centre())) < 1e-6);
    }
    assert!(calibration.reprojection_px < 1e-6);
}

#[test]
fn a_tenth_of_a_pixel_of_noise_moves_the_focal_length_by_less_than_half_a_percent() {
    for seed in 1..4 {
        let calibration = calibrate(&views(0.1, seed), &BOARD.corner_points(), Distortion::BrownConrady, SIZE).unwrap();
        assert!(
            (calibration.lens.fx / LENS.fx - 1.0).abs() < 5e-3 && (calibration.lens.fy / LENS.fy - 1.0).abs() < 5e-3
        );
        assert!(
            (calibration.reprojection_px / (0.1 * 2.0_f64.sqrt()) - 1.0).abs() < 0.1,
            "{}",
            calibration.reprojection_px
        );
    }
}

#[test]
fn the_standard_deviations_tell_the_scatter_over_repeated_calibrations() {
    let calibrations: Vec<_> = (1..=24)
        .map(|seed| calibrate(&views(0.1, seed), &BOARD.corner_points(), Distortion::BrownConrady, SIZE).unwrap())
        .collect();
    let scatter = |value: usize| {
        let mean = calibrations.iter().map(|c| c.lens.values()[value]).sum::<f64>() / 24.0;
        (calibrations.iter().map(|c| (c.lens.values()[value] - mean).powi(2)).sum::<f64>() / 23.0).sqrt()
    };
    for value in [0, 3, 4, 7] {
        let stated = calibrations[0].sigma()[value];
        // the scatter of 24 draws is itself known to 15 %: three of that
        assert!((scatter(value) / stated - 1.0).abs() < 0.45, "{} {stated}", scatter(value));
    }
}

#[test]
fn a_pose_comes_back_from_points_of_a_raised_plane() {
    for pose in poses() {
        let points: Vec<_> = BOARD.corner_points().iter().map(|c| [c[0], c[1], 0.013]).collect();
        let pixels: Vec<_> = points.iter().map(|&p| LENS.project(pose.apply(p)).unwrap()).collect();
        let recovered = pose_from_plane(&LENS, &points, &pixels).unwrap();
        assert!(si::vec3::norm(si::vec3::sub(recovered.centre(), pose.centre())) < 1e-9);
        assert!(reprojection_error(&LENS, &recovered, &points, &pixels) < 1e-7);
    }
}

#[test]
fn four_points_are_enough_for_a_pose_and_three_are_not() {
    let points = [[0.0, 0.0, 0.0], [0.2, 0.0, 0.0], [0.2, 0.1, 0.0], [0.0, 0.1, 0.0]];
    let pixels = points.map(|p| LENS.project(poses()[4].apply(p)).unwrap());
    assert!(pose_from_plane(&LENS, &points, &pixels).is_ok());
    assert!(matches!(pose_from_plane(&LENS, &points[..3], &pixels[..3]), Err(CalibrateError::Points { .. })));
}

#[test]
fn points_off_the_plane_or_on_a_line_are_refused() {
    let line: Vec<_> = (0..6).map(|i| [0.01 * f64::from(i), 0.0, 0.0]).collect();
    let pixels: Vec<_> = line.iter().map(|&p| LENS.project(poses()[4].apply(p)).unwrap()).collect();
    assert!(matches!(pose_from_plane(&LENS, &line, &pixels), Err(CalibrateError::Points { .. })));
    let bent: Vec<_> = line.iter().map(|p| [p[0], p[1], p[0]]).collect();
    assert!(matches!(pose_from_plane(&LENS, &bent, &pixels), Err(CalibrateError::Points { .. })));
}

#[test]
fn two_views_or_views_of_one_tilt_are_refused() {
    let all_views = views(0.05, 9);
    let two_view_result = calibrate(&all_views[..2], &BOARD.corner_points(), Distortion::BrownConrady, SIZE);
    assert!(matches!(two_view_result, Err(CalibrateError::TooFewViews { given: 2, needed: 3 })));
    let flat = Pose::from_vector([std::f64::consts::PI, 0.0, 0.0], [-0.08, 0.05, 0.5]);
    let mut random = Noise(5);
    let mut see = || {
        let corner = |&c| LENS.project(flat.apply(c)).unwrap().map(|v| v + 0.1 * random.next());
        View::of_whole_board(BOARD.corner_points().iter().map(corner).collect())
    };
    let alike: Vec<_> = (0..5).map(|_| see()).collect();
    let result = calibrate(&alike, &BOARD.corner_points(), Distortion::BrownConrady, SIZE);
    assert!(matches!(result, Err(CalibrateError::Degenerate { .. })), "{result:?}");
}

#[test]
fn a_view_with_missing_corners_is_refused_by_its_number() {
    let mut all_views = views(0.0, 0);
    all_views[3].corners.pop();
    let error = calibrate(&all_views, &BOARD.corner_points(), Distortion::BrownConrady, SIZE).unwrap_err();
    assert_eq!(error, CalibrateError::Corners { view: 3, given: 39, expected: 40 });
}

#[test]
fn a_fisheye_comes_back_from_its_own_corners() {
    let lens = Lens { distortion: Distortion::Fisheye, ..Lens::default() };
    let lens = lens.with_values([880.0, 883.0, 961.0, 538.0, 0.04, -0.012, 3e-3, -1e-3, 0.0]);
    let see =
        |pose: &Pose| BOARD.corner_points().iter().map(|&c| lens.project(pose.apply(c)).unwrap()).collect::<Vec<_>>();
    let nearer = |pose: Pose| Pose { translation: pose.translation.map(|x| 0.45 * x), ..pose };
    let views: Vec<_> = poses().into_iter().map(|pose| View::of_whole_board(see(&nearer(pose)))).collect();
    let calibration = calibrate(&views, &BOARD.corner_points(), Distortion::Fisheye, SIZE).unwrap();
    assert!(calibration.reprojection_px < 1e-4, "{}", calibration.reprojection_px);
    for (value, truth) in calibration.lens.values().iter().zip(lens.values()).take(5) {
        assert!((value - truth).abs() < 1e-3 * truth.abs(), "{value} {truth}");
    }
    let brown = calibrate(&views, &BOARD.corner_points(), Distortion::BrownConrady, SIZE).unwrap();
    assert!(brown.reprojection_px > 10.0 * calibration.reprojection_px);
}

#[test]
fn the_joint_covariance_tells_the_scatter_of_where_the_camera_stands() {
    let pose = poses()[4];
    let points = BOARD.corner_points();
    let observe = |random: &mut Noise| -> Vec<Point2> {
        points.iter().map(|&p| LENS.project(pose.apply(p)).unwrap().map(|v| v + 0.1 * random.next())).collect()
    };
    let mut stated = [0.0; 3];
    let estimated_poses: Vec<Pose> = (1..=24)
        .map(|seed| {
            let camera = calibrate(&views(0.1, seed), &points, Distortion::BrownConrady, SIZE).unwrap();
            let pixels = observe(&mut Noise(100 + seed));
            let pose = pose_from_plane(&camera.lens, &points, &pixels).unwrap();
            let joint = joint_covariance((&camera.lens, &camera.covariance), &pose, &points, &pixels).unwrap();
            stated = [12, 13, 14].map(|k| joint[k][k].sqrt());
            pose
        })
        .collect();
    for (k, stated) in stated.iter().enumerate() {
        let mean = estimated_poses.iter().map(|p| p.translation[k]).sum::<f64>() / 24.0;
        let scatter = (estimated_poses.iter().map(|p| (p.translation[k] - mean).powi(2)).sum::<f64>() / 23.0).sqrt();
        // 24 draws give a standard deviation to 15 %, and one view's misses its own noise to 10 %
        assert!((scatter / stated - 1.0).abs() < 0.5, "{k}: {scatter} {stated}");
    }
}

/// A focal length that is wrong moves the camera away and hardly changes the reprojection: the views by themselves determine it.
#[test]
fn a_focal_length_that_the_views_contradict_is_said_with_both() {
    let (seen, corners) = (views(0.1, 5), BOARD.corner_points());
    let lens = |by: f64| Lens { fx: by * LENS.fx, fy: by * LENS.fy, ..LENS };
    let difference = |by: f64| focal_difference(&lens(by), &seen, &corners, SIZE);
    assert_eq!([1.0, 1.03, 0.97].map(difference), [None; 3]);
    for by in [1.2, 0.8] {
        let warning = difference(by).unwrap();
        let expected = format!("a focal length of {:.0} px, the views of the board give 147", by * LENS.fx);
        assert!(
            warning.to_string().contains(&expected) && warning.reason().contains("they differ by 20 %"),
            "{warning}"
        );
    }
    // three views of one tilt do not determine it
    assert_eq!(focal_difference(&Lens { fx: 1600.0, ..LENS }, &seen[..2], &corners, SIZE), None);
}

#[test]
fn the_mean_of_views_of_parts_is_that_of_the_views_that_show_a_point() {
    let part =
        |numbers: &[usize], corners: &[[f64; 2]]| View { corners: corners.to_vec(), numbers: Some(numbers.to_vec()) };
    let views = [part(&[1, 4], &[[10.0, 0.0], [40.0, 2.0]]), part(&[0, 4], &[[5.0, 5.0], [42.0, 4.0]])];
    let mean = View::mean(&views);
    assert_eq!(mean, part(&[0, 1, 4], &[[5.0, 5.0], [10.0, 0.0], [41.0, 3.0]]));
    let points = BOARD.corner_points();
    assert_eq!(mean.points(&points), [points[0], points[1], points[4]]);
    assert_eq!((mean.corner_pixel(4), mean.corner_pixel(3)), (Some([41.0, 3.0]), None));
    let full_views =
        [View::of_whole_board(vec![[0.0, 0.0], [2.0, 0.0]]), View::of_whole_board(vec![[1.0, 1.0], [2.0, 2.0]])];
    assert_eq!(View::mean(&full_views), View::of_whole_board(vec![[0.5, 0.5], [2.0, 1.0]]));
}
