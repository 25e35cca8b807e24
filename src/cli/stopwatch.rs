//! The time and the memory that `chebloyd bench` takes.

use std::collections::HashMap;
use std::ffi::OsString;
use std::fs;
use std::time::Instant;

/// The CPU time so far of every thread that is alive (ns).
type Spent = HashMap<OsString, u64>;

/// Measures the time passed, or the CPU time that all threads have spent.
#[derive(Debug)]
pub(crate) struct Stopwatch {
    began: Instant,
    spent: Option<Spent>,
}

impl Stopwatch {
    /// Starts a stopwatch: with `cpu`, for CPU time where the system counts it.
    pub(crate) fn start(cpu: bool) -> Self {
        Self {
            spent: if cpu { spent() } else { None },
            began: Instant::now(),
        }
    }

    /// The time since the start (s).
    pub(crate) fn seconds(&self) -> f64 {
        let passed = self.began.elapsed().as_secs_f64();
        let (Some(before), Some(now)) = (&self.spent, self.spent.as_ref().and_then(|_| spent()))
        else {
            return passed;
        };
        let since = |(thread, time): (&OsString, &u64)| time - before.get(thread).unwrap_or(&0);
        now.iter().map(since).sum::<u64>() as f64 * 1e-9
    }
}

/// The CPU time of all threads of this process so far (s); zero where the system does not count it.
pub(crate) fn cpu_seconds() -> f64 {
    let spent = spent().unwrap_or_default();
    spent.values().sum::<u64>() as f64 * 1e-9
}

/// The CPU time so far, where the system counts it (Linux).
fn spent() -> Option<Spent> {
    let mut spent = Spent::new();
    for thread in fs::read_dir("/proc/self/task").ok()? {
        let thread = thread.ok()?;
        // A thread may have ended since.
        let Ok(text) = fs::read_to_string(thread.path().join("schedstat")) else {
            continue;
        };
        let time = text.split_whitespace().next()?.parse().ok()?;
        spent.insert(thread.file_name(), time);
    }
    (!spent.is_empty()).then_some(spent)
}

/// Lets the peak of memory begin anew, where the system can (Linux).
pub(crate) fn reset_peak_memory() {
    // Where it cannot, the peak is that since the start: more, never less.
    let _ = fs::write("/proc/self/clear_refs", "5");
}

/// The most memory that was resident since then (bytes), where the system counts it.
pub(crate) fn peak_memory() -> Option<u64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kibibytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(1024 * kibibytes)
}
