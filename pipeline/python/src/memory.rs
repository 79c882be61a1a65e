//! Memory that a call would take, estimated before it is taken: a process that asks for more than there is ends, and with it the interpreter.

use std::fs;

use pyo3::PyResult;

use crate::errors::input_error;

/// Bytes of a gigabyte.
const GIGABYTE: f64 = 1e9;
/// Part of the free memory that one call may take.
const PART: f64 = 0.9;

/// Holds that `bytes` are free for `what`.
///
/// # Errors
/// `InputError` with both numbers.
pub(crate) fn require_free(what: &str, bytes: f64) -> PyResult<()> {
    let Some(free) = free_bytes() else { return Ok(()) };
    if bytes <= PART * free {
        return Ok(());
    }
    let (needed, free) = (bytes / GIGABYTE, free / GIGABYTE);
    let reason = format!("it needs about {needed:.3} GB of memory, and {free:.3} GB are free for this process");
    Err(input_error(format!("{what} is too large"), reason, "take a coarser mesh, fewer steps or fewer shapes"))
}

/// Bytes that this process can take: what the machine has, within the limit of its address space. None where the system does not say.
fn free_bytes() -> Option<f64> {
    let machine = read_kilobytes(&fs::read_to_string("/proc/meminfo").ok()?, "MemAvailable:")?;
    let limits = fs::read_to_string("/proc/self/limits").ok()?;
    let limit = limits.lines().find_map(|line| line.strip_prefix("Max address space")?.split_whitespace().next());
    let taken = read_kilobytes(&fs::read_to_string("/proc/self/status").ok()?, "VmSize:")?;
    let left_of_limit = limit.and_then(|word| word.parse::<f64>().ok()).map(|limit| (limit - taken).max(0.0));
    Some(left_of_limit.map_or(machine, |left_of_limit| left_of_limit.min(machine)))
}

fn read_kilobytes(text: &str, key: &str) -> Option<f64> {
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    Some(1024.0 * line.split_whitespace().next()?.parse::<f64>().ok()?)
}
