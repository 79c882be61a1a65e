//! The lamp in films: the place that is dark, then light, then dark again in every film of a camera.

use si::Point2;
use track::Gray;

/// Blocks across the longer side of a picture.
const BLOCKS: usize = 160;
/// Frames of which the blocks are kept: 60 MB of them.
const MOST_FRAMES: usize = 4000;
/// Least difference of on and off, grey levels, and least level of a lamp that is on.
const LEAST_CONTRAST: f64 = 40.0;
const LEAST_LEVEL: f64 = 110.0;
/// A level within this share of the difference from either end is that of the lamp on or off.
const NEAR: f64 = 0.25;

/// Mean levels of the blocks of a film's frames.
#[derive(Debug, Default)]
pub(super) struct Blocks {
    side: usize,
    columns: usize,
    rows: usize,
    /// Frames × blocks.
    pub(super) frames: Vec<Vec<u8>>,
    /// When each of these frames is, s.
    pub(super) times: Vec<f64>,
    /// Frames of the film from one that is kept to the next.
    every: usize,
    count: usize,
}

/// The lamp of a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lamp {
    /// Its middle, px.
    pub(super) centre: Point2,
    /// Of the part that is surely bright, px.
    pub(super) radius: f64,
    block: usize,
}

impl Blocks {
    pub(super) fn new(width: usize, height: usize, frames: usize) -> Self {
        let side = (width.max(height) / BLOCKS).max(1);
        let every = frames.div_ceil(MOST_FRAMES).max(1);
        Self { side, columns: width / side, rows: height / side, every, ..Self::default() }
    }

    /// Takes the next frame in.
    pub(super) fn push(&mut self, time: f64, picture: &Gray) {
        if self.count.is_multiple_of(self.every) {
            self.times.push(time);
            let block = |k: usize| self.mean(picture, k % self.columns, k / self.columns);
            self.frames.push((0..self.columns * self.rows).map(block).collect());
        }
        self.count += 1;
    }

    fn mean(&self, picture: &Gray, column: usize, row: usize) -> u8 {
        let line =
            |y: usize| &picture.pixels[(row * self.side + y) * picture.width + column * self.side..][..self.side];
        let sum: u32 = (0..self.side).flat_map(line).map(|level| u32::from(*level)).sum();
        (sum / (self.side * self.side) as u32) as u8
    }

    fn series(&self, block: usize) -> Vec<f64> {
        self.frames.iter().map(|frame| f64::from(frame[block])).collect()
    }

    /// How much a block behaves as a lamp: its contrast, where it is off, on and off again, or the film ends before.
    fn contrast(&self, block: usize) -> f64 {
        on_interval(&self.series(block)).map_or(0.0, |on| on.contrast * if on.until.is_some() { 1.0 } else { 0.5 })
    }

    /// When the lamp lights and goes out; none where the film ends before.
    pub(super) fn lit(&self, lamp: &Lamp) -> Option<Lit> {
        let on = on_interval(&self.series(lamp.block))?;
        // between the first frame that shows the change and the one before it
        let switched = |frame: usize| Some(0.5 * (self.times.get(frame.checked_sub(1)?)? + self.times.get(frame)?));
        Some(Lit { from: switched(on.from)?, until: switched(on.until?)?, step: self.step()? })
    }

    /// Mean time from one frame that is kept to the next, s.
    pub(super) fn step(&self) -> Option<f64> {
        let (first, last) = (self.times.first()?, self.times.last()?);
        (last > first).then(|| (last - first) / (self.times.len() - 1) as f64)
    }
}

/// When the lamp of a film is on, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lit {
    pub(super) from: f64,
    pub(super) until: f64,
    /// Time from one frame to the next.
    pub(super) step: f64,
}

struct On {
    from: usize,
    until: Option<usize>,
    contrast: f64,
}

/// The one interval in which a series is high; none where there is none, or several.
fn on_interval(series: &[f64]) -> Option<On> {
    let (low, high) = series.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let contrast = high - low;
    if series.len() < 4 || contrast < LEAST_CONTRAST || high < LEAST_LEVEL {
        return None;
    }
    let middle = 0.5 * (low + high);
    let between_levels = series.iter().filter(|v| (*v - low).min(high - *v) > NEAR * contrast).count();
    let switches: Vec<usize> =
        (1..series.len()).filter(|&k| (series[k] > middle) != (series[k - 1] > middle)).collect();
    let is_dark_first = series[0] < middle;
    // a frame may catch the lamp while it is switched
    match switches[..] {
        [from, until] if is_dark_first && between_levels <= 4 => Some(On { from, until: Some(until), contrast }),
        [from] if is_dark_first && between_levels <= 2 => Some(On { from, until: None, contrast }),
        _ => None,
    }
}

