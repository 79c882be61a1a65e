//! A calibrated camera as text, OpenCV's YAML, table and figure.

use std::fmt::Write;
use std::path::Path;

use plot::{Axes, Axis, DOUBLE_COLUMN_MM, Figure, Mark, Marker, Panel, Picture, PlotError, palette};
use si::Point2;
use track::board::Target;
use track::board::reduced::Reduced;
use track::lens::Distortion;

use super::Camera;
use super::views::LeftOut;

/// Names of the numbers of a lens.
fn parameter_names(distortion: Distortion) -> [&'static str; 9] {
    match distortion {
        Distortion::BrownConrady => ["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"],
        Distortion::Fisheye => ["fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4", ""],
    }
}

fn distortion_name(distortion: Distortion) -> &'static str {
    match distortion {
        Distortion::BrownConrady => "brown_conrady",
        Distortion::Fisheye => "fisheye",
    }
}

/// Our own file: every number of the lens with its standard deviation.
pub(super) fn camera_toml(camera: &Camera) -> String {
    let (lens, sigma) = (&camera.calibration.lens, camera.calibration.sigma());
    let mut text = format!(
        "# A camera of {} views; px, u to the right, v down, the centre of the first pixel 0, 0. Each number: value, standard deviation.\n\
         lens = \"{}\"\nsize = [{}, {}]\nreprojection_px = {:.4}\nviews = {}\nwithout_board = {}\nrepeated = {}\n",
        camera.views.views.len(),
        distortion_name(lens.distortion),
        camera.size.0,
        camera.size.1,
        camera.calibration.reprojection_px,
        camera.views.views.len(),
        camera.views.without_board(),
        camera.views.repeated(),
    );
    let numbers = parameter_names(lens.distortion).into_iter().zip(lens.values()).zip(sigma);
    for ((name, value), sigma) in numbers.take(lens.count()) {
        writeln!(text, "{name} = [{value:.8e}, {sigma:.2e}]").expect("a string takes any text");
    }
    text
}

/// The file that `cv::FileStorage` and `[camera] coefficients` of a card read.
pub(super) fn opencv_yaml(camera: &Camera) -> String {
    let lens = &camera.calibration.lens;
    let [fx, fy, cx, cy, distortion @ ..] = lens.values();
    let coefficients: Vec<String> = distortion[..lens.count() - 4].iter().map(|c| format!("{c:.12e}")).collect();
    let model = match lens.distortion {
        Distortion::BrownConrady => "plumb_bob",
        Distortion::Fisheye => "equidistant",
    };
    format!(
        "%YAML:1.0\n---\nimage_width: {}\nimage_height: {}\ndistortion_model: {model}\n\
         camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ {fx:.12e}, 0., {cx:.12e}, 0., {fy:.12e}, {cy:.12e}, 0., 0., 1. ]\n\
         distortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: {}\n   dt: d\n   data: [ {} ]\n\
         avg_reprojection_error: {:.6}\n",
        camera.size.0,
        camera.size.1,
        coefficients.len(),
        coefficients.join(", "),
        camera.calibration.reprojection_px,
    )
}

/// One line a view.
pub(super) fn view_table(camera: &Camera) -> String {
    let mut text = "view,points,reprojection_px,distance_m\n".to_owned();
    for (k, name) in camera.views.names.iter().enumerate() {
        let distance = camera.calibration.poses[k].translation[2];
        let (points, error) = (camera.views.views[k].corners.len(), camera.reprojection_error(k));
        writeln!(text, "{name},{points},{error:.4},{distance:.4}").expect("a string takes any text");
    }
    text
}

/// One line a picture that was left out, with its reason.
pub(super) fn left_out_table(left_out: &[LeftOut]) -> String {
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    let line = |picture: &LeftOut| format!("{},{}\n", quoted(&picture.name), quoted(&picture.reason));
    "picture,reason\n".to_owned() + &left_out.iter().map(line).collect::<String>()
}

/// Pictures of which the summary says why they were left out; the table says it of all.
const SAID: usize = 8;

/// The pictures without a board, a line each.
fn left_out_lines(camera: &Camera, folder: &Path) -> String {
    let without: Vec<&LeftOut> = camera.views.left_out.iter().filter(|picture| picture.repeats.is_none()).collect();
    let line = |picture: &&LeftOut| format!("\nleft out: {}: {}", picture.name, picture.reason);
    let rest = match without.len().saturating_sub(SAID) {
        0 => String::new(),
        rest => format!("\nleft out: {rest} more, in {}", folder.join("left_out.csv").display()),
    };
    without.iter().take(SAID).map(line).collect::<String>() + &rest
}

