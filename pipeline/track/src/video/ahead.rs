//! A film that is decoded on a thread of its own, some frames ahead of whoever looks at them.

use super::{Film, Frame, Info, VideoError};
use std::path::Path;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;

/// Frames that wait, at most: eight of 1920 × 1080 take 16 MB.
const WAITING: usize = 8;

/// The frames of a film in the order of showing, decoded ahead.
pub struct DecodedAhead {
    info: Info,
    frames: Receiver<Result<Frame, VideoError>>,
}

impl DecodedAhead {
    /// Opens a film on a thread of its own, which ends with the film, or when this is dropped.
    ///
    /// # Errors
    /// As [`Film::open`].
    pub fn open(path: &Path) -> Result<Self, VideoError> {
        let (opened, info) = sync_channel(1);
        let (sender, frames) = sync_channel(WAITING);
        let path = path.to_owned();
        let named = path.clone();
        // The decoder stays on the thread that made it.
        let decode = move || match Film::open(&path) {
            Err(refused) => drop(opened.send(Err(refused))),
            Ok(film) => {
                let wanted = opened.send(Ok(film.info())).is_ok();
                // A frame that nobody takes ends the thread.
                let _ = film.take_while(|_| wanted).try_for_each(|frame| sender.send(frame));
            }
        };
        thread::Builder::new().spawn(decode).map_err(|e| VideoError::reading_error(&named, e))?;
        let gone = |_| VideoError::reading_error(&named, std::io::Error::other("the thread of its decoder ended"));
        let info = info.recv().map_err(gone)??;
        Ok(Self { info, frames })
    }

    /// Size, length and rate of the film, as it is shown.
    pub fn info(&self) -> Info {
        self.info
    }
}

impl Iterator for DecodedAhead {
    type Item = Result<Frame, VideoError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.frames.recv().ok()
    }
}
