//! A lens from a file against the board's own views.

use super::{View, calibrate};
use crate::lens::Lens;
use si::Point3;

/// Views that are enough for an estimate of the focal length.
const ENOUGH: usize = 30;
/// Share by which focal lengths may differ, and how many standard deviations of the estimate: a lens that breathes with its focus changes by less.
const SHARE: f64 = 0.05;
const DEVIATIONS: f64 = 6.0;

/// A focal length that the views of a board contradict. A wrong one hardly shows in their reprojection: it moves the camera away. It is a
/// warning and no refusal: the views of one film may be tilted too little or too alike for an estimate that deserves its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FocalDifference {
    /// Of the file, px.
    pub known: f64,
    /// Of the views, px.
    pub estimate: f64,
    /// Its standard deviation, px.
    pub sigma: f64,
}

impl FocalDifference {
    /// Why it is said: measured against the limit.
    pub fn reason(&self) -> String {
        let percent = 100.0 * (self.known / self.estimate - 1.0).abs();
        format!(
            "they differ by {percent:.0} %; the limit is {:.0} %, and {DEVIATIONS} standard deviations",
            100.0 * SHARE
        )
    }

    /// What to do about it.
    pub fn action(&self) -> &'static str {
        "take the coefficients of this camera at this zoom and size of picture, or leave them out and let the board be used"
    }
}

impl std::fmt::Display for FocalDifference {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { known, estimate, sigma } = self;
        write!(
            out,
            "the lens has a focal length of {known:.0} px, the views of the board give {estimate:.0} ± {sigma:.0} px"
        )
    }
}

/// A known lens compared with what views of a board with these points give by themselves, where they give a lens at all: none where both agree.
pub fn focal_difference(
    known: &Lens,
    views: &[View],
    points: &[Point3],
    size: (usize, usize),
) -> Option<FocalDifference> {
    let some: Vec<View> = views.iter().step_by(views.len().div_ceil(ENOUGH).max(1)).cloned().collect();
    let fitted = calibrate(&some, points, known.distortion, size).ok()?;
    let (estimate, sigma, known) = (fitted.lens.fx, fitted.sigma()[0], known.fx);
    let difference = (known - estimate).abs();
    (difference > SHARE * estimate && difference > DEVIATIONS * sigma).then_some(FocalDifference {
        known,
        estimate,
        sigma,
    })
}
