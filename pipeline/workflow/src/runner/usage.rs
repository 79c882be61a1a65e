//! What making a record used: processor time and peak memory of the process, as Linux reports them.
//!
//! Both are those of a whole process, so that they are known of a record that is made alone in it: by `study make`, or one after the
//! other. The peak is reset before each record.

use std::fs;
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

/// Ticks of processor time in a second: the unit of `/proc` on every architecture of Linux.
const TICKS: f64 = 100.0;
/// What resets the peak when it is written to `/proc/self/clear_refs` (proc(5)).
const RESET_PEAK: &str = "5";

/// Processor time of the calling thread, s; none where Linux does not say.
pub(super) fn thread_seconds() -> Option<f64> {
    let text = fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = text.split_whitespace().next()?.parse().ok()?;
    Some(1e-9 * nanoseconds)
}

/// When a record was made, and what that used.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Usage {
    /// s since 1970.
    pub begun: Option<f64>,
    /// Processor time, s.
    pub cpu_seconds: Option<f64>,
    /// Peak of resident memory, MiB.
    pub peak_memory: Option<f64>,
}

/// What is known of the costs of a record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// s.
    pub seconds: f64,
    /// Processor time, s.
    pub cpu_seconds: Option<f64>,
    /// Peak of resident memory, MiB.
    pub peak_memory: Option<f64>,
}

/// The costs of a record while it is being made.
pub(crate) struct Meter {
    begun: Option<f64>,
    /// Processor time of the process before; none where other records are made in it.
    cpu_seconds: Option<f64>,
    alone: bool,
}

impl Meter {
    /// Begins; `alone` where no other record is made in this process meanwhile.
    pub fn begin(alone: bool) -> Self {
        // Where the peak cannot be reset, it is that of the records before as well: too large rather than too small.
        let _ = alone.then(|| fs::write("/proc/self/clear_refs", RESET_PEAK));
        let begun = SystemTime::now().duration_since(UNIX_EPOCH).ok().map(|since| since.as_secs_f64());
        Self { begun, cpu_seconds: cpu_seconds().filter(|_| alone), alone }
    }

    /// What was used since.
    pub fn end(&self) -> Usage {
        let used = cpu_seconds().zip(self.cpu_seconds).map(|(now, then)| now - then);
        Usage { begun: self.begun, cpu_seconds: used, peak_memory: peak_memory().filter(|_| self.alone) }
    }
}

fn cpu_seconds() -> Option<f64> {
    parse_cpu_seconds(&fs::read_to_string("/proc/self/stat").ok()?)
}

/// The most memory that this process has held, MiB; none where the system does not say.
pub fn peak_memory() -> Option<f64> {
    parse_peak_memory(&fs::read_to_string("/proc/self/status").ok()?)
}

/// User and system time in a line of `/proc/PID/stat`, s: fields 14 and 15.
fn parse_cpu_seconds(line: &str) -> Option<f64> {
    let fields: Vec<&str> = line.rsplit_once(')')?.1.split_whitespace().collect();
    let field = |number: usize| fields.get(number - 3)?.parse::<f64>().ok();
    Some((field(14)? + field(15)?) / TICKS)
}

fn parse_peak_memory(status: &str) -> Option<f64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<f64>().ok()? / 1024.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_thread_that_works_uses_processor_time_and_one_that_sleeps_does_not() {
        let (Some(begun), clock) = (thread_seconds(), std::time::Instant::now()) else { return };
        std::thread::sleep(std::time::Duration::from_millis(60));
        let slept = thread_seconds().unwrap();
        while clock.elapsed().as_millis() < 400 && thread_seconds().unwrap() < slept + 0.02 {}
        assert!(slept - begun < 0.05 && thread_seconds().unwrap() > slept, "{begun} {slept}");
    }

    #[test]
    fn time_and_peak_are_read_from_what_the_system_prints() {
        assert_eq!(parse_cpu_seconds("7 (a b) c) S 1 7 7 0 -1 0 0 0 0 0 250 50 0 0 20 0"), Some(3.0));
        assert_eq!(parse_peak_memory("VmPeak: 9 kB\nVmHWM:\t 2048 kB\n"), Some(2.0));
        assert_eq!(parse_peak_memory("VmPeak: 9 kB\n"), None);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn memory_that_is_touched_raises_the_peak_and_work_takes_time() {
        let meter = Meter::begin(true);
        let touched = vec![1_u8; 64 << 20];
        let mut sum = 0_u64;
        while meter.end().cpu_seconds.unwrap() < 0.02 {
            sum = touched.iter().fold(sum, |sum, byte| sum.wrapping_mul(31).wrapping_add(u64::from(*byte)));
        }
        let used = meter.end();
        assert!(sum != 1 && used.peak_memory.unwrap() >= 64.0 && used.begun.is_some());
        assert_eq!(Meter::begin(false).end().peak_memory, None);
    }
}
