//! Locks: one process makes a record at a time, on whichever machine it runs.
//!
//! A process writes one file with its name, and a lock is a hard link to that file: the link is made in one step, also on NFS, and shows
//! its holder from the first instant. The file is written again at intervals, so that the date of every lock of a living process is
//! recent.
//!
//! A lock is abandoned when its holder ran on this machine and runs no more, an earlier boot of it included, or when its date, by the clock
//! of the file server, is off by more than the age limit: long ago, or in the future, which no living process writes. A file that is not
//! understood was written by no process, since a lock is a link to a whole file, and is abandoned after seconds. Whoever removes an abandoned lock must first take the lock named after it and its holder. That right is taken by
//! the same rules, and with it the holder is read again: of several processes one removes the lock that all of them found, and none a
//! lock that was taken meanwhile.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime};

use super::atomic::write_synced;
use super::process::Process;
use diagnostics::{Diagnostic, Result, input};

/// How often a process shows that it lives.
const HEARTBEAT: Duration = Duration::from_secs(30);
/// The age at which a lock from another machine is abandoned: NFS clients may hold attributes for a minute, and a busy server answers late.
const AGE_LIMIT: Duration = Duration::from_secs(600);
/// The same of a file that is not understood: as long as a file server may show a new file without its bytes.
const AGE_LIMIT_OF_NO_PROCESS: Duration = Duration::from_secs(3);
/// How often a lock that is released while it is looked at is asked for.
const TRIES: usize = 100;

/// This process as a holder of locks, until it is dropped.
pub struct Holder {
    process: Process,
    /// The file that every lock of this process is a link to.
    file: PathBuf,
    /// A link gives no answer when its reply is lost: what this process holds is distinguished from what it has just taken.
    held: Mutex<BTreeSet<PathBuf>>,
    /// When this process first saw each lock that it does not understand.
    seen: Mutex<BTreeMap<PathBuf, Instant>>,
    heart: Option<(Sender<()>, JoinHandle<()>)>,
}

/// A lock that is held until it is dropped.
pub struct Lock<'a> {
    holder: &'a Holder,
    path: PathBuf,
}

/// What came of asking for a lock.
pub enum Attempt<'a> {
    /// It is held now.
    Held(Lock<'a>),
    /// Another holds it.
    Busy(Process),
}

impl Holder {
    /// Enters this process in the folder of holders.
    ///
    /// # Errors
    /// A [`Diagnostic`] when the folder cannot be written.
    pub fn enter(folder: &Path) -> Result<Self> {
        let process = Process::this();
        let path = folder.join(&process.token);
        let write = || {
            fs::create_dir_all(folder)?;
            let text = serde_json::to_vec(&process).map_err(io::Error::other)?;
            write_synced(&path, &text)?;
            let file = File::options().write(true).open(&path)?;
            Ok((text, file))
        };
        let (text, file) = write().map_err(|e: io::Error| write_error(&path, e))?;
        let (held, seen) = (Mutex::default(), Mutex::default());
        let holder = Self { process, file: path, held, seen, heart: Some(start_heartbeat(file, text)) };
        holder.remove_abandoned(folder);
        Ok(holder)
    }

