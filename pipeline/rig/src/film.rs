//! Films: one thread renders the frames, another encodes them.
//!
//! Frames are rendered and encoded in order. Several films at once keep all cores busy, so one film uses no more than two threads.

use std::path::Path;
use std::sync::mpsc::sync_channel;

use diagnostics::Result;
use track::Gray;
use track::video::{Quality, Writer};

use crate::settings;

/// Frames that may wait for the encoder; one of 1280 × 720 px is 1 MB.
const WAITING: usize = 8;

/// The frames of a film.
pub(crate) struct Frames<'a> {
    /// Their number.
    pub(crate) count: usize,
    /// Renders one.
    pub(crate) draw: &'a (dyn Fn(usize) -> Gray + Sync),
}

/// Writes `frames` to `path`; `tick` is called after each.
///
/// # Errors
/// When the encoder fails or the file cannot be written.
pub(crate) fn write_film(path: &Path, set: &settings::Camera, frames: &Frames, tick: &dyn Fn()) -> Result<()> {
    let mut writer = Writer::create(path, (set.width, set.height), set.rate, Quality::Quantiser(set.quantiser))?;
    std::thread::scope(|scope| -> Result<()> {
        let (send, receive) = sync_channel::<Gray>(WAITING);
        scope.spawn(move || {
            for frame in 0..frames.count {
                if send.send((frames.draw)(frame)).is_err() {
                    return; // the encoder failed; its error is returned below
                }
            }
        });
        for picture in receive {
            writer.push(&picture)?;
            tick();
        }
        Ok(())
    })?;
    Ok(writer.finish()?)
}
