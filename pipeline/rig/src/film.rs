//! Films: frames are drawn on one side while they are encoded on the other.
//!
//! Frames are drawn and encoded in their order; films side by side keep all cores busy.
//!
//! Stands on: `track` (the encoder). Never knows: what is drawn.

use std::path::Path;
use std::sync::mpsc::sync_channel;

use track::Gray;
use track::video::{Quality, Writer};

use crate::fault::Fault;
use crate::settings;

/// Frames that may wait for the encoder; one of 1280 × 720 px is 1 MB.
const WAITING: usize = 8;

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
        let (send, receive) = sync_channel::<Gray>(WAITING);
        scope.spawn(move || {
            for frame in 0..frames {
                if send.send(draw(frame)).is_err() {
                    return; // the encoder has failed and says why
                }
            }
        });
        for picture in receive {
            writer.push(&picture).map_err(failed)?;
            tick();
        }
        Ok(())
    })?;
    writer.finish().map_err(failed)
}
