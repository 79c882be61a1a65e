//! Folders: where everything lies on disk. The one place that builds paths.
//!
//! The paper profile lives in the project itself; the quick profile has the same folders under `target/quick`, so that it
//! never touches what is tracked. Settings, claims and expectations are the project's in both.
//!
//! Stands on: settings (the profile). Never knows: what is in a file.

use std::path::{Path, PathBuf};

use crate::entry::Kind;
use crate::needs::Id;
use crate::settings::Profile;

/// The folders of one profile of one project.
#[derive(Debug, Clone)]
pub struct Folders {
    project: PathBuf,
    base: PathBuf,
}

impl Folders {
    /// The folders of a profile in the project at `project`.
    pub fn new(project: &Path, profile: Profile) -> Self {
        let base = match profile {
            Profile::Paper => project.to_path_buf(),
            Profile::Quick => project.join("target").join("quick"),
        };
        Self { project: project.to_path_buf(), base }
    }

    /// Recordings.
    pub fn raw(&self) -> PathBuf {
        self.base.join("data").join("raw")
    }

    /// One recording, from its place with `/` between folders.
    pub fn raw_file(&self, place: &str) -> PathBuf {
        place.split('/').fold(self.raw(), |path, part| path.join(part))
    }

    /// Records.
    pub fn processed(&self) -> PathBuf {
        self.base.join("data").join("processed")
    }

    /// One record's folder.
    pub fn record(&self, id: &Id) -> PathBuf {
        id.subject.split('/').fold(self.processed().join(id.stage), |path, part| path.join(part)).join("record")
    }

    /// Where the picture of what went wrong with a record lies.
    pub fn picture(&self, id: &Id) -> PathBuf {
        self.record(id).with_file_name("fault.png")
    }

    /// Where a record's files lie while they are being written.
    pub fn unfinished(&self, id: &Id) -> PathBuf {
        self.record(id).with_file_name("record.unfinished")
    }

    /// Where an outdated record waits for its successor to take its name.
    pub fn outdated(&self, id: &Id) -> PathBuf {
        self.record(id).with_file_name("record.outdated")
    }

    /// Where the products of a figure or table are laid for readers; nothing for stages.
    pub fn shown(&self, kind: Kind) -> Option<PathBuf> {
        match kind {
            Kind::Stage => None,
            Kind::Figure => Some(self.base.join("figures")),
            Kind::Table => Some(self.base.join("paper").join("tables")),
        }
    }

    /// The page that shows everything.
    pub fn page(&self) -> PathBuf {
        self.base.join("figures").join("index.html")
    }

    /// The numbers that leave the house.
    pub fn metrics(&self) -> PathBuf {
        self.processed().join("metrics.json")
    }

    /// What runs remember of the files that they read.
    pub fn hashes(&self) -> PathBuf {
        self.processed().join(".hashes.json")
    }

    /// The description of everything for archives.
    pub fn crate_file(&self) -> PathBuf {
        self.processed().join("ro-crate-metadata.json")
    }

    /// Held by the one run that may write.
    pub fn lock(&self) -> PathBuf {
        self.processed().join(".lock")
    }

    /// The settings of both profiles.
    pub fn settings(&self) -> PathBuf {
        self.project.join("study.toml")
    }

    /// The claims of the paper.
    pub fn claims(&self) -> PathBuf {
        self.project.join("paper").join("claims.toml")
    }

    /// What each number is expected to be, and what was published.
    pub fn expected(&self) -> PathBuf {
        self.project.join("paper").join("expected.toml")
    }

    /// The paper's source, the project's in both profiles.
    pub fn paper_source(&self) -> PathBuf {
        self.project.join("paper")
    }

    /// The paper's source with everything in place.
    pub fn paper_in_place(&self) -> PathBuf {
        self.processed().join("paper")
    }

    /// The crates, where the tests stand that the paper's equations name.
    pub fn crates(&self) -> PathBuf {
        self.project.join("pipeline")
    }

    /// A path as a person in the project's folder would type it.
    pub fn tell(&self, path: &Path) -> String {
        path.strip_prefix(&self.project).unwrap_or(path).display().to_string()
    }
}
