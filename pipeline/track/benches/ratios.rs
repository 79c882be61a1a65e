//! Cost of tracking: frames a second on one core, 1280 × 720 px with three markers, from the film to the tracks; beside OpenCV's optical flow
//! (`opencv.py`) where a Python has it.
#![allow(clippy::print_stdout)] // a bench prints

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use si::Point2;
use track::Gray;
use track::klt::{Settings, Tracker, find_blobs};
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

/// Rates of which the best of a few runs counts: other programs may share the machine.
const RUNS: usize = 3;

/// Frames a second of OpenCV from the same film, on one thread; none where there is no Python with cv2 ($PYTHON, or python3).
fn opencv(film: &Path) -> Option<f64> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/opencv.py");
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".into());
    let starts = places(0).map(|[x, y]| format!("{x},{y}"));
    let ran = Command::new(python).arg(script).arg(film).args(starts).output().ok()?;
    String::from_utf8_lossy(&ran.stdout).trim().parse().ok()
}

/// From a film to tracks, the markers looked for in the whole first picture: seconds of the first frame and of the others.
fn track(film: &Path) -> Result<[f64; 2], VideoError> {
    let (set, start) = (Settings::default(), Instant::now());
    let mut frames = Reader::open(film)?;
    let first_frame = frames.next().expect("the film has frames")?.gray;
    let whole_frame = [0.0, 0.0, SIZE.0 as f64, SIZE.1 as f64];
    let mut tracker = Tracker::new(&first_frame, &find_blobs(&first_frame, whole_frame, 3, &set), set)
        .expect("the markers are there");
    let search_seconds = start.elapsed().as_secs_f64();
    for frame in frames {
        tracker.step(&frame?.gray).expect("nothing hides them");
    }
    Ok([search_seconds, start.elapsed().as_secs_f64() - search_seconds])
}

/// Seconds to read the film alone.
fn read(film: &Path) -> Result<f64, VideoError> {
    let start = Instant::now();
    Reader::open(film)?.try_for_each(|frame| frame.map(drop))?;
    Ok(start.elapsed().as_secs_f64())
}

fn main() -> Result<(), VideoError> {
    let file = std::env::temp_dir().join("track-bench.mp4");
    let pictures: Vec<Gray> = (0..FRAMES).map(picture).collect();
    // the last codes the noise of the sensor, as cameras do at high bit rates
    for quantiser in [28, 20, 16] {
        let mut writer = Writer::create(&file, SIZE, 60.0, Quality::Quantiser(quantiser))?;
        pictures.iter().try_for_each(|p| writer.push(p))?;
        writer.finish()?;
        let (mut reading, mut first, mut others, mut peer) = (f64::INFINITY, f64::INFINITY, f64::INFINITY, None);
        for _ in 0..RUNS {
            let [found, rest] = track(&file)?;
            (first, others, reading) = (first.min(found), others.min(rest), reading.min(read(&file)?));
            peer = opencv(&file).into_iter().chain(peer).reduce(f64::max);
        }
        let rate = FRAMES as f64 / (first + others);
        println!(
            "quantiser {quantiser}: from film to tracks {rate:.0} frames/s on one core ({:.0} behind the first, which takes {first:.2} s); reading alone {:.0}",
            (FRAMES - 1) as f64 / others,
            FRAMES as f64 / reading,
        );
        match peer {
            Some(peer) => println!("  OpenCV {peer:.0} frames/s: this over OpenCV {:.2}", rate / peer),
            None => println!("  no Python with cv2 is at hand: OpenCV is not measured"),
        }
    }
    let _ = std::fs::remove_file(&file);
    Ok(())
}
