//! Identification of a body from recordings of its free vibration.

use std::path::PathBuf;

use pyo3::prelude::*;
use sysid::free_vibration::{FittedLaw, page, run};
use sysid::{inflation_test, joint_fit};

use crate::case::case_exception;
use crate::errors::input_error;
use crate::interrupt::run_watched;

/// Name, parameters with units, mean, covariance row by row, criterion, and whether the recordings support it.
type Law = (&'static str, Vec<(&'static str, &'static str)>, Vec<f64>, Vec<f64>, f64, bool);

/// Fits the laws of a page to its recordings below `root` and writes its table, metrics and figure into `out`: the report as
/// text, the folder, and every law.
#[pyfunction]
pub(crate) fn fit(
    py: Python<'_>,
    root: PathBuf,
    asked: PathBuf,
    out: Option<PathBuf>,
) -> PyResult<(String, PathBuf, Vec<Law>)> {
    let path = page(&root, &asked);
    if joint_fit::is_page(&path) {
        let what = format!("{} is the page of a tensile test or of a joint fit", path.display());
        return Err(input_error(
            what,
            "laws are fitted to free vibrations",
            "run study fit on it, or name another page",
        ));
    }
    if inflation_test::is_page(&path) {
        let message = format!("{} is the page of an inflation test", path.display());
        return Err(input_error(
            message,
            "laws are fitted to free vibrations",
            "run study fit on it, or name another page",
        ));
    }
    let (report, folder) = run_watched(py, move |signals| {
        run(&root, &path, out.as_deref(), Some(signals.interrupt())).map_err(|diagnostic| case_exception(&diagnostic))
    })?;
    Ok((report.to_string(), folder, report.laws().into_iter().map(law_record).collect()))
}

fn law_record(of: FittedLaw) -> Law {
    let covariance = of.covariance.transpose().iter().copied().collect();
    (of.name, of.parameters, of.mean, covariance, of.criterion, of.supported)
}