/// Pixels of the picture in the figure, at most: with noise, each takes about a byte of the figure's text.
const SHOWN_PIXELS: usize = 160_000;

/// Points of all views in the figure, at most: each takes some 40 bytes of the figure's text.
const SHOWN_POINTS: usize = 4000;

/// At most so many points, evenly from all.
fn thin_points(points: Vec<Point2>, limit: usize) -> Vec<Point2> {
    let every = points.len().div_ceil(limit).max(1);
    points.into_iter().step_by(every).collect()
}

/// The first view with its points, seen and projected, and the residuals of all views.
pub(super) fn camera_figure(camera: &Camera) -> Result<String, PlotError> {
    let mut panels = Vec::new();
    if let Some(gray) = &camera.views.first {
        let shown = Reduced::with_at_most(gray, SHOWN_PIXELS);
        let reduced = |points: &[Point2]| points.iter().map(|p| shown.to_copy(*p)).collect();
        let thin = |points: &[Point2]| thin_points(reduced(points), SHOWN_POINTS / 4);
        let (observed, projected) = (thin(&camera.views.views[0].corners), thin(&camera.projected_points(0)));
        let picture = Picture::new(shown.picture.width, shown.picture.height, shown.picture.pixels)
            .with(Mark::points(observed, Marker::Cross, palette::MEASURED))
            .with(Mark::points(projected, Marker::Ring, palette::SIMULATED));
        panels.push(Panel::Picture(picture).titled(&camera.views.names[0]));
    }
    let residuals = |k: usize| -> Vec<Point2> {
        let pairs = camera.views.views[k].corners.iter().zip(camera.projected_points(k));
        pairs.map(|(s, p)| [s[0] - p[0], s[1] - p[1]]).collect()
    };
    let residual_points = thin_points((0..camera.views.views.len()).flat_map(residuals).collect(), SHOWN_POINTS);
    let axes = Axes::new(Axis::linear("seen − projected, u", "px"), Axis::linear("v", "px")).equal();
    panels
        .push(Panel::Axes(axes.with(Mark::points(residual_points, Marker::Disc, palette::MUTED))).titled("all views"));
    Figure::new(DOUBLE_COLUMN_MM).row(70.0, panels).svg()
}

pub(super) fn camera_summary(camera: &Camera, folder: &Path) -> String {
    let (lens, sigma) = (&camera.calibration.lens, camera.calibration.sigma());
    let (views, without) = (camera.views.views.len(), camera.views.without_board());
    let repeated = match camera.views.repeated() {
        0 => String::new(),
        repeated => format!(", {repeated} that repeat another view left out"),
    };
    let error = camera.calibration.reprojection_px;
    let part = if matches!(camera.target, Target::Charuco(_)) { "enough of the board" } else { "the whole board" };
    format!(
        "{views} views ({without} pictures without {part}{repeated}), reprojection error {error:.3} px, fx {:.1} ± {:.1}, fy {:.1} ± {:.1}, cx {:.1} ± {:.1}, cy {:.1} ± {:.1} px; results in {}{}",
        lens.fx,
        sigma[0],
        lens.fy,
        sigma[1],
        lens.cx,
        sigma[2],
        lens.cy,
        sigma[3],
        folder.display(),
        left_out_lines(camera, folder)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_thinned_evenly_to_a_bound() {
        let all: Vec<Point2> = (0..13_200).map(|i| [f64::from(i), 0.0]).collect();
        let few = thin_points(all.clone(), SHOWN_POINTS);
        assert!(few.len() <= SHOWN_POINTS && few[1][0] == 4.0 && few.last().unwrap()[0] > 13_190.0);
        assert_eq!(thin_points(all[..100].to_vec(), SHOWN_POINTS).len(), 100);
    }

    #[test]
    fn a_table_quotes_names_and_reasons() {
        let picture = LeftOut { name: "a,b.png".into(), repeats: None, reason: "3 \"corners\"".into() };
        assert_eq!(left_out_table(&[picture]), "picture,reason\n\"a,b.png\",\"3 \"\"corners\"\"\"\n");
    }
}
