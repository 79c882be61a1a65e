//! Markers tracked through a film.

use std::path::PathBuf;

use instruments::film::{self, Request, Starts, Tracks};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::numpy_array;
use crate::errors::{Kind, of_diagnostic};
use crate::interrupt::run_watched;

/// What is asked for, in the names of the command line.
#[derive(FromPyObject)]
pub(crate) struct Asked {
    #[pyo3(item)]
    film: PathBuf,
    #[pyo3(item)]
    at: Vec<[f64; 2]>,
    #[pyo3(item)]
    find: Option<usize>,
    #[pyo3(item)]
    region: Option<[f64; 4]>,
    #[pyo3(item)]
    radius: f64,
    #[pyo3(item)]
    hidden: f64,
    #[pyo3(item)]
    first: usize,
    #[pyo3(item)]
    last: Option<usize>,
    #[pyo3(item)]
    overlay: bool,
    #[pyo3(item)]
    out: Option<PathBuf>,
}

impl From<Asked> for Request {
    fn from(asked: Asked) -> Self {
        let Asked { film, at, find, region, radius, hidden, first, last, overlay, out } = asked;
        let starts = find.map_or(Starts::At(at), |count| Starts::Find { count, region });
        Self { film, starts, frames: (first, last), radius, hidden, overlay, out }
    }
}

/// Tracks markers: `first`, `time` (s), and, marker by marker and frame by frame, `position` (px), `covariance` (px²), `residual` and `seen`.
#[pyfunction]
pub(crate) fn track(py: Python<'_>, asked: Asked) -> PyResult<Bound<'_, PyDict>> {
    let request = Request::from(asked);
    let Tracks { first, time, markers } = run_watched(py, move |signals| {
        let tracked = film::track(&request, Some(&*signals.interrupt()));
        tracked.map_err(|diagnostic| of_diagnostic(&diagnostic, Kind::Input))
    })?;
    let points = || markers.iter().flatten();
    let record = PyDict::new(py);
    record.set_item("first", first)?;
    record.set_item("time", numpy_array(py, time))?;
    record.set_item("position", numpy_array(py, points().flat_map(|o| o.at).collect()))?;
    record.set_item("covariance", numpy_array(py, points().flat_map(|o| o.covariance).flatten().collect()))?;
    record.set_item("residual", numpy_array(py, points().map(|o| o.residual).collect()))?;
    record.set_item("seen", points().map(|o| o.seen).collect::<Vec<bool>>())?;
    Ok(record)
}
