//! Covariance of the centroid of a spot.
//!
//! The errors of a codec are correlated over blocks of pixels, so the noise of single pixels underestimates them. The window is
//! cut into sectors; the shift of the centroid that each one causes, against the marker of the first frame, is one sample of the error.
//! Opposite sectors are added, so that a change of size or light, which shifts all outwards, cancels.

use super::background::Disc;
use super::blob::Blob;
use super::template::Template;
use crate::Gray;
use si::Radian;

/// Pairs of opposite sectors: each as wide at a marker's edge as a codec's block.
const PAIRS: usize = 8;
/// Variance of rounding to whole grey levels, the least that a picture has.
const ROUNDING: f64 = 1.0 / 12.0;

/// What light that bends across a mark moves its middle by, alike in all frames: so many px along each axis where the background
/// leaves its plane by the mark's whole contrast, and never less than the last. An edge of one pixel moves by its share of the
/// contrast at most, evenly likely up to that (1/√3), and only what differs from side to side counts (1/√2).
const SHADE: f64 = 0.41;
const LEAST_SHADE: f64 = 0.005;

/// A codec between frames sends no coefficient below this share of its step: a sixth of a step is rounded up.
const DEAD: f64 = 5.0 / 6.0;
/// Its motion vectors are right to this, px: half of a quarter.
const VECTOR: f64 = 0.125;
/// A side of the block that has a vector of its own, px.
const BLOCK: f64 = 16.0;

/// Variance along each axis of what an H.264 codec with this quantiser leaves out of a mark's motion, px².
///
/// A shift of d px changes a mark's edge, and each coefficient that the edge has, by d times the contrast. After the vector,
/// d is evenly likely up to [`VECTOR`]: what is under the dead zone of the step Δ = 2^((q − 4)/6) is not sent and stays, the rest
/// is sent and rounded to half a step. One such rest for each block that the rim crosses.
pub(super) fn of_codec(blob: &Blob, quantiser: u8) -> f64 {
    let step = ((f64::from(quantiser) - 4.0) / 6.0).exp2() / blob.contrast;
    let (unsent, rounded) = ((DEAD * step).min(VECTOR), 0.5 * step);
    let share = unsent / VECTOR;
    let block_variance = (share * unsent * unsent + (1.0 - share) * rounded * rounded) / 3.0;
    let rim = 2.0 * (std::f64::consts::PI * blob.sum).sqrt();
    block_variance / (rim / BLOCK).max(1.0)
}

/// A covariance with no variance under `least`: sectors see what differs from block to block, and never a shift of all alike.
pub(super) fn at_least([[xx, xy], [yx, yy]]: [[f64; 2]; 2], least: f64) -> [[f64; 2]; 2] {
    [[xx.max(least), xy], [yx, yy.max(least)]]
}

/// Covariance from the noise of single pixels, and from the light, px².
pub(super) fn of_pixels(blob: &Blob) -> [[f64; 2]; 2] {
    let variance = blob.background.noise.powi(2).max(ROUNDING);
    let shade = (SHADE * blob.background.bend / blob.contrast).powi(2) + LEAST_SHADE * LEAST_SHADE;
    let [[xx, xy], [yx, yy]] = blob.pull.map(|row| row.map(|p| p * variance));
    [[xx + shade, xy], [yx, yy + shade]]
}

/// Covariance from the sectors' pulls against the template at a `turn` (rad), px².
///
/// Half the sum over pairs of q qᵀ: the template's own noise is in q as well.
pub(super) fn of_sectors(picture: &Gray, blob: &Blob, template: &Template, turn: Radian) -> [[f64; 2]; 2] {
    let mut pulls = [[0.0; 2]; PAIRS];
    let (off, turn) = (blob.centroid_shift(), turn.sin_cos());
    Disc { middle: blob.at, radius: template.radius(), stride: 1 }.visit_pixels(picture, |x, y, _, level| {
        let now = blob.soft.pixel_weight(1.0 - level / blob.background.level_at(x + off[0], y + off[1]));
        let then = blob.soft.pixel_weight(1.0 - template.level_share([x, y], turn));
        if now != then {
            let half_turns = (y.atan2(x) / std::f64::consts::PI + 1.0).fract();
            let pull = &mut pulls[((half_turns * PAIRS as f64) as usize).min(PAIRS - 1)];
            pull[0] += (now - then) * x / blob.sum;
            pull[1] += (now - then) * y / blob.sum;
        }
    });
    let sum = |i: usize, j: usize| 0.5 * pulls.iter().map(|q| q[i] * q[j]).sum::<f64>();
    [[sum(0, 0), sum(0, 1)], [sum(1, 0), sum(1, 1)]]
}
