//! Two clocks from the edges that both have seen: a lamp's switchings in a film of 60 Hz and in a log of 1 kHz, whose clock starts later and runs fast.

use si::Series;
use signal::clock::Clock;
use signal::edge::{Window, rising};

/// On the film's clock, s.
const SWITCHINGS: [f64; 4] = [1.013, 4.207, 7.731, 11.109];
/// Times of the log over those of the film, and its time at the film's zero, s.
const SCALE: f64 = 1.0002;
const OFFSET: f64 = -0.35;

/// The lamp's brightness, each sample the mean over an exposure (s) that begins with it.
fn sampled(rate: f64, exposure: f64, switchings: [f64; 4]) -> Option<Series> {
    let lit = |time: f64| {
        let share = |on: f64| ((time - on) / exposure + 1.0).clamp(0.0, 1.0);
        // it is lit for a second after each
        switchings.iter().map(|&on| share(on) - share(on + 1.0)).sum::<f64>()
    };
    let samples = (14.0 * rate) as usize;
    Series::new(0.0, rate, (0..samples).map(|sample| lit(sample as f64 / rate)).collect()).ok()
}

/// # Errors
/// When the edges of one are not those of the other.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let film = sampled(60.0, 0.016, SWITCHINGS).ok_or("no film")?;
    let log = sampled(1000.0, 0.001, SWITCHINGS.map(|time| OFFSET + SCALE * time)).ok_or("no log")?;
    let (here, there) = (rising(&film, Window::exposure(0.016))?, rising(&log, Window::exposure(0.001))?);
    let clock = Clock::from_edges(&here, &there)?;
    println!(
        "offset {:.5} s, scale {:.6}, residual {:.2e} s",
        clock.offset,
        clock.scale,
        clock.rms_error(&here, &there)
    );
    assert!((clock.offset - OFFSET).abs() < 5e-4 && (clock.scale - SCALE).abs() < 1e-4);
    Ok(())
}
