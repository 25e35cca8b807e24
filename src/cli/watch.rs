//! Stop watches of `chebloyd bench`.

use std::collections::HashMap;
use std::ffi::OsString;
use std::fs;
use std::time::Instant;

/// The CPU time so far of every thread that is alive (ns).
type Spent = HashMap<OsString, u64>;

/// Measures the time passed, or the CPU time that all threads have spent.
#[derive(Debug)]
pub(crate) struct Watch {
    began: Instant,
    spent: Option<Spent>,
}

impl Watch {
    /// Starts a watch, for CPU time if asked to and able to.
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

/// Linux tells it by the nanosecond.
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
