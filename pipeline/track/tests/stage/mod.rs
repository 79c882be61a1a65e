//! Films by formula for the tests of trackers: dark marks on light ground, uneven light, noise, and what disturbs them.

use super::noise::Noise;
use si::Point2;
use track::Gray;
use track::video::{Quality, Reader, Writer};

/// Samples along each side of a pixel at a marker's edge.
const FINE: usize = 6;

/// Draws something over frame `k`.
pub type Show = fn(usize, &mut Gray);

/// A film.
pub struct Scene {
    /// Places and turns (px, rad) of the markers in frame k.
    pub marks: Box<dyn Fn(usize) -> Vec<(Point2, f64)>>,
    /// px.
    pub size: (usize, usize),
    /// Crosses instead of discs.
    pub crosses: bool,
    /// Light in frame k, no unit.
    pub light: fn(usize) -> f64,
    /// Width of the markers' edge in frame k, px.
    pub blur: fn(usize) -> f64,
    /// Light that bends over a tail's back, as a lamp beside it makes it, grey levels.
    pub flank: f64,
    /// Drawn last.
    pub show: Show,
    /// Quantiser of the codec that the film goes through, if any.
    pub codec: Option<u8>,
    /// Frames that have come out of the codec.
    pub frames: Vec<Gray>,
}

impl Scene {
    /// Discs in even light.
    pub fn new(marks: impl Fn(usize) -> Vec<(Point2, f64)> + 'static) -> Self {
        Self {
            marks: Box::new(marks),
            size: (320, 240),
            crosses: false,
            light: |_| 1.0,
            blur: |_| 0.0,
            flank: 0.0,
            show: |_, _| {},
            codec: None,
            frames: Vec::new(),
        }
    }

    /// True places in frame `k`, px.
    pub fn places(&self, k: usize) -> Vec<Point2> {
        (self.marks)(k).into_iter().map(|(at, _)| at).collect()
    }

    /// Frame `k`.
    pub fn picture(&self, k: usize) -> Gray {
        self.frames.get(k).cloned().unwrap_or_else(|| self.drawn(k))
    }

    /// The film of `frames` frames after its codec.
    pub fn coded(mut self, frames: usize) -> Self {
        let file = std::env::temp_dir().join(format!("track-{}-{:?}.mp4", std::process::id(), self.codec));
        let quality = Quality::Quantiser(self.codec.unwrap());
        let mut writer = Writer::create(&file, self.size, 60.0, quality).unwrap();
        (0..frames).for_each(|k| writer.push(&self.drawn(k)).unwrap());
        writer.finish().unwrap();
        self.frames = Reader::open(&file).unwrap().map(|frame| frame.unwrap().gray).collect();
        let _ = std::fs::remove_file(&file);
        self
    }

    fn drawn(&self, k: usize) -> Gray {
        let (marks, light, blur) = ((self.marks)(k), (self.light)(k), (self.blur)(k));
        let mut random = Noise(k as u64 + 1);
        let mut picture = Gray::from_fn(self.size.0, self.size.1, |x, y| {
            let bent = self.flank * (0.055 * (y as f64 - 105.0) + 0.01 * x as f64).sin();
            let ground = 178.0 + 0.03 * x as f64 - 0.04 * y as f64 + bent;
            let near = |m: &&(Point2, f64)| (x as f64 - m.0[0]).abs() < 20.0 && (y as f64 - m.0[1]).abs() < 20.0;
            let dark: f64 = marks.iter().filter(near).map(|m| self.share(*m, blur, x, y)).sum();
            light * ground * (1.0 - 0.75 * dark) + 1.4 * random.next()
        });
        (self.show)(k, &mut picture);
        picture
    }

    /// Share of pixel (x, y) that a mark covers.
    fn share(&self, (at, turn): (Point2, f64), blur: f64, x: usize, y: usize) -> f64 {
        let fine = |v: usize, i: usize| v as f64 + (i as f64 + 0.5) / FINE as f64 - 0.5;
        let (sine, cosine) = turn.sin_cos();
        let cover = |k: usize| {
            let (dx, dy) = (fine(x, k % FINE) - at[0], fine(y, k / FINE) - at[1]);
            if self.crosses {
                let (u, v) = ((cosine * dx + sine * dy).abs(), (cosine * dy - sine * dx).abs());
                return f64::from(u8::from((u < 13.0 && v < 3.0) || (v < 13.0 && u < 3.0)));
            }
            let out = dx.hypot(dy) - 10.0;
            if blur > 0.0 { (0.5 - 0.5 * out / blur).clamp(0.0, 1.0) } else { f64::from(u8::from(out < 0.0)) }
        };
        (0..FINE * FINE).map(cover).sum::<f64>() / (FINE * FINE) as f64
    }
}

/// Fills a rectangle (left, top, right, bottom, px) with one level.
pub fn cover(picture: &mut Gray, [left, top, right, bottom]: [f64; 4], level: u8) {
    for y in top as usize..bottom as usize {
        picture.pixels[y * picture.width..][left as usize..right as usize].fill(level);
    }
}

/// Adds a soft spot of light of deviation `size` (px) and `bright` grey levels.
pub fn glare(picture: &mut Gray, at: Point2, size: f64, bright: f64) {
    for (i, pixel) in picture.pixels.iter_mut().enumerate() {
        let (x, y) = ((i % picture.width) as f64 - at[0], (i / picture.width) as f64 - at[1]);
        let level = f64::from(*pixel) + bright * (-0.5 * (x * x + y * y) / (size * size)).exp();
        *pixel = level.round().min(255.0) as u8;
    }
}
