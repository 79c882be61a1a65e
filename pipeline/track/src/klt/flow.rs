//! Optical flow of one marker between two frames, on a crop around it: kornia's pyramidal Lucas–Kanade (window 21 × 21).
//!
//! The window follows the marker's radius: the crops of a marker of twice the usual radius are halved before, and so on, so that its rim lies
//! in the window and its flow costs no more than a small marker's.
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
/// Radius of a marker up to which its crop is not reduced, px.
const USUAL: f64 = 24.0;
/// Halvings of the pyramid.
const LEVELS: usize = 1;

/// Two frames, and the radius of the markers (px).
#[derive(Clone, Copy)]
pub(super) struct Flow<'a> {
    pub before: &'a Gray,
    pub after: &'a Gray,
    pub radius: f64,
}

impl Flow<'_> {
    /// Where the place `start` of the frame before lies in the frame after, near `guess` (all px). None when flow gives no answer.
    pub(super) fn follow_point(&self, start: Point2, guess: Point2) -> Option<Point2> {
        let block = reduction_factor(self.radius);
        let (from, onto) =
            (Crop::around_point(self.before, start, block), Crop::around_point(self.after, guess, block));
        let images = (from.reduced_image(self.before)?, onto.reduced_image(self.after)?);
        let params = PyrLKParams { max_level: LEVELS, use_initial_flow: true, ..PyrLKParams::default() };
        let pyramids = build_lk_precomputed(&images.0, &images.1, LEVELS).ok()?;
        let starts = (&[from.to_crop(start)], &[onto.to_crop(guess)]);
        let flow = calc_optical_flow_pyr_lk_with_precomputed(&pyramids, starts.0, Some(starts.1), &params).ok()?;
        let tracked = flow.next_pts.first().filter(|_| flow.status.first() == Some(&1))?;
        let point = onto.to_picture(*tracked);
        point.iter().all(|v| v.is_finite()).then_some(point)
    }
}

/// Pixels a side that are averaged to one.
fn reduction_factor(radius: f64) -> usize {
    (radius / USUAL).ceil().max(1.0) as usize
}

/// A crop around a place, moved inside the picture, with blocks of `by` × `by` pixels averaged.
struct Crop {
    corner: [usize; 2],
    side: usize,
    by: usize,
}

impl Crop {
    fn around_point(picture: &Gray, middle: Point2, block: usize) -> Self {
        let (half, side) = ((HALF * block + block / 2) as f64, (2 * HALF + 1) * block);
        let first = |c: f64, size: usize| ((c.round() - half).max(0.0) as usize).min(size.saturating_sub(side));
        Self { corner: [first(middle[0], picture.width), first(middle[1], picture.height)], side, by: block }
    }

    fn reduced_image(&self, picture: &Gray) -> Option<Image<f32, 1>> {
        let region = picture.crop(self.corner[0], self.corner[1], self.side, self.side);
        let size = ImageSize { width: region.width / self.by, height: region.height / self.by };
        let scale = 255.0 * (self.by * self.by) as f32;
        let row = |y: usize, x: usize| &region.pixels[y * region.width + x * self.by..][..self.by];
        let block = |x: usize, y: usize| -> u32 {
            (y * self.by..(y + 1) * self.by).flat_map(|line| row(line, x)).map(|&p| u32::from(p)).sum()
        };
        let places = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
        Image::new(size, places.map(|(x, y)| block(x, y) as f32 / scale).collect()).ok()
    }

    /// A place of the picture in the crop: the centre of its first pixel is 0, 0.
    fn to_crop(&self, p: Point2) -> [f32; 2] {
        let shift = 0.5 * (self.by as f64 - 1.0);
        [0, 1].map(|k| ((p[k] - self.corner[k] as f64 - shift) / self.by as f64) as f32)
    }

    fn to_picture(&self, p: [f32; 2]) -> Point2 {
        let shift = 0.5 * (self.by as f64 - 1.0);
        [0, 1].map(|k| f64::from(p[k]) * self.by as f64 + shift + self.corner[k] as f64)
    }
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
    fn a_place_is_the_same_inside_and_outside_of_a_reduced_crop() {
        let picture = Gray::filled(400, 300, 9);
        for by in [1, 2, 3] {
            let crop = Crop::around_point(&picture, [200.3, 150.7], by);
            let there = crop.to_picture(crop.to_crop([210.25, 140.5]));
            assert!((there[0] - 210.25).abs() < 1e-4 && (there[1] - 140.5).abs() < 1e-4, "{by}: {there:?}");
            assert_eq!(crop.reduced_image(&picture).map(|image| image.size().width), Some(2 * HALF + 1));
        }
        assert_eq!([18.0, 24.0, 36.0, 60.0].map(reduction_factor), [1, 1, 2, 3]);
    }

    #[test]
    fn parallel_work_stays_on_one_thread() {
        assert_eq!(SingleThread::new().run(rayon::current_num_threads), 1);
    }
}
