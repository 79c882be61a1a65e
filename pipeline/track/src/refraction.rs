//! Intersection of a pixel's ray with a horizontal plane, through air or a flat water surface, and its sensitivities.
//!
//! The ray is traced from the camera and refracted once by Snell's law, in closed form. An apparent-depth factor would hold for vertical
//! rays only. Paper, section IV.

use crate::calibrate::CAMERA_PARAMETERS;
use crate::lens::{Lens, VALUES};
use crate::pose::Pose;
use si::{Metre, Point2, Point3, vec3};

/// A flat water surface across the sight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Water {
    /// z of the surface, m, world frame.
    pub surface: Metre,
    /// Refractive index relative to air, no unit.
    pub index: f64,
}

/// A camera above a scene, and the water between them, if any.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RefractiveCamera {
    /// The lens.
    pub lens: Lens,
    /// World → camera.
    pub pose: Pose,
    /// None in air.
    pub water: Option<Water>,
}

/// Sources of error of a position: the parameters of the camera, then surface (m), index and the height of the plane (m).
pub const ERROR_SOURCES: usize = CAMERA_PARAMETERS + 3;
/// Position of surface, index and height among the sources.
pub const SURFACE: usize = CAMERA_PARAMETERS;
/// See [`SURFACE`].
pub const INDEX: usize = CAMERA_PARAMETERS + 1;
/// See [`SURFACE`].
pub const HEIGHT: usize = CAMERA_PARAMETERS + 2;

/// Half widths of the central differences: pixels, px; focal length and centre, px; coefficients; turn, rad; lengths, m; index.
const PIXEL_STEP: f64 = 0.05;
const BEND_STEP: f64 = 1e-5;
const TURN_STEP: f64 = 1e-6;
const LENGTH_STEP: f64 = 1e-6;
const INDEX_STEP: f64 = 1e-5;

impl RefractiveCamera {
    /// Where the ray of `pixel` (px) meets z = `height` (m) of the world: [x, y], m.
    ///
    /// None where the lens has no ray, or the ray runs along that height or away from it.
    pub fn intersect(&self, pixel: Point2, height: Metre) -> Option<Point2> {
        let [u, v] = self.lens.unproject(pixel)?;
        let (eye, direction) = (self.pose.centre(), self.pose.direction_to_world([u, v, 1.0]));
        match self.water {
            Some(water) if height < water.surface && water.surface < eye[2] => {
                let [x, y] = intersect_plane(eye, direction, water.surface)?;
                intersect_plane([x, y, water.surface], water.refract(direction), height)
            }
            _ => intersect_plane(eye, direction, height),
        }
    }

    /// d(place)/d(pixel), 2 × 2, m/px: rows x and y of the world, columns x and y of the picture; by central differences.
    pub fn by_pixel(&self, pixel: Point2, height: Metre) -> Option<[[f64; 2]; 2]> {
        let column = |k: usize| {
            let perturbed = |change: f64| {
                let mut shifted_pixel = pixel;
                shifted_pixel[k] += change;
                self.intersect(shifted_pixel, height)
            };
            central_difference(perturbed(PIXEL_STEP)?, perturbed(-PIXEL_STEP)?, PIXEL_STEP)
        };
        let [a, b] = [column(0)?, column(1)?];
        Some([[a[0], b[0]], [a[1], b[1]]])
    }

    /// d(place)/d(cause), m over the unit of each of [`ERROR_SOURCES`]; by central differences.
    pub fn by_error_sources(&self, pixel: Point2, height: Metre) -> Option<[Point2; ERROR_SOURCES]> {
        let mut derivatives = [[0.0; 2]; ERROR_SOURCES];
        for (cause, slope) in derivatives.iter_mut().enumerate() {
            if (self.lens.count()..VALUES).contains(&cause)
                || (self.water.is_none() && matches!(cause, SURFACE | INDEX))
            {
                continue;
            }
            let step = difference_step(cause);
            let perturbed = |change: f64| {
                self.perturbed_camera(cause, change)
                    .intersect(pixel, height + if cause == HEIGHT { change } else { 0.0 })
            };
            *slope = central_difference(perturbed(step)?, perturbed(-step)?, step)?;
        }
        Some(derivatives)
    }

    /// The same sight with one of its causes moved.
    fn perturbed_camera(&self, cause: usize, change: f64) -> Self {
        let mut next = *self;
        let axis = |k: usize| std::array::from_fn(|i| if i == k { change } else { 0.0 });
        match cause {
            0..VALUES => {
                let mut values = self.lens.values();
                values[cause] += change;
                next.lens = self.lens.with_values(values);
            }
            9..12 => next.pose = self.pose.rotated_and_shifted(axis(cause - VALUES), [0.0; 3]),
            12..CAMERA_PARAMETERS => next.pose = self.pose.rotated_and_shifted([0.0; 3], axis(cause - VALUES - 3)),
            SURFACE => next.water = self.water.map(|w| Water { surface: w.surface + change, ..w }),
            INDEX => next.water = self.water.map(|w| Water { index: w.index + change, ..w }),
            _ => {}
        }
        next
    }
}

impl Water {
    /// The direction of a ray after refraction at the surface, from above.
    ///
    /// t = i / n + (c / n − √(1 − (1 − c²) / n²)) z with c = −i · z    (Snell as vectors, the surface level)
    fn refract(&self, direction: Point3) -> Point3 {
        let ray = vec3::scale(direction, 1.0 / vec3::norm(direction));
        let (c, n) = (-ray[2], self.index);
        // The root is real for every ray: into the denser medium there is no total reflection.
        let vertical_part = c / n - (1.0 - (1.0 - c * c) / (n * n)).sqrt();
        [ray[0] / n, ray[1] / n, ray[2] / n + vertical_part]
    }
}