    /// Asks for a lock without waiting for it.
    ///
    /// # Errors
    /// A [`Diagnostic`] when its file cannot be made.
    pub fn ask(&self, path: &Path) -> Result<Attempt<'_>> {
        if !self.held_locks().insert(path.to_owned()) {
            return Ok(Attempt::Busy(self.process.clone()));
        }
        let asked = self.ask_others(path);
        if !matches!(asked, Ok(Attempt::Held(_))) {
            self.held_locks().remove(path);
        }
        asked
    }

    fn ask_others(&self, path: &Path) -> Result<Attempt<'_>> {
        for _ in 0..TRIES {
            if self.link_file(path).map_err(|e| write_error(path, e))? {
                return Ok(Attempt::Held(Lock { holder: self, path: path.to_owned() }));
            }
            let Some(owner) = read_owner(path).map_err(|e| read_error(path, e))? else { continue };
            if self.is_alive(&owner, path) {
                return Ok(Attempt::Busy(owner));
            }
            let right = match self.ask(&right_to_remove(path, &owner))? {
                Attempt::Held(right) => right,
                busy => return Ok(busy),
            };
            if read_owner(path).is_ok_and(|now| now.is_some_and(|now| now.token == owner.token)) {
                let _ = fs::remove_file(path);
            }
            drop(right);
        }
        Err(write_error(path, io::Error::other("it appears and vanishes")))
    }

    /// Makes the lock's file; whether it is this process's.
    fn link_file(&self, path: &Path) -> io::Result<bool> {
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        match fs::hard_link(&self.file, path) {
            Ok(()) => Ok(true),
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => Ok(self.owns_lock(path)),
            Err(e) => Err(e),
        }
    }

    fn owns_lock(&self, path: &Path) -> bool {
        read_owner(path).is_ok_and(|now| now.is_some_and(|now| now.token == self.process.token))
    }

    fn is_alive(&self, owner: &Process, path: &Path) -> bool {
        if owner.is_beside(&self.process) {
            return owner.runs();
        }
        if owner.is_of_an_earlier_boot(&self.process) {
            return false;
        }
        let date = |path: &Path| fs::metadata(path).and_then(|metadata| metadata.modified()).ok();
        // Both dates are the file server's, since clocks of machines differ. Its own is as old as the last beat.
        let age = |now: SystemTime, then: SystemTime| now.duration_since(then).unwrap_or_else(|ahead| ahead.duration());
        let age = date(&self.file).zip(date(path)).map_or(Duration::MAX, |(now, then)| age(now, then));
        age < AGE_LIMIT && !(owner.is_unknown() && self.seen_for(path).max(age) > AGE_LIMIT_OF_NO_PROCESS)
    }

    /// For how long this process has seen a lock that it does not understand. Its own date may be half a minute older than that of the lock.
    fn seen_for(&self, path: &Path) -> Duration {
        let mut first_seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        first_seen.entry(path.to_owned()).or_insert_with(Instant::now).elapsed()
    }

    /// Removes the files of processes that were killed.
    fn remove_abandoned(&self, folder: &Path) {
        for path in fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()) {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let abandoned = |owner: Process| self.process.has_ended_here(&name) || !self.is_alive(&owner, &path);
            if read_owner(&path).is_ok_and(|owner| owner.is_some_and(abandoned)) {
                let _ = fs::remove_file(&path);
            }
        }
    }

    fn held_locks(&self) -> std::sync::MutexGuard<'_, BTreeSet<PathBuf>> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Holder {
    fn drop(&mut self) {
        if let Some((stop, heart)) = self.heart.take() {
            drop(stop);
            let _ = heart.join();
        }
        let _ = fs::remove_file(&self.file);
    }
}

impl Lock<'_> {
    /// Whether it is held still: a process that was suspended for longer than the age limit may have lost it.
    pub fn is_held(&self) -> bool {
        self.holder.owns_lock(&self.path)
    }

    /// Removes rights to remove former holders of this lock, which killed processes left: none of those can hold it again.
    pub fn sweep(&self) {
        let name = self.path.file_name().unwrap_or_default().to_string_lossy() + ".";
        let entries = self.path.parent().map(fs::read_dir).into_iter().flatten().flatten().flatten();
        for entry in entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(&*name)) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

impl Drop for Lock<'_> {
    fn drop(&mut self) {
        if self.is_held() {
            let _ = fs::remove_file(&self.path);
        }
        self.holder.held_locks().remove(&self.path);
    }
}

/// The process that holds a lock; none when nobody does. A file that is not understood is held by an unknown process of another machine.
fn read_owner(path: &Path) -> io::Result<Option<Process>> {
    match path.symlink_metadata().and_then(|metadata| input::regular_file(&metadata)) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
        regular => regular?,
    };
    // It may have been released since.
    let text = input::read(path, input::PAGE).ok();
    Ok(text.map(|text| serde_json::from_slice(&text).unwrap_or_else(|_| Process::unknown())))
}

/// The lock that must be held by whoever removes the lock at `path` of an abandoned holder.
fn right_to_remove(path: &Path, owner: &Process) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{}", owner.token));
    path.with_file_name(name)
}

/// A thread that writes the same bytes again at intervals, until its sender is dropped.
fn start_heartbeat(mut file: File, text: Vec<u8>) -> (Sender<()>, JoinHandle<()>) {
    let (stop, stopped) = channel();
    let heart = std::thread::spawn(move || {
        while stopped.recv_timeout(HEARTBEAT) == Err(RecvTimeoutError::Timeout) {
            // A beat that fails is followed by the next one; twenty may fail before the lock counts as abandoned.
            let _ = file.seek(SeekFrom::Start(0)).and_then(|_| file.write_all(&text)).and_then(|()| file.sync_all());
        }
    });
    (stop, heart)
}

fn read_error(path: &Path, error: io::Error) -> Diagnostic {
    let action = format!("remove {}: no lock is one", path.display());
    Diagnostic::new(format!("the lock {} cannot be read", path.display()), &error, action).caused_by(error)
}

fn write_error(path: &Path, error: io::Error) -> Diagnostic {
    Diagnostic::new(
        format!("the lock {} cannot be made", path.display()),
        &error,
        "free some disk space, correct the folder's permissions, or use a file system that has hard links",
    )
    .caused_by(error)
}

#[cfg(test)]
mod tests;
