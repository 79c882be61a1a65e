//! Whether a record of a project may be read: by the plan of the command line, of cards, settings and recordings as they are now.

use std::path::PathBuf;

use diagnostics::Result;
use pyo3::prelude::*;
use workflow::runner::Options;
use workflow::settings::Profile;

use crate::errors::{Kind, of_diagnostic};

/// Nothing is made, so that how it would be made does not matter.
const OPTIONS: Options = Options { quiet: true, jobs: None, memory: None, keep_going: true, min_free_memory: 0.0 };

/// Holds that the record `name` and all that it reads are up to date in a profile of the project at `root`.
#[pyfunction]
pub(crate) fn require_record(py: Python<'_>, root: PathBuf, profile: &str, name: String) -> PyResult<()> {
    let profile = Profile::ALL.into_iter().find(|known| known.name() == profile).unwrap_or(Profile::Paper);
    let require = || -> Result<()> {
        let (runner, unreadable) = study::open(&root, profile, OPTIONS)?;
        study::readable(&unreadable, name.split('/').nth(1))?;
        runner.require(&[name])
    };
    py.detach(require).map_err(|diagnostic| of_diagnostic(&diagnostic, Kind::Input))
}
