//! Calibration of a camera from a film or a folder of pictures of a board.

mod shown;
mod views;

use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, Result};
use si::{Metre, Point2};
use track::board::dots::Dots;
use track::board::{Board, Target};
use track::calibrate::{Calibration, View, calibrate, reprojection};
use track::lens::Distortion;

use views::Views;

/// What is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// A film, or a folder of PNG or JPEG pictures.
    pub source: PathBuf,
    /// Squares of the board along both axes, or dots.
    pub size: [usize; 2],
    /// Side of a square, or distance of the dots' middles, m.
    pub square: Metre,
    /// Whether the board has dots.
    pub dots: bool,
    /// Whether the lens is a fisheye.
    pub fisheye: bool,
    /// Of a film, one frame in so many is used.
    pub every: usize,
    /// Folder for the results, instead of `<source>.camera` beside it.
    pub out: Option<PathBuf>,
}

/// A calibrated camera with what it was made of.
pub(crate) struct Calibrated {
    calibration: Calibration,
    /// Of the pictures, px.
    size: (usize, usize),
    views: Views,
    target: Target,
}

impl Calibrated {
    /// Reprojection error of a view, px.
    fn error(&self, view: usize) -> f64 {
        let pose = &self.calibration.poses[view];
        reprojection(&self.calibration.lens, pose, &self.target.points(), &self.views.corners[view])
    }

    /// Where the points of the board are projected to in a view, px; of those that the lens sees.
    fn projected(&self, view: usize) -> Vec<Point2> {
        let pose = &self.calibration.poses[view];
        let project = |point| self.calibration.lens.project(pose.apply(point));
        self.target.points().into_iter().filter_map(project).collect()
    }
}

/// Calibrates the camera and writes `camera.toml`, `camera.yaml` (OpenCV's), `views.csv` and `camera.svg`; returns a summary.
///
/// # Errors
/// A [`Diagnostic`] when the source cannot be read, too few pictures show the board, or they do not determine the lens.
pub fn run(request: &Request) -> Result<String> {
    let folder = request.out.clone().unwrap_or_else(|| beside(&request.source));
    let found = calibrated(request)?;
    for (name, text) in [
        ("camera.toml", shown::toml(&found)),
        ("camera.yaml", shown::opencv(&found)),
        ("views.csv", shown::views(&found)),
        ("camera.svg", shown::figure(&found)?),
    ] {
        crate::write(&folder, name, &text)?;
    }
    Ok(shown::summary(&found, &folder))
}

fn beside(source: &Path) -> PathBuf {
    let mut name = source.file_name().unwrap_or_default().to_owned();
    name.push(".camera");
    source.with_file_name(name)
}

fn calibrated(request: &Request) -> Result<Calibrated> {
    let [columns, rows] = request.size;
    let target = match request.dots {
        true => Target::Dots(Dots { columns, rows, pitch: request.square }),
        false => Target::Checkerboard(Board { columns, rows, square: request.square }),
    };
    let views = Views::seen(&request.source, &target, request.every)?;
    let distortion = if request.fisheye { Distortion::Fisheye } else { Distortion::BrownConrady };
    let seen: Vec<View> = views.corners.iter().map(|corners| View { corners: corners.clone() }).collect();
    let calibration = calibrate(&seen, &target.points(), distortion, views.size)
        .map_err(|e| Diagnostic::from(e).in_file(&request.source))?;
    Ok(Calibrated { calibration, size: views.size, views, target })
}
