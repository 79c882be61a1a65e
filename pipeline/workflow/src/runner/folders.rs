//! Folders: the layout on disk. The one place that builds paths.
//!
//! The paper profile uses the project itself; every other has the same folders under `target/<profile>`, so that it
//! never changes tracked files. Settings, claims and expectations are the project's in all of them.

use std::path::{Path, PathBuf};

use crate::entry::Kind;
use crate::needs::RecordId;
use crate::settings::Profile;

/// The name of a record's folder.
const RECORD: &str = "record";

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
            profile => project.join("target").join(profile.name()),
        };
        Self { project: project.to_path_buf(), base }
    }

    /// The project.
    pub(crate) fn project(&self) -> &Path {
        &self.project
    }

    /// The folder that holds all others of the profile.
    pub fn base(&self) -> &Path {
        &self.base
    }

    /// Recordings.
    pub fn raw(&self) -> PathBuf {
        self.base.join("data").join("raw")
    }

    /// One recording, from its relative path with `/` between folders.
    pub fn raw_file(&self, relative_path: &str) -> PathBuf {
        relative_path.split('/').fold(self.raw(), |path, part| path.join(part))
    }

    /// Records.
    pub fn processed(&self) -> PathBuf {
        self.base.join("data").join("processed")
    }

    /// One record's folder.
    pub fn record(&self, id: &RecordId) -> PathBuf {
        id.subject.split('/').fold(self.processed().join(id.stage), |path, part| path.join(part)).join(RECORD)
    }

    /// The name of every record's folder, inside that of its subject.
    pub fn record_folder_name(&self) -> &'static str {
        RECORD
    }

    /// The picture of a record's error.
    pub fn picture(&self, id: &RecordId) -> PathBuf {
        self.record(id).with_file_name("diagnostic.png")
    }

    /// The folder of a record while it is being written.
    pub fn unfinished(&self, id: &RecordId) -> PathBuf {
        self.record(id).with_file_name("record.unfinished")
    }

    /// The folder of an outdated record while its successor is renamed.
    pub(crate) fn outdated(&self, id: &RecordId) -> PathBuf {
        self.record(id).with_file_name("record.outdated")
    }

    /// The folder of a kind's copies for readers; none for stages.
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

    /// The file of metrics.
    pub fn metrics(&self) -> PathBuf {
        self.processed().join("metrics.json")
    }

    /// Hashes of the files read by runs.
    pub fn hashes(&self) -> PathBuf {
        self.processed().join(".hashes.json")
    }

    /// The description of everything for archives.
    pub fn crate_file(&self) -> PathBuf {
        self.processed().join("ro-crate-metadata.json")
    }

    /// Hashes of the files read for one record, written where it is made alone.
    pub(crate) fn record_hashes(&self, id: &RecordId) -> PathBuf {
        self.record(id).with_file_name("record.hashes.json")
    }

    /// Held by the process that makes a record.
    pub(crate) fn record_lock(&self, id: &RecordId) -> PathBuf {
        self.record(id).with_file_name("record.lock")
    }

    /// Held by the process that writes the files derived from all records.
    pub(crate) fn publication_lock(&self) -> PathBuf {
        self.processed().join("publication.lock")
    }

    /// The folders of files that are derived from records.
    pub(crate) fn written_to(&self) -> Vec<PathBuf> {
        let shown = [Kind::Figure, Kind::Table].into_iter().filter_map(|kind| self.shown(kind));
        let paper = self.paper_in_place();
        shown.chain([self.processed(), paper.join("sections"), paper]).collect()
    }

    /// The processes that hold locks.
    pub(crate) fn lock_holders(&self) -> PathBuf {
        self.processed().join(".holders")
    }

    /// The settings of both profiles.
    pub fn settings(&self) -> PathBuf {
        self.project.join("study.toml")
    }

    /// The claims of the paper.
    pub fn claims(&self) -> PathBuf {
        self.project.join("paper").join("claims.toml")
    }

    /// Expected and published values of the metrics.
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

    /// The crates, with the tests named by the paper's equations.
    pub fn crates(&self) -> PathBuf {
        self.project.join("pipeline")
    }

    /// A path relative to the project's folder, for messages.
    pub fn display(&self, path: &Path) -> String {
        path.strip_prefix(&self.project).unwrap_or(path).display().to_string()
    }
}
