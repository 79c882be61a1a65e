//! The lock: one run writes at a time; the operating system releases it when the process ends.

use std::fs::{self, File, TryLockError};
use std::thread::sleep;
use std::time::Duration;

use super::folders::Folders;
use diagnostics::{Diagnostic, Result};

/// Number and interval of retries: a run that ends, and a child process started by it, hold the lock for a short time.
const TRIES: usize = 20;
const PAUSE: Duration = Duration::from_millis(10);

/// Held while a run writes.
pub(crate) struct Lock {
    _file: File,
}

impl Lock {
    /// Takes the lock.
    ///
    /// # Errors
    /// A [`Diagnostic`] when another run holds it, or its file cannot be made.
    pub fn take(folders: &Folders) -> Result<Self> {
        let path = folders.lock();
        let open = || {
            fs::create_dir_all(folders.processed())?;
            File::options().create(true).append(true).open(&path)
        };
        let file = open().map_err(|e| {
            Diagnostic::new(format!("{} cannot be made", folders.display(&path)), e, "correct the folder's permissions")
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
            Err(TryLockError::WouldBlock) => Err(Diagnostic::new(
                "another run is at work in this study",
                format!("it holds {}", folders.display(&path)),
                "wait until it has ended, or end it; its finished records are kept",
            )),
            Err(TryLockError::Error(e)) => {
                Err(Diagnostic::new(format!("{} cannot be locked", folders.display(&path)), e, "use a local disk"))
            }
        }
    }
}
