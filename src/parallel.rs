//! Loops over numbers on all threads.
//!
//! A parallel iterator is compiled anew for every closure: hundreds of them took a sixth of the time of building
//! this library. Here threads share numbers only, once for all loops, and what is generic is a plain loop inside.

use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

/// Numbers of a task that takes little for each.
pub(crate) const RUN: usize = 4096;

/// Calls `task` with every number below `count`.
pub(crate) fn for_each(count: usize, task: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().for_each(task);
}

/// What `one` gives for every number below `count`, in their order.
pub(crate) fn map<T: Send>(count: usize, one: &(dyn Fn(usize) -> T + Sync)) -> Vec<T> {
    let mut results = Vec::new();
    let numbers = (0..count).into_par_iter();
    numbers.map(one).collect_into_vec(&mut results);
    results
}

/// What `of_run` gives for runs of `length` numbers that follow each other below `count`, the last one shorter.
pub(crate) fn map_runs<T: Send>(
    count: usize,
    length: usize,
    of_run: impl Fn(Range<usize>) -> T + Sync,
) -> Vec<T> {
    let slots = (0..count.div_ceil(length)).map(|_| Mutex::new(None));
    let slots: Vec<Mutex<Option<T>>> = slots.collect();
    for_each(slots.len(), &|run| {
        let result = of_run(run * length..count.min((run + 1) * length));
        *slots[run].lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
    });
    let slots = slots.into_iter().map(Mutex::into_inner);
    let results = slots.filter_map(|slot| slot.unwrap_or_else(PoisonError::into_inner));
    results.collect()
}

/// What `one` gives for every part, which it may change, in their order.
pub(crate) fn map_parts<P: Send, T: Send>(
    parts: Vec<P>,
    one: &(dyn Fn(&mut P) -> T + Sync),
) -> Vec<T> {
    let parts: Vec<Mutex<P>> = parts.into_iter().map(Mutex::new).collect();
    map(parts.len(), &|part| {
        one(&mut parts[part].lock().unwrap_or_else(PoisonError::into_inner))
    })
}

/// Memory larger than this is given back by a thread of the pool (bytes).
const DISCARDED_BEHIND: usize = 1 << 18;

/// Frees memory. The system takes tenths of a second for gigabytes, and the caller goes on meanwhile, where there is
/// another thread for it: the only thread of a pool would come to it after all other work.
pub(crate) fn discard<T: Send + 'static>(memory: Vec<T>) {
    let is_large = memory.capacity() * size_of::<T>() > DISCARDED_BEHIND;
    if is_large && rayon::current_num_threads() > 1 {
        rayon::spawn(move || drop(memory));
    }
}

/// Memory that is made once for every thread and handed from task to task.
#[derive(Debug, Default)]
pub(crate) struct Memories<M>(Mutex<Vec<M>>);

impl<M: Default> Memories<M> {
    /// Lets `work` use one that nobody else uses.
    pub(crate) fn lend<T>(&self, work: impl FnOnce(&mut M) -> T) -> T {
        let mut memory = self.free(Vec::pop).unwrap_or_default();
        let result = work(&mut memory);
        self.free(|free| free.push(memory));
        result
    }

    fn free<T>(&self, change: impl FnOnce(&mut Vec<M>) -> T) -> T {
        change(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_has_its_result_in_order() {
        for count in [0, 1, 63, 64, 65, 1000] {
            let numbers: Vec<usize> = (0..count).collect();
            assert_eq!(map(count, &|number| number), numbers);
            let runs = map_runs(count, 64, |run| run);
            assert_eq!(runs.len(), count.div_ceil(64));
            assert!(runs.iter().all(|run| run.len() <= 64));
            assert_eq!(runs.into_iter().flatten().collect::<Vec<_>>(), numbers);
        }
    }

    #[test]
    fn one_thread_frees_memory_at_once() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1);
        let kept = std::sync::Arc::new(());
        pool.build().unwrap().install(|| {
            discard(vec![std::sync::Arc::clone(&kept); DISCARDED_BEHIND]);
            assert_eq!(std::sync::Arc::strong_count(&kept), 1);
        });
    }

    #[test]
    fn memory_is_used_again() {
        let memories = Memories::<Vec<usize>>::default();
        memories.lend(|memory| memory.push(1));
        memories.lend(|memory| {
            memory.push(2);
            memories.lend(|other| assert!(other.is_empty()));
            assert_eq!(*memory, [1, 2]);
        });
    }
}
