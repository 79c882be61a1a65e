//! Memory: whether a further record may be started beside those in progress.
//!
//! A record is expected to need the peak that was measured of the records of its stage. All that are in progress share what was free when
//! the run began, or what the run may use; and none is started while the system is short of memory, whoever uses it. Linux reports free
//! memory, of the machine and of a control group (cgroup v2); on other systems there is no limit but the run's own.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Bytes in a GiB.
const GIB: f64 = 1_073_741_824.0;
/// kB of `/proc/meminfo`, and MiB, in a GiB.
const KIB_IN_GIB: f64 = 1_048_576.0;
const MIB_IN_GIB: f64 = 1024.0;

/// The memory that the records in progress share.
pub(crate) struct Budget {
    /// For all of them, GiB; none without a limit.
    limit: Option<f64>,
    /// The free memory that is required, and the peak of a stage of which nothing was measured, GiB.
    min_free: f64,
    peaks: BTreeMap<&'static str, f64>,
}

impl Budget {
    /// The budget of a run that may use `limit` GiB, or what is free now.
    ///
    /// `peaks` are measured ones with their stages, MiB.
    pub fn new(limit: Option<f64>, min_free: f64, peaks: impl Iterator<Item = (&'static str, f64)>) -> Self {
        let mut largest: BTreeMap<&'static str, f64> = BTreeMap::new();
        for (stage, peak) in peaks {
            let largest_peak = largest.entry(stage).or_default();
            *largest_peak = largest_peak.max(peak / MIB_IN_GIB);
        }
        Self { limit: limit.or_else(free_memory), min_free, peaks: largest }
    }

    /// The memory that a record of a stage is expected to need, GiB.
    pub fn expected(&self, stage: &str) -> f64 {
        self.peaks.get(stage).copied().unwrap_or(self.min_free)
    }

    /// Whether a record of a stage may be started beside others that are expected to need `in_use` GiB.
    pub(crate) fn has_room(&self, stage: &str, in_use: f64) -> bool {
        self.limit.is_none_or(|limit| in_use + self.expected(stage) <= limit)
            && free_memory().is_none_or(|free| free >= self.min_free)
    }
}

/// Free memory of the machine, or of this process's control group where that is less, GiB; none where the system does not report it.
fn free_memory() -> Option<f64> {
    let machine = available_memory(&fs::read_to_string("/proc/meminfo").ok()?)?;
    Some(group_free().map_or(machine, |group| group.min(machine)))
}

fn available_memory(meminfo: &str) -> Option<f64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kib: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib / KIB_IN_GIB)
}

/// What the limit of the control group leaves, GiB; none without a limit.
fn group_free() -> Option<f64> {
    let groups = fs::read_to_string("/proc/self/cgroup").ok()?;
    let group = groups.lines().find_map(|line| line.strip_prefix("0::/"))?;
    left_in(&Path::new("/sys/fs/cgroup").join(group))
}

fn left_in(group: &Path) -> Option<f64> {
    let bytes = |file: &str| fs::read_to_string(group.join(file)).ok()?.trim().parse::<f64>().ok();
    Some((bytes("memory.max")? - bytes("memory.current")?) / GIB)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn free_memory_is_read_in_gibibytes() {
        assert_eq!(available_memory("MemTotal: 16 kB\nMemAvailable:   3145728 kB\nBuffers: 1 kB\n"), Some(3.0));
        assert_eq!(available_memory("MemTotal: 16 kB\n"), None);
    }

    #[test]
    fn records_share_the_limit_by_the_largest_measured_peak_of_their_stage() {
        let budget = Budget::new(Some(4.0), 0.0, [("a", 1024.0), ("a", 2048.0)].into_iter());
        assert!((budget.expected("a") - 2.0).abs() < 1e-12 && budget.expected("unmeasured") == 0.0);
        assert!(budget.has_room("a", 2.0) && !budget.has_room("a", 2.5));
        assert!(budget.has_room("unmeasured", 4.0));
    }

    #[test]
    fn a_machine_has_no_room_for_what_it_does_not_have() {
        let budget = |min_free| Budget::new(Some(f64::INFINITY), min_free, std::iter::empty());
        assert!(budget(0.0).has_room("a", 0.0));
        assert!(!budget(f64::INFINITY).has_room("a", 0.0) || free_memory().is_none());
    }

    #[test]
    fn a_control_group_leaves_its_limit_less_what_it_uses() {
        let group = std::env::temp_dir().join(format!("cgroup-{}", std::process::id()));
        fs::create_dir_all(&group).unwrap();
        fs::write(group.join("memory.current"), "1073741824\n").unwrap();
        fs::write(group.join("memory.max"), "max\n").unwrap();
        assert_eq!(left_in(&group), None);
        fs::write(group.join("memory.max"), "4294967296\n").unwrap();
        assert_eq!(left_in(&group), Some(3.0));
        fs::remove_dir_all(&group).unwrap();
    }
}
