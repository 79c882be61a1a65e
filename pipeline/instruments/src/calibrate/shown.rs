//! A calibrated camera as text, OpenCV's YAML, table and figure.

use std::fmt::Write;
use std::path::Path;

use plot::{Axes, Axis, DOUBLE_COLUMN_MM, Figure, Mark, Marker, Panel, Picture, PlotError, palette};
use si::Point2;
use track::lens::Distortion;

use super::Camera;

/// Names of the numbers of a lens.
fn names(distortion: Distortion) -> [&'static str; 9] {
    match distortion {
        Distortion::BrownConrady => ["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"],
        Distortion::Fisheye => ["fx", "fy", "cx", "cy", "k1", "k2", "k3", "k4", ""],
    }
}

fn word(distortion: Distortion) -> &'static str {
    match distortion {
        Distortion::BrownConrady => "brown_conrady",
        Distortion::Fisheye => "fisheye",
    }
}

/// Our own file: every number of the lens with its standard deviation.
pub(super) fn toml(found: &Camera) -> String {
    let (lens, sigma) = (&found.calibration.lens, found.calibration.sigma());
    let mut text = format!(
        "# A camera of {} views; px, u to the right, v down, the centre of the first pixel 0, 0. Each number: value, standard deviation.\n\
         lens = \"{}\"\nsize = [{}, {}]\nreprojection_px = {:.4}\nviews = {}\nwithout_board = {}\n",
        found.views.corners.len(),
        word(lens.distortion),
        found.size.0,
        found.size.1,
        found.calibration.reprojection_px,
        found.views.corners.len(),
        found.views.without,
    );
    let numbers = names(lens.distortion).into_iter().zip(lens.values()).zip(sigma);
    for ((name, value), sigma) in numbers.take(lens.count()) {
        writeln!(text, "{name} = [{value:.8e}, {sigma:.2e}]").expect("a string takes any text");
    }
    text
}

/// The file that `cv::FileStorage` and `[camera] coefficients` of a card read.
pub(super) fn opencv(found: &Camera) -> String {
    let lens = &found.calibration.lens;
    let [fx, fy, cx, cy, rest @ ..] = lens.values();
    let coefficients: Vec<String> = rest[..lens.count() - 4].iter().map(|c| format!("{c:.12e}")).collect();
    let model = match lens.distortion {
        Distortion::BrownConrady => "plumb_bob",
        Distortion::Fisheye => "equidistant",
    };
    format!(
        "%YAML:1.0\n---\nimage_width: {}\nimage_height: {}\ndistortion_model: {model}\n\
         camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ {fx:.12e}, 0., {cx:.12e}, 0., {fy:.12e}, {cy:.12e}, 0., 0., 1. ]\n\
         distortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: {}\n   dt: d\n   data: [ {} ]\n\
         avg_reprojection_error: {:.6}\n",
        found.size.0,
        found.size.1,
        coefficients.len(),
        coefficients.join(", "),
        found.calibration.reprojection_px,
    )
}

/// One line a view.
pub(super) fn views(found: &Camera) -> String {
    let mut text = "view,points,reprojection_px,distance_m\n".to_owned();
    for (k, name) in found.views.names.iter().enumerate() {
        let distance = found.calibration.poses[k].translation[2];
        let (points, error) = (found.views.corners[k].len(), found.reprojection_error(k));
        writeln!(text, "{name},{points},{error:.4},{distance:.4}").expect("a string takes any text");
    }
    text
}

/// The first view with its points, seen and projected, and the residuals of all views.
pub(super) fn figure(found: &Camera) -> Result<String, PlotError> {
    let mut panels = Vec::new();
    if let Some(gray) = &found.views.first {
        let picture = Picture::new(gray.width, gray.height, gray.pixels.clone())
            .with(Mark::points(found.views.corners[0].clone(), Marker::Cross, palette::MEASURED))
            .with(Mark::points(found.projected(0), Marker::Ring, palette::SIMULATED));
        panels.push(Panel::Picture(picture).titled(&found.views.names[0]));
    }
    let off = |k: usize| -> Vec<Point2> {
        let seen = found.views.corners[k].iter().zip(found.projected(k));
        seen.map(|(s, p)| [s[0] - p[0], s[1] - p[1]]).collect()
    };
    let all: Vec<Point2> = (0..found.views.corners.len()).flat_map(off).collect();
    let axes = Axes::new(Axis::linear("seen − projected, u", "px"), Axis::linear("v", "px")).equal();
    panels.push(Panel::Axes(axes.with(Mark::points(all, Marker::Disc, palette::MUTED))).titled("all views"));
    Figure::new(DOUBLE_COLUMN_MM).row(70.0, panels).svg()
}

pub(super) fn summary(found: &Camera, folder: &Path) -> String {
    let (lens, sigma) = (&found.calibration.lens, found.calibration.sigma());
    let (views, without) = (found.views.corners.len(), found.views.without);
    let error = found.calibration.reprojection_px;
    format!(
        "{views} views ({without} pictures without the whole board), reprojection error {error:.3} px, fx {:.1} ± {:.1}, fy {:.1} ± {:.1}, cx {:.1} ± {:.1}, cy {:.1} ± {:.1} px; results in {}",
        lens.fx,
        sigma[0],
        lens.fy,
        sigma[1],
        lens.cx,
        sigma[2],
        lens.cy,
        sigma[3],
        folder.display()
    )
}
