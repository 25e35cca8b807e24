//! Work on threads of its own, which the calling thread waits for while it listens for signals.
//!
//! Only Python's main thread hears signals, and only while it asks; callbacks belong there too. So the work
//! runs in a pool that is made for it, on a new thread, and tells the caller what happens through a channel.
//! (A pool of its own also survives a fork.) When a signal or a callback raises, the caller raises a flag, at
//! which the workers soon stop, and does not wait for them.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use pyo3::prelude::*;

use crate::errors::failed;

/// How long the caller sleeps between two looks for signals.
const LOOK: Duration = Duration::from_millis(20);

/// The flag that stops work.
pub(crate) type Flag = Arc<AtomicBool>;

/// What the work tells: an event, or its result.
enum Told<Event, T> {
    Event(Event),
    Done(T),
}

/// Tells the caller of events.
pub(crate) struct Teller<Event, T> {
    tell: Sender<Told<Event, T>>,
    answered: Receiver<bool>,
}

impl<Event, T> Teller<Event, T> {
    /// Tells of an event, waits until the caller has dealt with it, and says whether to go on.
    pub(crate) fn tell(&self, event: Event) -> bool {
        self.tell.send(Told::Event(event)).is_ok() && self.answered.recv().unwrap_or(false)
    }
}

/// Runs `work` on `threads` threads (all cores if not given) without Python's lock. `hear` deals with events
/// on the calling thread; its `false` asks the work to end, its error ends all at once.
///
/// If `is_patient`, the first signal only asks the work to end and is raised when it has.
pub(crate) fn detached<Event: Send + 'static, T: Send + 'static>(
    py: Python<'_>,
    (threads, is_patient): (Option<usize>, bool),
    work: impl FnOnce(&Flag, &Teller<Event, T>) -> T + Send + 'static,
    mut hear: impl FnMut(Python<'_>, Event) -> PyResult<bool> + Send,
) -> PyResult<T> {
    let flag = Flag::default();
    let (tell, told) = channel();
    let (answer, answered) = channel();
    let teller = Teller { tell, answered };
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .build()
        .map_err(failed)?;
    let its_flag = flag.clone();
    let worker = move || {
        let all = move || {
            let done = work(&its_flag, &teller);
            let _ = teller.tell.send(Told::Done(done));
        };
        // A panic drops the teller, and the caller hears that nobody is left.
        let _ = catch_unwind(AssertUnwindSafe(|| pool.install(all)));
    };
    std::thread::Builder::new().spawn(worker).map_err(failed)?;
    let mut interrupted = None;
    py.detach(move || {
        loop {
            let heard = match told.recv_timeout(LOOK) {
                Ok(Told::Done(done)) => return interrupted.map_or(Ok(done), Err),
                Ok(Told::Event(event)) => Python::attach(|py| {
                    py.check_signals()?;
                    let goes_on = hear(py, event)?;
                    let _ = answer.send(goes_on && interrupted.is_none());
                    Ok(())
                }),
                Err(RecvTimeoutError::Timeout) => Python::attach(|py| py.check_signals()),
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(failed("the work failed; please report it"));
                }
            };
            if let Err(error) = heard {
                flag.store(true, Ordering::Relaxed);
                if !is_patient || interrupted.is_some() {
                    return Err(error);
                }
                interrupted = Some(error);
                let _ = answer.send(false);
            }
        }
    })
}
