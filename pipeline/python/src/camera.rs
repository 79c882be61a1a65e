//! Calibration of a camera from a film or a folder of pictures of a board.

use std::path::PathBuf;

use instruments::calibrate::{Request, camera};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use track::board::{Target, TargetKind};
use track::lens::Distortion;

use crate::arrays::numpy_array;
use crate::errors::{Kind, of_diagnostic};
use crate::interrupt::run_watched;

/// What is asked for, in the names of the command line.
#[derive(FromPyObject)]
pub(crate) struct Asked {
    #[pyo3(item)]
    source: PathBuf,
    #[pyo3(item)]
    columns: usize,
    #[pyo3(item)]
    rows: usize,
    #[pyo3(item)]
    square: f64,
    #[pyo3(item)]
    dots: bool,
    #[pyo3(item)]
    fisheye: bool,
    #[pyo3(item)]
    every: usize,
    #[pyo3(item)]
    out: Option<PathBuf>,
}

impl From<Asked> for Request {
    fn from(asked: Asked) -> Self {
        let Asked { source, columns, rows, square, dots, fisheye, every, out } = asked;
        let kind = if dots { TargetKind::Dots } else { TargetKind::Checkerboard };
        Self { source, target: Target::new(kind, [columns, rows], square), fisheye, every, out }
    }
}

/// Calibrates a camera: whether it is a `fisheye`, `size` (px), `mean` and `covariance` of the numbers of its lens, `reprojection_error` (px),
/// and of each of its `views` the name, the error (px), and the pose: `rotation` by rows and `translation` (m).
#[pyfunction]
pub(crate) fn calibrate(py: Python<'_>, asked: Asked) -> PyResult<Bound<'_, PyDict>> {
    let request = Request::from(asked);
    let calibrated_camera = run_watched(py, move |signals| {
        let calibrated = camera(&request, Some(&*signals.interrupt()));
        calibrated.map_err(|diagnostic| of_diagnostic(&diagnostic, Kind::Input))
    })?;
    let (is, views) = (&calibrated_camera.calibration, calibrated_camera.views());
    let count = is.lens.count();
    let covariance = is.covariance.iter().take(count).flat_map(|row| row[..count].to_vec()).collect();
    let record = PyDict::new(py);
    record.set_item("fisheye", is.lens.distortion == Distortion::Fisheye)?;
    record.set_item("size", calibrated_camera.size)?;
    record.set_item("mean", numpy_array(py, is.lens.values()[..count].to_vec()))?;
    record.set_item("covariance", numpy_array(py, covariance))?;
    record.set_item("reprojection_error", is.reprojection_px)?;
    record.set_item("views", views)?;
    record.set_item(
        "errors",
        numpy_array(py, (0..views.len()).map(|view| calibrated_camera.reprojection_error(view)).collect()),
    )?;
    record.set_item("rotation", numpy_array(py, is.poses.iter().flat_map(|pose| pose.rotation).flatten().collect()))?;
    record.set_item("translation", numpy_array(py, is.poses.iter().flat_map(|pose| pose.translation).collect()))?;
    Ok(record)
}
