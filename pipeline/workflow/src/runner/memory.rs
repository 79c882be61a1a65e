//! Free memory: whether a further record may be started beside those in progress.
//!
//! Linux reports it; on other systems there is no limit.

use std::fs;

/// Bytes in a GiB over those in a kB of `/proc/meminfo`.
const KIB_IN_GIB: f64 = 1024.0 * 1024.0;

/// Whether at least `min_free_memory` GiB of memory are free.
pub(crate) fn is_free(min_free_memory: f64) -> bool {
    free().is_none_or(|free| free >= min_free_memory)
}

/// Free memory, GiB; none where the system does not report it.
fn free() -> Option<f64> {
    available(&fs::read_to_string("/proc/meminfo").ok()?)
}

fn available(meminfo: &str) -> Option<f64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kib: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib / KIB_IN_GIB)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_memory_is_read_in_gibibytes() {
        assert_eq!(available("MemTotal: 16 kB\nMemAvailable:   3145728 kB\nBuffers: 1 kB\n"), Some(3.0));
        assert_eq!(available("MemTotal: 16 kB\n"), None);
    }

    #[test]
    fn a_machine_has_nothing_to_spare_of_what_it_does_not_have() {
        assert!(is_free(0.0));
        assert!(!is_free(f64::INFINITY) || free().is_none());
    }
}
