//! Timing and printing of seconds and ratios.

use crate::Outcome;
use std::time::Instant;

/// Seconds that this thread has run, from the kernel where available, else from the wall clock.
fn cpu(start: Instant) -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = text.and_then(|line| line.split(' ').next().and_then(|word| word.parse::<f64>().ok()));
    nanoseconds.map_or_else(|| start.elapsed().as_secs_f64(), |ns| 1e-9 * ns)
}

/// The least CPU time of `times` runs, s, and what the last one gave.
pub fn timed<T>(times: usize, mut run: impl FnMut() -> Outcome<T>) -> Outcome<(f64, T)> {
    let clock = Instant::now();
    let mut least_seconds = f64::INFINITY;
    let mut given = None;
    for _ in 0..times {
        let start_seconds = cpu(clock);
        given = Some(run()?);
        least_seconds = least_seconds.min(cpu(clock) - start_seconds);
    }
    Ok((least_seconds, given.ok_or("nothing was run")?))
}

/// One line: what, its seconds, and their ratio over another time.
pub fn say(what: &str, seconds: f64, over: Option<(f64, &str)>) {
    match over {
        Some((other, name)) => println!("{what:54} {seconds:8.3} s   {:6.3} of {name}", seconds / other),
        None => println!("{what:54} {seconds:8.3} s"),
    }
}
