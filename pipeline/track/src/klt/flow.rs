//! Optical flow of one marker between two frames, on a crop around it: kornia's pyramidal Lucas–Kanade (window 21 × 21).
//!
//! Crops, because pyramids and gradients of whole frames would cost as much for three markers as for three thousand.

use crate::Gray;
use kornia_image::{Image, ImageSize};
use kornia_imgproc::optical_flow_pyr_lk::{
    PyrLKParams, build_lk_precomputed, calc_optical_flow_pyr_lk_with_precomputed,
};
use rayon::{ThreadPool, ThreadPoolBuilder};
use si::Point2;

/// Pixels on either side of the middle of a crop: the window on the coarser level, and a step of 12 px.
const HALF: usize = 34;
/// Halvings of the pyramid.
const LEVELS: usize = 1;

/// Where the place `at` of frame `before` lies in frame `after`, near `guess` (all px). None when flow gives no answer.
pub(super) fn follow(before: &Gray, after: &Gray, at: Point2, guess: Point2) -> Option<Point2> {
    let (from, onto) = (corner(before, at), corner(after, guess));
    let images = (crop(before, from)?, crop(after, onto)?);
    let params = PyrLKParams { max_level: LEVELS, use_initial_flow: true, ..PyrLKParams::default() };
    let pyramids = build_lk_precomputed(&images.0, &images.1, LEVELS).ok()?;
    let inside = |p: Point2, corner: [usize; 2]| [0, 1].map(|k| (p[k] - corner[k] as f64) as f32);
    let starts = (&[inside(at, from)], &[inside(guess, onto)]);
    let flow = calc_optical_flow_pyr_lk_with_precomputed(&pyramids, starts.0, Some(starts.1), &params).ok()?;
    let found = flow.next_pts.first().filter(|_| flow.status.first() == Some(&1))?;
    let place = [0, 1].map(|k| f64::from(found[k]) + onto[k] as f64);
    place.iter().all(|v| v.is_finite()).then_some(place)
}

/// First pixel of a crop around a place, moved inside the picture.
fn corner(picture: &Gray, at: Point2) -> [usize; 2] {
    let first =
        |c: f64, size: usize| ((c.round() - HALF as f64).max(0.0) as usize).min(size.saturating_sub(2 * HALF + 1));
    [first(at[0], picture.width), first(at[1], picture.height)]
}

fn crop(picture: &Gray, [left, top]: [usize; 2]) -> Option<Image<f32, 1>> {
    let region = picture.crop(left, top, 2 * HALF + 1, 2 * HALF + 1);
    let levels = region.pixels.iter().map(|&p| f32::from(p) / 255.0).collect();
    Image::new(ImageSize { width: region.width, height: region.height }, levels).ok()
}

/// A pool of one thread for the flow of small crops.
///
/// kornia hands every row of a pyramid to whichever core is free; for crops of 69 px the dispatch costs more than the rows. A film is
/// therefore tracked on one thread, and films are tracked side by side.
pub(super) struct SingleThread(Option<ThreadPool>);

impl SingleThread {
    /// A pool of its own; where the system gives no thread, work runs in the global pool.
    pub(super) fn new() -> Self {
        Self(ThreadPoolBuilder::new().num_threads(1).build().ok())
    }

    /// Runs `work` on this thread alone.
    pub(super) fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match &self.0 {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parallel_work_stays_on_one_thread() {
        assert_eq!(SingleThread::new().run(rayon::current_num_threads), 1);
    }
}
