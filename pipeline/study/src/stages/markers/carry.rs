//! Carrying errors: from pixels, the camera's numbers, heights and ripples to a covariance in metres.
//!
//! Stands on: track. Never knows: a shutter, time.

use si::{Metre, Point2, Radian};
use track::calibrate::OF_CAMERA;
use track::sight::{CAUSES, HEIGHT, INDEX, SURFACE, Sight};

use super::no_ray;
use crate::fault::Outcome;
use crate::records::{Parts, Path, Spread};

/// Everything that is not known exactly.
pub struct Doubts {
    /// What stays through a film.
    pub shared: Shared,
    /// Root of the mean squared slope of the surface, rad.
    pub ripple: Radian,
    /// Of a mark's middle against the point under it, along x and y, m.
    pub mark: Metre,
}

/// The covariance of the causes of [`CAUSES`].
pub struct Shared(Vec<[f64; CAUSES]>);

impl Shared {
    /// From the camera's covariance and the standard deviations of surface (m), index and height (m).
    pub fn new(camera: &[[f64; OF_CAMERA]; OF_CAMERA], [surface, index, height]: [f64; 3]) -> Self {
        let alone = |cause: usize| match cause {
            SURFACE => surface * surface,
            INDEX => index * index,
            HEIGHT => height * height,
            _ => 0.0,
        };
        let entry = |i: usize, j: usize| match (i < OF_CAMERA, j < OF_CAMERA) {
            (true, true) => camera[i][j],
            _ if i == j => alone(i),
            _ => 0.0,
        };
        Self((0..CAUSES).map(|i| std::array::from_fn(|j| entry(i, j))).collect())
    }

    /// J C Jᵀ
    fn carried(&self, slope: &[Point2; CAUSES]) -> Spread {
        let mut sum = [0.0; 3];
        for (row, a) in self.0.iter().zip(slope) {
            for (c, b) in row.iter().zip(slope) {
                sum[0] += a[0] * c * b[0];
                sum[1] += a[0] * c * b[1];
                sum[2] += a[1] * c * b[1];
            }
        }
        sum
    }
}

/// The whole covariance of a marker's places, and its parts: frames each.
pub fn all(sight: &Sight, path: &Path, height: Metre, doubts: &Doubts) -> Outcome<(Vec<Spread>, Parts)> {
    let (mut whole, mut parts, mut first) = (Vec::new(), Parts::default(), None);
    for (frame, (&pixel, spread)) in path.at.iter().zip(&path.spread).enumerate() {
        let (by_pixel, by_causes) = (sight.by_pixel(pixel, height), sight.by_causes(pixel, height));
        let (Some(by_pixel), Some(by_causes)) = (by_pixel, by_causes) else {
            return Err(no_ray(&path.name, frame, pixel));
        };
        let noise = sum(carried(by_pixel, spread), rippled(sight, height, doubts.ripple));
        let first = first.get_or_insert(by_causes);
        let since: [Point2; CAUSES] =
            std::array::from_fn(|i| [by_causes[i][0] - first[i][0], by_causes[i][1] - first[i][1]]);
        let mark = [doubts.mark.powi(2), 0.0, doubts.mark.powi(2)];
        whole.push(sum(sum(noise, mark), doubts.shared.carried(&by_causes)));
        parts.noise.push(noise);
        parts.shared.push(sum(doubts.shared.carried(&since), mark));
    }
    Ok((whole, parts))
}

/// A slope s of the surface moves what is d under it by d (1 − 1/n) s; half its square falls on each axis.
fn rippled(sight: &Sight, height: Metre, ripple: Radian) -> Spread {
    let moved = sight.water.map_or(0.0, |w| (w.surface - height).max(0.0) * (1.0 - 1.0 / w.index) * ripple);
    [0.5 * moved * moved, 0.0, 0.5 * moved * moved]
}

/// J C Jᵀ
fn carried(j: [[f64; 2]; 2], [xx, xy, yy]: &Spread) -> Spread {
    let entry = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] * xx + (a[0] * b[1] + a[1] * b[0]) * xy + a[1] * b[1] * yy;
    [entry(j[0], j[0]), entry(j[0], j[1]), entry(j[1], j[1])]
}

fn sum(a: Spread, b: Spread) -> Spread {
    [0, 1, 2].map(|k| a[k] + b[k])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_covariance_turned_by_a_right_angle_changes_its_axes() {
        let turned = carried([[0.0, -2.0], [2.0, 0.0]], &[1.0, 0.5, 3.0]);
        assert_eq!(turned, [12.0, -2.0, 4.0]);
    }

    #[test]
    fn a_doubt_about_the_height_alone_moves_a_place_along_its_slope() {
        let shared = Shared::new(&[[0.0; OF_CAMERA]; OF_CAMERA], [0.0, 0.0, 2e-4]);
        let mut slope = [[0.0; 2]; CAUSES];
        slope[HEIGHT] = [0.3, -0.1];
        let found = shared.carried(&slope);
        for (value, known) in found.iter().zip([0.09, -0.03, 0.01]) {
            assert!((value - known * 4e-8).abs() < 1e-20);
        }
    }
}
