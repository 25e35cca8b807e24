//! Signals that ask a run to end: the first one lets it finish its files, the second ends it at once.
//!
//! Before a run has files of its own the first signal ends it at once, and nothing has been written. The
//! exit code is 128 and the signal's number, as a shell reports it: 130 for SIGINT (Ctrl-C), 143 for
//! SIGTERM, 129 for SIGHUP.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use crate::cli::failure::{Failure, host_stop};

/// What is added to a signal's number in the exit code.
const EXIT: i32 = 128;

/// What has been received since [`Interrupt::listen`].
#[derive(Clone, Debug)]
pub(crate) struct Interrupt {
    /// The number of the last signal; zero before the first.
    signal: Arc<AtomicUsize>,
    /// Whether the next signal ends the process.
    is_final: Arc<AtomicBool>,
    /// The flag of the program within which the run is called, whose signals are its own.
    host: Option<Arc<AtomicBool>>,
}

impl Interrupt {
    /// Listens for signals; each ends the process until [`Interrupt::finish_first`].
    pub(crate) fn listen() -> Result<Self, Failure> {
        let interrupt = Self {
            signal: Arc::default(),
            is_final: Arc::new(AtomicBool::new(true)),
            host: host_stop(),
        };
        if interrupt.host.is_some() {
            return Ok(interrupt);
        }
        for signal in signals() {
            interrupt.register(signal).map_err(|error| {
                Failure::run(format!("cannot listen for signal {signal}: {error}"))
            })?;
        }
        Ok(interrupt)
    }

    /// The actions run in this order whenever the signal arrives.
    fn register(&self, signal: i32) -> std::io::Result<()> {
        flag::register_conditional_shutdown(signal, EXIT + signal, self.is_final.clone())?;
        let number = usize::try_from(signal).unwrap_or_default();
        flag::register_usize(signal, self.signal.clone(), number)?;
        flag::register(signal, self.is_final.clone())?;
        Ok(())
    }

    /// From now on there are files to finish: the next signal is only noted, and the one after it ends
    /// the process.
    pub(crate) fn finish_first(&self) {
        self.is_final.store(false, Ordering::SeqCst);
    }

    /// The exit code of a run that a signal has ended; none while there was no signal.
    pub(crate) fn exit_code(&self) -> Option<u8> {
        let host = self.host.as_ref();
        if host.is_some_and(|flag| flag.load(Ordering::Relaxed)) {
            return u8::try_from(EXIT + SIGINT).ok();
        }
        match self.signal.load(Ordering::SeqCst) {
            0 => None,
            signal => u8::try_from(EXIT as usize + signal).ok(),
        }
    }
}

#[cfg(unix)]
fn signals() -> Vec<i32> {
    let mut signals = vec![SIGINT, SIGTERM];
    if !is_hangup_ignored() {
        signals.push(signal_hook::consts::SIGHUP);
    }
    signals
}

#[cfg(not(unix))]
fn signals() -> Vec<i32> {
    vec![SIGINT, SIGTERM]
}

/// Whether SIGHUP is ignored, as under `nohup`: it must stay so. Known on Linux only (proc(5): `SigIgn`
/// is the mask of ignored signals in hexadecimal).
#[cfg(unix)]
fn is_hangup_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal_hook::consts::SIGHUP - 1) & 1 == 1)
}
