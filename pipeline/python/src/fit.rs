//! Identification of a body from recordings of its free vibration.

use std::path::PathBuf;

use pyo3::prelude::*;
use sysid::free_vibration::{FittedLaw, page, run};

use crate::case::refusal;

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
    let found = py.detach(|| run(&root, &path, out.as_deref()));
    let (report, folder) = found.map_err(|diagnostic| refusal(&diagnostic))?;
    Ok((report.to_string(), folder, report.laws().into_iter().map(law).collect()))
}

fn law(of: FittedLaw) -> Law {
    let covariance = of.covariance.transpose().iter().copied().collect();
    (of.name, of.parameters, of.mean, covariance, of.criterion, of.supported)
}
