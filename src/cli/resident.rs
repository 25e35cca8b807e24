//! How much memory the program has held at most.

use std::fs;

/// Lets the peak begin anew, where the system can (Linux).
pub(crate) fn forget() {
    // Where it cannot, the peak is that since the start: more, never less.
    let _ = fs::write("/proc/self/clear_refs", "5");
}

/// The most memory that was resident since then (bytes), where the system tells it.
pub(crate) fn peak() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kibibytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(1024 * kibibytes)
}
