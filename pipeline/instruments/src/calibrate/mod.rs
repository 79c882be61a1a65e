//! Calibration of a camera from a film or a folder of pictures of a board.

mod shown;
mod views;

use std::path::{Path, PathBuf};

use diagnostics::{Diagnostic, Result};
use si::Point2;
use track::board::Target;
use track::calibrate::{Calibration, calibrate, reprojection_error};
use track::lens::Distortion;

use crate::Interrupt;
use views::Views;

/// What is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// A film, or a folder of PNG or JPEG pictures.
    pub source: PathBuf,
    /// The board.
    pub target: Target,
    /// Whether the lens is a fisheye.
    pub fisheye: bool,
    /// Of a film, one frame in so many is used.
    pub every: usize,
    /// Folder for the results; nothing is written where none is given.
    pub out: Option<PathBuf>,
}

/// A calibrated camera with what it was made of.
pub struct Camera {
    /// Its lens and the pose of each view.
    pub calibration: Calibration,
    /// Width and height of the pictures, px.
    pub size: (usize, usize),
    views: Views,
    target: Target,
}

impl Camera {
    /// Name of each picture in which the board was found, or time of each frame.
    pub fn views(&self) -> &[String] {
        &self.views.names
    }

    /// Root of the mean squared distance between seen and projected corners of a view, px.
    pub fn reprojection_error(&self, view: usize) -> f64 {
        let (pose, seen) = (&self.calibration.poses[view], &self.views.views[view]);
        reprojection_error(&self.calibration.lens, pose, &seen.points(&self.target.points()), &seen.corners)
    }

    /// What was calibrated, and where the results lie.
    pub fn summary(&self, folder: &Path) -> String {
        shown::camera_summary(self, folder)
    }

    fn write_results(&self, folder: &Path) -> Result<()> {
        let files = [("camera.toml", shown::camera_toml(self)), ("camera.yaml", shown::opencv_yaml(self))];
        files.iter().try_for_each(|(name, text)| crate::write_result(folder, name, text))?;
        crate::write_result(folder, "views.csv", shown::view_table(self))?;
        crate::write_result(folder, "left_out.csv", shown::left_out_table(&self.views.left_out))?;
        // last: what was measured is kept whatever becomes of its drawing
        crate::write_result(folder, "camera.svg", shown::camera_figure(self)?)
    }

    /// Where the points that a view shows are projected to, px; of those that the lens sees.
    fn projected_points(&self, view: usize) -> Vec<Point2> {
        let pose = &self.calibration.poses[view];
        let project = |point| self.calibration.lens.project(pose.apply(point));
        self.views.views[view].points(&self.target.points()).into_iter().filter_map(project).collect()
    }
}

/// Calibrates the camera, and writes `camera.toml`, `camera.yaml` (OpenCV's), `views.csv`, `left_out.csv` and `camera.svg` where a folder is given.
/// `interrupt` is asked before every picture whether to end.
///
/// # Errors
/// A [`Diagnostic`] when the source cannot be read, too few pictures show the board, they do not determine the lens, or it was interrupted.
pub fn camera(request: &Request, interrupt: Interrupt<'_>) -> Result<Camera> {
    let camera = calibrate_camera(request, interrupt)?;
    request.out.as_ref().map_or(Ok(()), |folder| camera.write_results(folder))?;
    Ok(camera)
}

/// The folder of a source's results beside it.
pub fn beside(source: &Path) -> PathBuf {
    let mut name = source.file_name().unwrap_or_default().to_owned();
    name.push(".camera");
    source.with_file_name(name)
}

fn calibrate_camera(request: &Request, interrupt: Interrupt<'_>) -> Result<Camera> {
    let target = request.target;
    let views = Views::from_source((&request.source, request.every), &target, interrupt)?;
    let distortion = if request.fisheye { Distortion::Fisheye } else { Distortion::BrownConrady };
    let calibration = calibrate(&views.views, &target.points(), distortion, views.size)
        .map_err(|e| Diagnostic::from(e).in_file(&request.source))?;
    Ok(Camera { calibration, size: views.size, views, target })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_lie_beside_the_film_under_its_whole_name() {
        assert_eq!(beside(Path::new("films/board.mp4")), Path::new("films/board.mp4.camera"));
    }
}
