//! Refraction at the water surface, with travelling ripples.
//!
//! The ripples have slopes of a few milliradians; their heights (tens of micrometres) are neglected. The apparent position of a point is found
//! from the point to the camera, by solving for the crossing of its ray with the surface. The pipeline traces rays from the camera
//! instead: the two share no code.

use si::{Metre, Point2, Point3, Radian, Second, vec3};

use crate::random::RandomStream;
use crate::settings;

/// Number of plane waves in the ripples.
const WAVES: usize = 5;
/// Most Newton steps for a crossing, and the relative step at which the iteration stops: convergence is quadratic.
const STEPS: usize = 6;
const TOLERANCE: f64 = 1e-6;
/// Gravity, m/s², and surface tension of water over its density, m³/s².
const GRAVITY: f64 = 9.81;
const TENSION: f64 = 7.3e-5;

/// A water surface.
#[derive(Debug, Clone)]
pub struct Water {
    /// z of the surface at rest, m.
    pub surface: Metre,
    /// Refractive index, no unit.
    pub index: f64,
    waves: Vec<Wave>,
}

/// One travelling wave.
#[derive(Debug, Clone, Copy)]
struct Wave {
    /// Wave vector, rad/m.
    wave_vector: Point2,
    /// Amplitude of the slope, rad.
    slope: Radian,
    /// rad/s.
    angular_frequency: f64,
    phase: Radian,
}

impl Water {
    /// A surface without ripples.
    pub fn at_rest(surface: Metre, index: f64) -> Self {
        Self { surface, index, waves: Vec::new() }
    }

    /// The same surface without ripples.
    pub(crate) fn without_ripples(&self) -> Self {
        Self::at_rest(self.surface, self.index)
    }

    /// The same surface with the ripples of one recording, drawn from the settings' ranges.
    pub(crate) fn rippled(&self, set: &settings::Water, random: &mut RandomStream) -> Self {
        let slope = random.uniform(set.ripple) * (2.0 / WAVES as f64).sqrt();
        let wave = |_| {
            let direction = random.uniform([0.0, std::f64::consts::TAU]);
            let k = std::f64::consts::TAU / random.uniform(set.wavelength);
            let angular_frequency = (GRAVITY * k + TENSION * k.powi(3)).sqrt();
            let phase = random.uniform([0.0, std::f64::consts::TAU]);
            Wave { wave_vector: [k * direction.cos(), k * direction.sin()], slope, angular_frequency, phase }
        };
        Self { waves: (0..WAVES).map(wave).collect(), ..self.clone() }
    }

    /// Slope of the surface along x and y at a place (m) and time (s), rad.
    pub(crate) fn surface_slope(&self, [x, y]: Point2, t: Second) -> Point2 {
        self.waves.iter().fold([0.0; 2], |sum, wave| {
            let [kx, ky] = wave.wave_vector;
            let now = wave.slope * (kx * x + ky * y - wave.angular_frequency * t + wave.phase).cos() / kx.hypot(ky);
            [sum[0] + now * kx, sum[1] + now * ky]
        })
    }

    /// The point in air (m) in whose direction a camera at `eye` (m) sees `point` (m) at time `t` (s).
    ///
    /// It is the crossing of the ray with the surface at rest, or `point` itself above the surface. With ripples, the ray through that crossing
    /// misses `point`; the crossing is corrected by the miss once. The remaining error is of second order in the slopes.
    pub(crate) fn apparent_point(&self, eye: Point3, point: Point3, t: Second) -> Point3 {
        if point[2] >= self.surface {
            return point;
        }
        let flat = self.flat_crossing(eye, point);
        if self.waves.is_empty() {
            return flat;
        }
        let landed = self.landing_point(eye, flat, t, point[2]);
        self.flat_crossing(eye, [2.0 * point[0] - landed[0], 2.0 * point[1] - landed[1], point[2]])
    }

    /// The same to some micrometres, in half the time: ripples displace the point by their slope times d (1 − 1/n).
    pub(crate) fn apparent_approx(&self, eye: Point3, point: Point3, t: Second) -> Point3 {
        if point[2] >= self.surface {
            return point;
        }
        let (high, deep) = (eye[2] - self.surface, self.surface - point[2]);
        let fraction = high / (high + deep);
        let crossing_approx = [0, 1].map(|k| eye[k] + fraction * (point[k] - eye[k]));
        let [sx, sy] = self.surface_slope(crossing_approx, t);
        let lift = deep * (1.0 - 1.0 / self.index);
        self.flat_crossing(eye, [point[0] - lift * sx, point[1] - lift * sy, point[2]])
    }

