//! Propagation of uncertainty: from pixels, camera parameters, heights and ripples to a covariance in metres.

use si::{Metre, Point2, Radian};
use track::calibrate::CAMERA_PARAMETERS;
use track::refraction::{ERROR_SOURCES, HEIGHT, INDEX, RefractiveCamera, SURFACE};

use super::no_ray;
use diagnostics::Result;
use records::{Covariance2, CovarianceParts, Path};

/// Sources of uncertainty.
pub struct UncertaintySources {
    /// Sources that are constant in a film.
    pub shared: Shared,
    /// Root of the mean squared slope of the surface, rad.
    pub ripple: Radian,
    /// Standard deviation of a marker's centre against the material point under it, along x and y, m.
    pub mark: Metre,
}

/// The covariance of the [`ERROR_SOURCES`].
pub struct Shared(Vec<[f64; ERROR_SOURCES]>);

impl Shared {
    /// From the camera's covariance and the standard deviations of surface (m), index and height (m).
    pub fn new(camera: &[[f64; CAMERA_PARAMETERS]; CAMERA_PARAMETERS], [surface, index, height]: [f64; 3]) -> Self {
        let alone = |cause: usize| match cause {
            SURFACE => surface * surface,
            INDEX => index * index,
            HEIGHT => height * height,
            _ => 0.0,
        };
        let entry = |i: usize, j: usize| match (i < CAMERA_PARAMETERS, j < CAMERA_PARAMETERS) {
            (true, true) => camera[i][j],
            _ if i == j => alone(i),
            _ => 0.0,
        };
        Self((0..ERROR_SOURCES).map(|i| std::array::from_fn(|j| entry(i, j))).collect())
    }

    /// J C Jᵀ
    fn covariance_along(&self, slope: &[Point2; ERROR_SOURCES]) -> Covariance2 {
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

/// The full covariance of a marker's positions, and its contributions: frames each.
pub(crate) fn marker_covariances(
    camera_model: &RefractiveCamera,
    path: &Path,
    height: Metre,
    sources: &UncertaintySources,
) -> Result<(Vec<Covariance2>, CovarianceParts)> {
    let (mut totals, mut parts, mut first) = (Vec::new(), CovarianceParts::default(), None);
    for (frame, (&pixel, spread)) in path.at.iter().zip(&path.spread).enumerate() {
        let (by_pixel, by_error_sources) =
            (camera_model.by_pixel(pixel, height), camera_model.by_error_sources(pixel, height));
        let (Some(by_pixel), Some(by_error_sources)) = (by_pixel, by_error_sources) else {
            return Err(no_ray(&path.name, frame, pixel));
        };
        let noise = covariance_sum(
            mapped_covariance(by_pixel, spread),
            ripple_covariance(camera_model, height, sources.ripple),
        );
        let first = first.get_or_insert(by_error_sources);
        let since: [Point2; ERROR_SOURCES] =
            std::array::from_fn(|i| [by_error_sources[i][0] - first[i][0], by_error_sources[i][1] - first[i][1]]);
        let mark = [sources.mark.powi(2), 0.0, sources.mark.powi(2)];
        totals.push(covariance_sum(covariance_sum(noise, mark), sources.shared.covariance_along(&by_error_sources)));
        parts.noise.push(noise);
        parts.shared.push(covariance_sum(sources.shared.covariance_along(&since), mark));
    }
    Ok((totals, parts))
}

/// A slope s of the surface shifts the image of a point at depth d by d (1 − 1/n) s; half its square falls on each axis.
fn ripple_covariance(camera_model: &RefractiveCamera, height: Metre, ripple: Radian) -> Covariance2 {
    let image_shift =
        camera_model.water.map_or(0.0, |w| (w.surface - height).max(0.0) * (1.0 - 1.0 / w.index) * ripple);
    [0.5 * image_shift * image_shift, 0.0, 0.5 * image_shift * image_shift]
}

/// J C Jᵀ
fn mapped_covariance(j: [[f64; 2]; 2], [xx, xy, yy]: &Covariance2) -> Covariance2 {
    let entry = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] * xx + (a[0] * b[1] + a[1] * b[0]) * xy + a[1] * b[1] * yy;
    [entry(j[0], j[0]), entry(j[0], j[1]), entry(j[1], j[1])]
}

fn covariance_sum(a: Covariance2, b: Covariance2) -> Covariance2 {
    [0, 1, 2].map(|k| a[k] + b[k])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_covariance_turned_by_a_right_angle_changes_its_axes() {
        let turned = mapped_covariance([[0.0, -2.0], [2.0, 0.0]], &[1.0, 0.5, 3.0]);
        assert_eq!(turned, [12.0, -2.0, 4.0]);
    }

    #[test]
    fn an_error_of_the_height_alone_moves_a_position_along_its_derivative() {
        let shared = Shared::new(&[[0.0; CAMERA_PARAMETERS]; CAMERA_PARAMETERS], [0.0, 0.0, 2e-4]);
        let mut slope = [[0.0; 2]; ERROR_SOURCES];
        slope[HEIGHT] = [0.3, -0.1];
        let found = shared.covariance_along(&slope);
        for (value, known) in found.iter().zip([0.09, -0.03, 0.01]) {
            assert!((value - known * 4e-8).abs() < 1e-20);
        }
    }
}
