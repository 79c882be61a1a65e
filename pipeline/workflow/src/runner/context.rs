//! The context of one running stage: its raw files, its elapsed time, its progress line.

use std::path::PathBuf;
use std::time::Instant;

use diagnostics::{Diagnostic, Result, input};

use super::folders::Folders;
use super::report::Line;
use crate::stage::{RawFile, StageContext};

/// The context that the runner gives to a stage.
pub(crate) struct RunContext<'a> {
    folders: &'a Folders,
    raw: &'a [RawFile],
    began: Instant,
    line: Line,
}

impl<'a> RunContext<'a> {
    /// A context with these raw files; its time begins now.
    pub fn new(folders: &'a Folders, raw: &'a [RawFile], line: Line) -> Self {
        Self { folders, raw, began: Instant::now(), line }
    }
}

impl StageContext for RunContext<'_> {
    fn bytes(&self, name: &str) -> Result<Vec<u8>> {
        let path = self.path(name)?;
        input::read(&path, input::MESH).map_err(|e| {
            let problem = format!("{} cannot be read", self.folders.display(&path));
            Diagnostic::new(problem, &e, "put the file there, or correct its name on the card").caused_by(e)
        })
    }

    fn path(&self, name: &str) -> Result<PathBuf> {
        let file = self.raw.iter().find(|file| file.name == name).ok_or_else(|| {
            Diagnostic::new(
                format!("no recording is called `{name}` here"),
                "the stage did not declare it",
                "report it",
            )
        })?;
        Ok(self.folders.raw_file(&file.path))
    }

    fn display_path(&self, name: &str) -> String {
        self.path(name).map_or_else(|_| name.into(), |path| self.folders.display(&path))
    }

    fn seconds(&self) -> f64 {
        self.began.elapsed().as_secs_f64()
    }

    fn thread_seconds(&self) -> f64 {
        super::usage::thread_seconds().unwrap_or_else(|| self.seconds())
    }

    fn progress(&self, fraction: f64, step: &str) {
        self.line.progress(fraction, step);
    }
}
