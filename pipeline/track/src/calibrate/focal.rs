//! A lens from a file against the board's own views.

use super::{View, calibrate};
use crate::lens::Lens;
use si::Point3;

/// Views that are enough for an estimate of the focal length.
const ENOUGH: usize = 30;
/// Share by which focal lengths may differ, and how many standard deviations of the estimate: a lens that breathes with its focus changes by less.
const SHARE: f64 = 0.05;
const DEVIATIONS: f64 = 6.0;

/// A focal length that the views of a board contradict. A wrong one hardly shows in their reprojection: it moves the camera away.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "the lens has a focal length of {known:.0} px, the views of the board give {estimate:.0} ± {sigma:.0} px\n  why: they differ by {:.0} %; the limit is {:.0} %, and {DEVIATIONS} standard deviations\n  do:  take the coefficients of this camera at this zoom and size of picture, or leave them out and let the board be used", 100.0 * (.known / .estimate - 1.0).abs(), 100.0 * SHARE
)]
pub struct OtherFocalLength {
    /// Of the file, px.
    pub known: f64,
    /// Of the views, px.
    pub estimate: f64,
    /// Its standard deviation, px.
    pub sigma: f64,
}

/// Compares a known lens with what views of a board with these points give by themselves, where they give a lens at all.
///
/// # Errors
/// [`OtherFocalLength`] with both focal lengths.
pub fn check_focal(
    known: &Lens,
    views: &[View],
    points: &[Point3],
    size: (usize, usize),
) -> Result<(), OtherFocalLength> {
    let some: Vec<View> = views.iter().step_by(views.len().div_ceil(ENOUGH).max(1)).cloned().collect();
    let Ok(own) = calibrate(&some, points, known.distortion, size) else { return Ok(()) };
    let (estimate, sigma, known) = (own.lens.fx, own.sigma()[0], known.fx);
    let off = (known - estimate).abs();
    match off > SHARE * estimate && off > DEVIATIONS * sigma {
        true => Err(OtherFocalLength { known, estimate, sigma }),
        false => Ok(()),
    }
}
