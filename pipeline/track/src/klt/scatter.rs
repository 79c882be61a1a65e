//! How far the middle of a spot is to be trusted: its covariance.
//!
//! A codec's errors hang together over blocks of pixels, so the noise of single pixels says too little. The window is
//! cut into sectors; what each one pulls the centroid aside, measured against the marker of the first frame, is one draw
//! of the noise. Opposite sectors are taken together, so that a change of size or light, which pulls all outwards, counts
//! for nothing.
//!
//! Stands on: spots and templates. Never knows: the frame before.

use super::blob::Blob;
use super::ground::visit;
use super::template::Template;
use crate::Gray;
use si::Radian;

/// Pairs of opposite sectors: each as wide at a marker's edge as a codec's block.
const PAIRS: usize = 8;
/// Variance of rounding to whole grey levels, the least that a picture has.
const ROUNDING: f64 = 1.0 / 12.0;

/// What light that bends across a mark moves its middle by, alike in all frames: so many px along each axis where the ground
/// leaves its plane by the mark's whole contrast (an edge of one pixel moves by its share of it), and never less than the last.
const SHADE: f64 = 0.9;
const LEAST_SHADE: f64 = 0.005;

/// Covariance from the noise of single pixels, and from the light, px².
pub(super) fn of_pixels(blob: &Blob) -> [[f64; 2]; 2] {
    let variance = blob.ground.noise.powi(2).max(ROUNDING);
    let shade = (SHADE * blob.ground.bend / blob.contrast).powi(2) + LEAST_SHADE * LEAST_SHADE;
    let [[xx, xy], [yx, yy]] = blob.pull.map(|row| row.map(|p| p * variance));
    [[xx + shade, xy], [yx, yy + shade]]
}

/// Covariance from the sectors' pulls against the template at a `turn` (rad), px².
///
/// Half the sum over pairs of q qᵀ: the template's own noise is in q as well.
pub(super) fn of_sectors(picture: &Gray, blob: &Blob, template: &Template, turn: Radian) -> [[f64; 2]; 2] {
    let mut pulls = [[0.0; 2]; PAIRS];
    let (off, turn) = (blob.off(), turn.sin_cos());
    visit(picture, blob.at, template.radius(), 1, |x, y, _, level| {
        let now = blob.soft.weight(1.0 - level / blob.ground.level(x + off[0], y + off[1]));
        let then = blob.soft.weight(1.0 - template.share([x, y], turn));
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