/// The lamp of films of one camera: the block of greatest contrast in all that show one, and its bright neighbours.
pub(super) fn lamp(films: &[&Blocks]) -> Option<Lamp> {
    let first = films.first()?;
    let is_same = |film: &&&Blocks| (film.columns, film.rows, film.side) == (first.columns, first.rows, first.side);
    let films: Vec<&&Blocks> = films.iter().filter(is_same).collect();
    let contrasts: Vec<f64> = (0..first.columns * first.rows)
        .map(|block| films.iter().map(|film| film.contrast(block)).sum::<f64>() / films.len() as f64)
        .collect();
    let block = (0..contrasts.len()).max_by(|&a, &b| contrasts[a].total_cmp(&contrasts[b]))?;
    if contrasts[block] < 0.4 * LEAST_CONTRAST {
        return None;
    }
    let bright = connected_blocks(&contrasts, block, first.columns);
    let weight: f64 = bright.iter().map(|&k| contrasts[k]).sum();
    let mean = |place: fn(usize, usize) -> usize| {
        let middle = |k: usize| (place(k, first.columns) as f64 + 0.5) * first.side as f64 - 0.5;
        bright.iter().map(|&k| contrasts[k] * middle(k)).sum::<f64>() / weight
    };
    let centre = [mean(|k, columns| k % columns), mean(|k, columns| k / columns)];
    let area = weight / contrasts[block] * (first.side * first.side) as f64;
    Some(Lamp { centre, radius: (0.8 * (area / std::f64::consts::PI).sqrt()).max(1.0), block })
}

/// The blocks that are connected with one by their sides and have half its contrast.
fn connected_blocks(contrasts: &[f64], block: usize, columns: usize) -> Vec<usize> {
    let (mut members, mut open) = (Vec::new(), vec![block]);
    while let Some(k) = open.pop() {
        if members.contains(&k) || contrasts[k] < 0.5 * contrasts[block] {
            continue;
        }
        members.push(k);
        open.extend((k % columns > 0).then(|| k - 1));
        open.extend(Some(k + 1).filter(|right| right % columns > 0));
        open.extend(k.checked_sub(columns));
        open.extend(Some(k + columns));
        open.retain(|k| *k < contrasts.len());
    }
    members
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Thirty frames of 320 × 200 px: a lamp of 9 px at (250, 40) from frame 5 to 20, a dark mark that comes and goes twice.
    fn film() -> Blocks {
        let mut blocks = Blocks::new(320, 200, 30);
        for frame in 0..30 {
            let is_on = (5..20).contains(&frame);
            let aside = if frame / 5 % 2 == 1 { 40.0 } else { 0.0 };
            blocks.push(
                f64::from(frame) / 60.0,
                &Gray::from_fn(320, 200, |x, y| {
                    let distance = |u: f64, v: f64| (x as f64 - u).hypot(y as f64 - v);
                    match (distance(250.0, 40.0) < 9.0, distance(100.0 + aside, 120.0) < 12.0) {
                        (true, _) => {
                            if is_on {
                                230.0
                            } else {
                                30.0
                            }
                        }
                        (_, true) => 40.0,
                        _ => 150.0,
                    }
                }),
            );
        }
        blocks
    }

    #[test]
    fn the_lamp_is_found_where_it_is_with_the_frames_in_which_it_is_on() {
        let film = film();
        let lamp = lamp(&[&film]).unwrap();
        assert!((lamp.centre[0] - 250.0).hypot(lamp.centre[1] - 40.0) < 2.0, "{lamp:?}");
        assert!((4.0..10.0).contains(&lamp.radius), "{lamp:?}");
        let lit = film.lit(&lamp).unwrap();
        let off = [lit.from - 4.5 / 60.0, lit.until - 19.5 / 60.0, lit.step - 1.0 / 60.0];
        assert!(off.iter().all(|off| off.abs() < 1e-12), "{lit:?}");
    }

    #[test]
    fn a_film_without_a_lamp_has_none() {
        let mut blocks = Blocks::new(320, 200, 10);
        (0..10).for_each(|k| blocks.push(f64::from(k), &Gray::filled(320, 200, 90)));
        assert_eq!(lamp(&[&blocks]), None);
        assert_eq!(lamp(&[]), None);
    }
}