    /// The crossing of the ray from `eye` to `point` with the flat surface.
    ///
    /// Snell: r / √(r² + h²) = n (R − r) / √((R − r)² + d²), r measured from the point below the camera, by Newton from the paraxial r.
    fn flat_crossing(&self, eye: Point3, point: Point3) -> Point3 {
        let (h, d, n) = (eye[2] - self.surface, self.surface - point[2], self.index);
        let offset = [point[0] - eye[0], point[1] - eye[1]];
        let horizontal_distance = offset[0].hypot(offset[1]);
        let mut r = horizontal_distance * n * h / (d + n * h);
        for _ in 0..STEPS {
            let (a, b) = ((r * r + h * h).sqrt(), ((horizontal_distance - r).powi(2) + d * d).sqrt());
            let miss = r / a - n * (horizontal_distance - r) / b;
            let step = miss / (h * h / (a * a * a) + n * d * d / (b * b * b));
            r -= step;
            if step.abs() < TOLERANCE * horizontal_distance {
                break;
            }
        }
        let fraction = if horizontal_distance > 0.0 { r / horizontal_distance } else { 0.0 };
        [eye[0] + fraction * offset[0], eye[1] + fraction * offset[1], self.surface]
    }

    /// The point at height `z` (m) on the ray from `eye` through the point `through` of the rippled surface.
    ///
    /// t = i / n + (c / n − √(1 − (1 − c²) / n²)) N with c = −i · N    (Snell as vectors)
    fn landing_point(&self, eye: Point3, through: Point3, t: Second, z: Metre) -> Point2 {
        let [sx, sy] = self.surface_slope([through[0], through[1]], t);
        let normal = vec3::scale([-sx, -sy, 1.0], 1.0 / (1.0 + sx * sx + sy * sy).sqrt());
        let ray = vec3::sub(through, eye);
        let ray = vec3::scale(ray, 1.0 / vec3::norm(ray));
        let (c, n) = (-vec3::dot(ray, normal), self.index);
        let along_normal = c / n - (1.0 - (1.0 - c * c) / (n * n)).sqrt();
        let refracted = vec3::add(vec3::scale(ray, 1.0 / n), vec3::scale(normal, along_normal));
        let far = (z - through[2]) / refracted[2];
        [through[0] + far * refracted[0], through[1] + far * refracted[1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;

    const EYE: Point3 = [0.058, 0.002, 0.205];
    const AT: Point3 = [0.12, -0.03, 0.01];

    #[test]
    fn the_crossing_minimises_the_travel_time_of_light() {
        let water = Water::at_rest(0.05, 1.333);
        let found = water.apparent_point(EYE, AT, 0.0);
        let time = |x: f64, y: f64| {
            let there = [x, y, water.surface];
            vec3::norm(vec3::sub(there, EYE)) + water.index * vec3::norm(vec3::sub(AT, there))
        };
        let best = time(found[0], found[1]);
        for [dx, dy] in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]] {
            let (near, step) = (time(found[0] + 1e-5 * dx, found[1] + 1e-5 * dy), 1e-5);
            // a minimum: a step costs its square over the distances, and nothing of first order (which would be 1e-8 for 1e-3 rad)
            assert!(near > best && near - best < 20.0 * step * step, "{}", near - best);
        }
    }

    #[test]
    fn a_ray_towards_the_apparent_position_meets_the_point_under_ripples() {
        let set = Settings::built_in().water;
        let water = Water::at_rest(0.05, 1.333).rippled(&set, &mut RandomStream::new(4, "ripples"));
        for i in 0..20 {
            let t = 0.07 * f64::from(i);
            let apparent = water.apparent_point(EYE, AT, t);
            let [x, y] = water.landing_point(EYE, apparent, t, AT[2]);
            // a tenth of a micrometre is 0.0005 px here
            assert!((x - AT[0]).hypot(y - AT[1]) < 1e-7, "at {t}: {} {}", x - AT[0], y - AT[1]);
        }
    }

    #[test]
    fn the_approximate_refraction_is_within_a_tenth_of_a_pixel() {
        let set = Settings::built_in().water;
        let water = Water::at_rest(0.05, 1.333).rippled(&set, &mut RandomStream::new(4, "ripples"));
        for i in 0..20 {
            let t = 0.07 * f64::from(i);
            let (fine, rough) = (water.apparent_point(EYE, AT, t), water.apparent_approx(EYE, AT, t));
            let off = (fine[0] - rough[0]).hypot(fine[1] - rough[1]);
            // of a pixel of 0.16 mm at the surface; the ripples themselves move the point by 20 µm
            assert!(off < 1.5e-5, "{off}");
        }
    }

    #[test]
    fn a_point_above_the_surface_is_not_refracted() {
        let lamp = [0.13, 0.04, 0.055];
        assert_eq!(Water::at_rest(0.05, 1.333).apparent_point(EYE, lamp, 1.0), lamp);
    }

    #[test]
    fn ripples_have_the_mean_squared_slope_of_the_settings() {
        let set = settings::Water { ripple: [2e-3, 2e-3], ..Settings::built_in().water };
        let water = Water::at_rest(0.05, 1.333).rippled(&set, &mut RandomStream::new(4, "ripples"));
        let count = 4000;
        let squares = (0..count).map(|i| {
            let [x, y] =
                water.surface_slope([0.013 * f64::from(i % 7), 0.011 * f64::from(i % 5)], 0.037 * f64::from(i));
            x * x + y * y
        });
        let root = (squares.sum::<f64>() / f64::from(count)).sqrt();
        assert!((root / 2e-3 - 1.0).abs() < 0.15, "{root}");
    }
}
