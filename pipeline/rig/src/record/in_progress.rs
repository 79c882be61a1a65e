//! A recording in progress: its partial folder, and a lock for each of its parts.
//!
//! A part is made under its lock and marked by a checkpoint, so that no two processes write the same file, on whichever machines they
//! run, and none makes what another has made. The folder itself is begun and finished under a lock as well.

use std::path::PathBuf;
use std::time::Duration;

use diagnostics::{Diagnostic, Result, input};
use workflow::runner::{Attempt, Holder, Lock};

use super::{CALIBRATION, Request};
use crate::checkpoint;
use crate::folder;
use crate::specimen::Specimen;
use crate::stamp::{self, FolderState};

/// The folder of the locks, among the specimens.
const LOCKS: &str = ".locks";
/// The lock of whoever begins or finishes the partial folder.
const FOLDER: &str = "folder";
/// How often a lock that another holds is asked for: a part takes seconds to minutes.
const POLL: Duration = Duration::from_millis(200);

/// A recording that this process works on.
pub(super) struct InProgress<'a> {
    request: &'a Request<'a>,
    name: &'a str,
    stamp: String,
    /// The finished recording.
    at: PathBuf,
    /// The partial folder.
    pub(super) folder: PathBuf,
    holder: Holder,
}

impl<'a> InProgress<'a> {
    /// The recording of `specimen`, of which nothing is begun yet.
    ///
    /// # Errors
    /// When the folder of the locks cannot be written.
    pub(super) fn of_specimen(specimen: &'a Specimen, request: &'a Request<'a>) -> Result<Self> {
        let (into, name) = (request.into, &*specimen.name);
        let holder = Holder::enter(&into.join(LOCKS).join("holders"))?;
        let stamp = stamp::stamp_text(specimen, request.profile);
        Ok(Self { request, name, stamp, at: into.join(name), folder: folder::partial_folder(into, name), holder })
    }

    /// Waits for the lock of a part.
    ///
    /// # Errors
    /// When its file cannot be made.
    pub(super) fn lock_part(&self, part: &str) -> Result<Lock<'_>> {
        let path = self.request.into.join(LOCKS).join(self.name).join(part);
        let mut is_told = false;
        loop {
            match self.holder.ask(&path)? {
                Attempt::Held(lock) => {
                    lock.sweep();
                    return Ok(lock);
                }
                Attempt::Busy(_) if is_told => {}
                Attempt::Busy(other) => {
                    is_told = true;
                    let part_name = format!("{}/{part}", self.name);
                    self.request.progress.print_line("wait", &part_name, &format!("{other} works on it"));
                }
            }
            std::thread::sleep(POLL);
        }
    }

    /// Begins the partial folder, or takes up what is there; returns whether anything is left to be made.
    ///
    /// # Errors
    /// When the folder was not made by the bench, or the partial folder cannot be made.
    pub(super) fn begin_recording(&self) -> Result<bool> {
        let _lock = self.lock_part(FOLDER)?;
        if stamp::inspect_folder(&self.at, &self.stamp)? == FolderState::Current {
            return Ok(false);
        }
        // a recording of some parts has checkpoints, a finished one has none
        let taken_up = checkpoint::exist_in(&self.at);
        folder::begin_recording(&self.at, &self.folder, (stamp::FILE, &self.stamp), taken_up)?;
        Ok(true)
    }

    /// Makes a part under its lock and saves it, unless it can be loaded.
    ///
    /// # Errors
    /// Those of making and saving; also when the recording was meanwhile finished or begun anew by another process.
    pub(super) fn make_once<T>(
        &self,
        part: &str,
        load: &dyn Fn() -> Option<T>,
        make: &dyn Fn() -> Result<T>,
        save: &dyn Fn(&T) -> Result<()>,
    ) -> Result<T> {
        let lock = self.lock_part(part)?;
        if let Some(content) = load() {
            return Ok(content);
        }
        let content = make()?;
        // without its stamp the folder is another recording's by now; without the lock another process writes the same files
        let is_own =
            input::read_text(&self.folder.join(stamp::FILE), input::PAGE).is_ok_and(|found| found == self.stamp);
        if !is_own || !lock.is_held() {
            let why = "another process has begun it anew, or took this one for dead";
            return Err(Diagnostic::new(format!("the recording of `{part}` is lost"), why, "run again"));
        }
        save(&content)?;
        Ok(content)
    }

    /// Whether the folder of the recording holds the card, these trials, and with `calibrated` the calibration.
    pub(super) fn shows(&self, trials: &[String], calibrated: bool) -> bool {
        let stamp = input::read_text(&self.at.join(stamp::FILE), input::PAGE);
        stamp.is_ok_and(|stamp| stamp == self.stamp)
            && self.at.join(lab::folder::CARD).is_file()
            && trials.iter().all(|id| checkpoint::load_trial(&self.at, id).is_some())
            && (!calibrated || checkpoint::load_bytes(&self.at, CALIBRATION).is_some())
    }

    /// Shows the partial folder as the recording, with its checkpoints, by which it is taken up again.
    ///
    /// # Errors
    /// When a folder cannot be removed or renamed.
    pub(super) fn show_parts(&self) -> Result<()> {
        let _lock = self.lock_part(FOLDER)?;
        checkpoint::begin(&self.folder)?;
        folder::finish_recording(&self.folder, &self.at)
    }

    /// Replaces the former recording by the partial folder, of which every part is made.
    ///
    /// # Errors
    /// When a folder cannot be removed or renamed.
    pub(super) fn finish_recording(&self) -> Result<()> {
        let _lock = self.lock_part(FOLDER)?;
        // checkpoints last: killed among their removal, an unfinished folder would have lost parts that were made
        folder::finish_recording(&self.folder, &self.at)?;
        checkpoint::clear_all(&self.at)
    }
}
