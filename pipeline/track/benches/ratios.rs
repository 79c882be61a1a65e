//! Cost of tracking: frames a second on one core, 1280 × 720 px with three markers, from the file and without it.
#![allow(clippy::print_stdout)] // a bench prints

use std::time::Instant;

use si::Point2;
use track::Gray;
use track::klt::{Settings, Tracker};
use track::video::{Quality, Reader, VideoError, Writer};

const FRAMES: usize = 240;
const SIZE: (usize, usize) = (1280, 720);

/// Three discs that flap at 4 Hz over a grid.
fn places(k: usize) -> [Point2; 3] {
    let phase = std::f64::consts::TAU * 4.0 * k as f64 / 60.0;
    [(540.4, 8.0), (600.7, 15.0), (660.1, 25.0)].map(|(x, swing)| [x, 360.3 + swing * phase.sin()])
}

fn picture(k: usize) -> Gray {
    let mut seed = k as u32 * 2_654_435 + 1;
    Gray::from_fn(SIZE.0, SIZE.1, |x, y| {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let noise = f64::from(seed >> 24) / 256.0 * 4.0 - 2.0;
        let tail = (300..720).contains(&x) && (260..460).contains(&y);
        let grid = x % 44 < 4 || y % 44 < 4;
        let ground = if tail {
            165.0
        } else if grid {
            170.0
        } else {
            46.0
        };
        let share = |p: &Point2| (10.5 - (x as f64 - p[0]).hypot(y as f64 - p[1])).clamp(0.0, 1.0);
        ground - 140.0 * places(k).iter().map(share).fold(0.0, f64::max) + noise
    })
}

fn main() -> Result<(), VideoError> {
    let file = std::env::temp_dir().join("track-bench.mp4");
    let pictures: Vec<Gray> = (0..FRAMES).map(picture).collect();
    for quantiser in [20, 28] {
        let mut writer = Writer::create(&file, SIZE, 60.0, Quality::Quantiser(quantiser))?;
        pictures.iter().try_for_each(|p| writer.push(p))?;
        writer.finish()?;
        let start = Instant::now();
        let film: Vec<Gray> = Reader::open(&file)?.map(|f| f.map(|f| f.gray)).collect::<Result<_, _>>()?;
        let read = start.elapsed().as_secs_f64();
        let begin = |first: &Gray| Tracker::new(first, &places(0), Settings::default()).expect("the markers are there");
        let mut tracker = begin(&film[0]);
        let start = Instant::now();
        film[1..].iter().for_each(|p| drop(tracker.step(p).expect("nothing hides them")));
        let tracked = start.elapsed().as_secs_f64();
        let rate = |seconds: f64| FRAMES as f64 / seconds;
        println!(
            "quantiser {quantiser}: reading {:.0} frames/s, tracking {:.0}, from file to tracks {:.0}",
            rate(read),
            rate(tracked),
            rate(read + tracked)
        );
    }
    let _ = std::fs::remove_file(&file);
    Ok(())
}
