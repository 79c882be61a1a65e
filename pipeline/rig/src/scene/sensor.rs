//! The sensor: uneven illumination, noise and quantisation to grey levels.

use track::Gray;

use super::Canvas;
use crate::random::RandomStream;

/// The relative illumination of each pixel, and the noise.
pub(crate) struct Sensor {
    light: Vec<f32>,
    /// Normal noise at 256 even steps of probability, grey levels.
    noise: [f32; 256],
    seed: u64,
}

/// Vignetting: loss of light at the far corner. Illumination gradient: difference between the two sides.
const FALL_OFF: f64 = 0.16;
const SLOPE: f64 = 0.07;

impl Sensor {
    /// A sensor of `width` × `height` px with noise of deviation `noise` grey levels.
    pub(crate) fn new(width: usize, height: usize, noise: f64, seed: u64) -> Self {
        let light = (0..width * height).map(|i| {
            let u = 2.0 * (i % width) as f64 / width as f64 - 1.0;
            let v = 2.0 * (i / width) as f64 / height as f64 - 1.0;
            (1.0 - 0.5 * FALL_OFF * ((u - 0.15).powi(2) + (v + 0.1).powi(2)) + SLOPE * (0.8 * u - 0.3 * v)) as f32
        });
        let mut table = [0.0; 256];
        for (i, level) in table.iter_mut().enumerate() {
            *level = (noise * normal_quantile((i as f64 + 0.5) / 256.0)) as f32;
        }
        Self { light: light.collect(), noise: table, seed }
    }

    /// The picture of `canvas`; `label` and `frame` select its noise.
    pub(crate) fn expose_canvas(&self, canvas: &Canvas, label: &str, frame: usize) -> Gray {
        let mut bytes = vec![0; canvas.levels.len()];
        RandomStream::new(self.seed, &format!("sensor {label} {frame}")).bytes(&mut bytes);
        let lit = canvas.levels.iter().zip(&self.light).zip(&bytes);
        let pixel =
            |((level, light), byte): ((&f32, &f32), &u8)| (level * light + self.noise[*byte as usize] + 0.5) as u8;
        Gray { width: canvas.width, height: canvas.height, pixels: lit.map(pixel).collect() }
    }
}

/// The quantile of the standard normal distribution at `p`, from its cumulative sum.
fn normal_quantile(p: f64) -> f64 {
    let steps = 12_000;
    let width = 12.0 / f64::from(steps);
    let density = |x: f64| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    let mut sum = 0.0;
    for i in 0..steps {
        let x = -6.0 + width * (f64::from(i) + 0.5);
        sum += width * density(x);
        if sum >= p {
            return x;
        }
    }
    6.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_its_standard_deviation_and_is_reproducible() {
        let (width, height) = (200, 150);
        let sensor = Sensor { light: vec![1.0; width * height], ..Sensor::new(width, height, 2.0, 9) };
        let canvas = Canvas::filled(width, height, 100.0);
        let (first, again) = (sensor.expose_canvas(&canvas, "a", 4), sensor.expose_canvas(&canvas, "a", 4));
        let n = first.pixels.len() as f64;
        let mean = first.pixels.iter().map(|p| f64::from(*p)).sum::<f64>() / n;
        let variance = first.pixels.iter().map(|p| (f64::from(*p) - mean).powi(2)).sum::<f64>() / n;
        assert!((mean - 100.0).abs() < 0.05 && (variance.sqrt() - 2.0).abs() < 0.1, "{mean} {variance}");
        assert_eq!(first, again);
        assert_ne!(first, sensor.expose_canvas(&canvas, "a", 5));
    }
}
