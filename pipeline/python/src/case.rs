//! Cases: read, parsed from text, and run as the command line runs them.

use std::path::PathBuf;
use std::sync::Arc;

use diagnostics::{Diagnostic, input};
use pyo3::prelude::*;
use simulate::case::{parse, read};
use simulate::{Budget, RunOptions};

use crate::errors::{Kind, input_error, of_diagnostic};
use crate::interrupt::run_watched;
use crate::mesh::Mesh;

/// A case with the folder that its files are named in.
#[pyclass(frozen, module = "softfish._core")]
pub(crate) struct Case {
    pub(crate) case: Arc<simulate::case::Case>,
    /// As TOML.
    text: String,
    pub(crate) path: PathBuf,
}

/// The class of an error of a case.
pub(crate) fn case_exception(diagnostic: &Diagnostic) -> PyErr {
    of_diagnostic(diagnostic, Kind::Case)
}

#[pymethods]
impl Case {
    /// The case in a file.
    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<Self> {
        let input_error = |diagnostic: Diagnostic| case_exception(&diagnostic.in_file_unless_named(&path));
        let case = read(&path).map_err(input_error)?;
        let unread = |error| Diagnostic::io(&path, error, "name a case, a page of TOML");
        let text = input::read_text(&path, input::PAGE).map_err(|error| case_exception(&unread(error)))?;
        Ok(Self { case: Arc::new(case), text, path })
    }

    /// The case in a text of TOML; `path` stands for its file, in whose folder meshes are found.
    #[staticmethod]
    fn parse(text: &str, path: PathBuf) -> PyResult<Self> {
        let case = parse(text, &path).map_err(|diagnostic| case_exception(&diagnostic))?;
        Ok(Self { case: Arc::new(case), text: text.to_owned(), path })
    }

    /// The case in a text of JSON with the keys of a case.
    #[staticmethod]
    fn parse_json(text: &str, path: PathBuf) -> PyResult<Self> {
        let unreadable =
            |error: String| input_error("the case cannot be read", error, "give numbers, texts, lists and tables");
        let value: serde_json::Value = serde_json::from_str(text).map_err(|error| unreadable(error.to_string()))?;
        let table = toml::to_string(&value).map_err(|error| unreadable(error.to_string()))?;
        Self::parse(&table, path)
    }

    /// It as a text of TOML.
    fn text(&self) -> &str {
        &self.text
    }

    /// Numbers of what it holds, in words.
    fn summary(&self) -> String {
        let (case, counted) =
            (&*self.case, |count: usize, word: &str| format!("{count} {word}{}", if count == 1 { "" } else { "s" }));
        let solved = match (&case.statics, &case.dynamic) {
            (Some(set), _) if set.arc_length.is_some() => format!("path to level {}", set.levels[set.levels.len() - 1]),
            (Some(set), _) => counted(set.levels.len(), "level"),
            (None, Some(set)) => format!("motion of {} s", set.duration),
            (None, None) => String::new(),
        };
        let parts = [
            counted(case.region.len(), "region"),
            counted(case.chamber.len(), "chamber"),
            counted(case.load.len(), "load"),
            solved,
        ];
        parts.join(", ")
    }

    /// The mesh that it names.
    fn mesh(&self, py: Python<'_>) -> PyResult<Mesh> {
        let (folder, case) = (self.case_folder(), self.case.clone());
        run_watched(py, move |_| {
            let loaded = simulate::load(&case, &folder);
            loaded.map(Mesh::of).map_err(|diagnostic| of_diagnostic(&diagnostic, Kind::Mesh))
        })
    }
}

impl Case {
    /// Where its files are named from.
    pub(crate) fn case_folder(&self) -> PathBuf {
        self.path.parent().map(PathBuf::from).unwrap_or_default()
    }
}

/// Runs the case in a file as the command line does, and writes its tables and frames into `out`. Returns the folder,
/// the number of degrees of freedom and that of levels or steps.
#[pyfunction]
pub(crate) fn run_case(
    py: Python<'_>,
    path: PathBuf,
    output: (Option<PathBuf>, bool),
    budget: (Option<usize>, Option<usize>, Option<f64>),
) -> PyResult<(PathBuf, usize, usize)> {
    let (out, quiet) = output;
    let (max_iterations, max_cutbacks, timeout) = budget;
    let budget = Budget { max_iterations, max_cutbacks, timeout };
    let summary = run_watched(py, move |signals| {
        let options = RunOptions { out, quiet, interrupt: Some(signals.interrupt()), budget };
        simulate::run_with(&path, options).map_err(|diagnostic| case_exception(&diagnostic))
    })?;
    Ok((summary.folder, summary.dofs, summary.solved))
}
