//! The lock: one run writes at a time; the system lets go of it when a run ends, however it ends.
//!
//! Stands on: folders. Never knows: what is run.

use std::fs::{self, File, TryLockError};
use std::thread::sleep;
use std::time::Duration;

use super::folders::Folders;
use crate::fault::{Fault, Outcome};

/// How often a lock that is held is asked for again, and how long after: a run that ends, and a program that was started beside it, still
/// hold it for an instant.
const TRIES: usize = 20;
const PAUSE: Duration = Duration::from_millis(10);

/// Held while a run writes.
pub struct Lock {
    _file: File,
}

impl Lock {
    /// Takes the lock.
    ///
    /// # Errors
    /// A [`Fault`] when another run holds it, or its file cannot be made.
    pub fn take(folders: &Folders) -> Outcome<Self> {
        let path = folders.lock();
        let open = || {
            fs::create_dir_all(folders.processed())?;
            File::options().create(true).append(true).open(&path)
        };
        let file = open().map_err(|e| {
            Fault::new(format!("{} cannot be made", folders.tell(&path)), e, "mend the folder's permissions")
        })?;
        let mut asked = file.try_lock();
        for _ in 0..TRIES {
            if !matches!(asked, Err(TryLockError::WouldBlock)) {
                break;
            }
            sleep(PAUSE);
            asked = file.try_lock();
        }
        match asked {
            Ok(()) => Ok(Self { _file: file }),
            Err(TryLockError::WouldBlock) => Err(Fault::new(
                "another run is at work in this study",
                format!("it holds {}", folders.tell(&path)),
                "wait until it has ended, or end it; nothing it has finished is lost",
            )),
            Err(TryLockError::Error(e)) => {
                Err(Fault::new(format!("{} cannot be locked", folders.tell(&path)), e, "use a local disk"))
            }
        }
    }
}
