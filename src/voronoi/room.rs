//! How much memory there is to keep things in that could be computed anew.

use std::fs;

/// Where the system does not tell what is free, this much may be taken (bytes): enough for 2.5
/// million cells.
const UNTOLD: u64 = 2 << 30;

/// The memory that may be taken for comfort (bytes): half of what Linux says is available to new
/// programs, within the limits of the control group.
#[must_use]
pub(crate) fn room() -> u64 {
    let available = fs::read_to_string("/proc/meminfo")
        .ok()
        .and_then(|text| available(&text));
    let number = |path: &str| fs::read_to_string(path).ok()?.trim().parse::<u64>().ok();
    let allowed = number("/sys/fs/cgroup/memory.max")
        .zip(number("/sys/fs/cgroup/memory.current"))
        .map(|(most, now)| most.saturating_sub(now));
    match (available, allowed) {
        (Some(available), Some(allowed)) => available.min(allowed) / 2,
        (Some(available), None) => available / 2,
        _ => UNTOLD,
    }
}

/// The line `MemAvailable:  123 kB` in bytes.
fn available(meminfo: &str) -> Option<u64> {
    let line = meminfo
        .lines()
        .find(|line| line.starts_with("MemAvailable:"))?;
    let kibibytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(1024 * kibibytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_linux_says_is_understood() {
        let meminfo = "MemTotal: 16 kB\nMemFree:  3 kB\nMemAvailable:      12 kB\n";
        assert_eq!(available(meminfo), Some(12 * 1024));
        assert_eq!(available("MemTotal: 16 kB\n"), None);
    }
}
