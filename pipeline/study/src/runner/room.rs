//! Room in memory: whether another record may be begun beside those that are being made.
//!
//! Linux says what is free; elsewhere nothing is held back.
//!
//! Stands on: nothing. Never knows: what a record needs.

use std::fs;

/// Bytes in a GiB over those in a kB of `/proc/meminfo`.
const KIB_IN_GIB: f64 = 1024.0 * 1024.0;

/// Whether at least `spare` GiB of memory are free.
pub fn is_left(spare: f64) -> bool {
    free().is_none_or(|free| free >= spare)
}

/// Free memory, GiB; none where the system does not say.
fn free() -> Option<f64> {
    available(&fs::read_to_string("/proc/meminfo").ok()?)
}

fn available(told: &str) -> Option<f64> {
    let line = told.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kib: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib / KIB_IN_GIB)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_system_says_is_read_in_gibibytes() {
        assert_eq!(available("MemTotal: 16 kB\nMemAvailable:   3145728 kB\nBuffers: 1 kB\n"), Some(3.0));
        assert_eq!(available("MemTotal: 16 kB\n"), None);
    }

    #[test]
    fn a_machine_has_nothing_to_spare_of_what_it_does_not_have() {
        assert!(is_left(0.0));
        assert!(!is_left(f64::INFINITY) || free().is_none());
    }
}