fn difference_step(cause: usize) -> f64 {
    match cause {
        0..4 => PIXEL_STEP,
        4..VALUES => BEND_STEP,
        9..12 => TURN_STEP,
        INDEX => INDEX_STEP,
        _ => LENGTH_STEP,
    }
}

fn central_difference(up: Point2, down: Point2, step: f64) -> Option<Point2> {
    let slope = [0, 1].map(|i| (up[i] - down[i]) / (2.0 * step));
    slope.iter().all(|s| s.is_finite()).then_some(slope)
}

/// Where a ray meets a height, if it lies ahead.
fn intersect_plane(from: Point3, along: Point3, height: Metre) -> Option<Point2> {
    let far = (height - from[2]) / along[2];
    (far.is_finite() && far > 0.0).then(|| [from[0] + far * along[0], from[1] + far * along[1]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lens::invert;

    fn sight(water: Option<Water>) -> RefractiveCamera {
        let lens = Lens::default().with_values([1473.0, 1478.0, 969.0, 541.0, -0.05, 0.02, 2e-4, -3e-4, 0.0]);
        let pose = Pose::from_vector([std::f64::consts::PI - 0.2, 0.1, 0.05], [-0.05, 0.02, 0.6]);
        RefractiveCamera { lens, pose, water }
    }

    const WATER: Water = Water { surface: 0.06, index: 1.333 };

    #[test]
    fn a_point_of_a_height_is_met_again_through_air() {
        let above = sight(None);
        for height in [0.0, 0.03] {
            let [x, y] = [0.08, -0.04];
            let pixel = above.lens.project(above.pose.apply([x, y, height])).unwrap();
            let met = above.intersect(pixel, height).unwrap();
            assert!((met[0] - x).hypot(met[1] - y) < 1e-12, "{met:?}");
        }
    }

    #[test]
    fn a_ray_into_water_obeys_snell_and_stays_in_its_upright_plane() {
        let above = sight(Some(WATER));
        let pixel = [1500.0, 200.0];
        let (eye, [u, v]) = (above.pose.centre(), above.lens.unproject(pixel).unwrap());
        let along = above.pose.direction_to_world([u, v, 1.0]);
        let surface = intersect_plane(eye, along, WATER.surface).unwrap();
        let met = above.intersect(pixel, 0.01).unwrap();
        let (dry, wet) = ([surface[0] - eye[0], surface[1] - eye[1]], [met[0] - surface[0], met[1] - surface[1]]);
        let sine = |[x, y]: Point2, deep: f64| x.hypot(y) / (x * x + y * y + deep * deep).sqrt();
        let ratio = sine(dry, eye[2] - WATER.surface) / sine(wet, WATER.surface - 0.01);
        assert!((ratio - WATER.index).abs() < 1e-12, "{ratio}");
        assert!((dry[0] * wet[1] - dry[1] * wet[0]).abs() < 1e-16);
    }

    #[test]
    fn water_as_thin_as_air_changes_nothing_and_neither_does_water_below_the_height() {
        let pixel = [700.0, 300.0];
        let dry = sight(None).intersect(pixel, 0.01).unwrap();
        let thin = sight(Some(Water { index: 1.0, ..WATER })).intersect(pixel, 0.01).unwrap();
        assert!((dry[0] - thin[0]).hypot(dry[1] - thin[1]) < 1e-15);
        let low = sight(Some(Water { surface: 0.0, ..WATER })).intersect(pixel, 0.01).unwrap();
        assert_eq!(low, dry);
    }

    #[test]
    fn the_slope_by_the_pixel_is_the_inverse_of_the_projection_s() {
        let (above, pixel) = (sight(None), [700.0, 300.0]);
        let [x, y] = above.intersect(pixel, 0.02).unwrap();
        let slope = above.lens.jacobian(above.pose.apply([x, y, 0.02]));
        let column = |i: usize, j: usize| (0..3).map(|k| slope[i][k] * above.pose.rotation[k][j]).sum();
        let exact = invert([0, 1].map(|i| [0, 1].map(|j| column(i, j)))).unwrap();
        let found = above.by_pixel(pixel, 0.02).unwrap();
        for (row, exact) in found.iter().flatten().zip(exact.iter().flatten()) {
            assert!((row - exact).abs() < 1e-7 * exact.abs().max(1e-4), "{row} {exact}");
        }
    }

    #[test]
    fn a_higher_plane_is_met_nearer_to_the_camera_s_foot_by_the_tangent_of_the_ray() {
        for water in [None, Some(WATER)] {
            let (above, pixel) = (sight(water), [1500.0, 200.0]);
            let slope = above.by_error_sources(pixel, 0.02).unwrap();
            let (low, high) = (above.intersect(pixel, 0.02).unwrap(), above.intersect(pixel, 0.03).unwrap());
            for k in 0..2 {
                assert!((slope[HEIGHT][k] - (high[k] - low[k]) / 0.01).abs() < 1e-6);
            }
            assert_eq!(slope[SURFACE] == [0.0; 2], water.is_none());
        }
    }

    #[test]
    fn a_height_behind_the_camera_is_not_met() {
        assert_eq!(sight(None).intersect([700.0, 300.0], 5.0), None);
    }
}
