//! Films: frames are drawn on one side while they are encoded on the other.
//!
//! Frames are drawn in batches side by side and encoded in their order, so a film has the same bytes with any number of
//! threads.
//!
//! Stands on: `track` (the encoder), rayon. Never knows: what is drawn.

use std::path::Path;
use std::sync::mpsc::sync_channel;

use rayon::prelude::*;
use track::Gray;
use track::video::{Quality, Writer};

use crate::fault::Fault;
use crate::settings;

/// Frames drawn side by side; a batch of 1280 × 720 px is 7 MB.
const BATCH: usize = 8;
/// Batches that may wait for the encoder.
const WAITING: usize = 2;

/// Writes `frames` frames to `path`, each drawn by `draw`; `tick` is called after each.
///
/// # Errors
/// [`Fault`] when the encoder or the disk refuses.
pub fn shoot(
    path: &Path,
    set: &settings::Camera,
    frames: usize,
    draw: &(dyn Fn(usize) -> Gray + Sync),
    tick: &dyn Fn(),
) -> Result<(), Fault> {
    let failed = |e| Fault::at(path.display().to_string(), e);
    let mut writer =
        Writer::create(path, set.width, set.height, set.rate, Quality::Quantiser(set.quantiser)).map_err(failed)?;
    std::thread::scope(|scope| {
        let (send, receive) = sync_channel::<Vec<Gray>>(WAITING);
        scope.spawn(move || {
            for first in (0..frames).step_by(BATCH) {
                let batch = (first..(first + BATCH).min(frames)).into_par_iter().map(draw).collect();
                if send.send(batch).is_err() {
                    return; // the encoder has failed and says why
                }
            }
        });
        for picture in receive.into_iter().flatten() {
            writer.push(&picture).map_err(failed)?;
            tick();
        }
        Ok(())
    })?;
    writer.finish().map_err(failed)
}
