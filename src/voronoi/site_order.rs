//! Permutations of results into the order of their sites, in place.
//!
//! Results come in the order of the index, which is scattered among the sites: to swap them one by one waits for
//! memory each time, in one thread. So they are first dealt to runs of sites, which reads and writes every run from
//! its beginning on (McIlroy, Bostic & McIlroy, *Engineering Radix Sort*, 1993: American flag sort), then all runs
//! are put in order at once.

use rayon::prelude::*;

/// So many runs at most: each has a place in the cache that is written next.
const MOST_RUNS: usize = 1 << 9;

/// The shortest run.
const LEAST_RUN: usize = 1 << 10;

/// Brings every result to the index that `goals`, a permutation, gives; `None` if `is_stopped` says so before.
pub(crate) fn bring_into_order<T: Send>(
    results: &mut [T],
    mut goals: Vec<u32>,
    is_stopped: &dyn Fn() -> bool,
) -> Option<()> {
    let run = results.len().div_ceil(MOST_RUNS).max(LEAST_RUN);
    let mut next: Vec<usize> = (0..results.len()).step_by(run).collect();
    for number in 0..next.len() {
        if is_stopped() {
            return None;
        }
        deal_run(results, &mut goals, &mut next, (number, run));
    }
    let runs = results.par_chunks_mut(run).zip(goals.par_chunks_mut(run));
    let runs = runs.enumerate();
    runs.for_each(|(number, (results, goals))| order_run(results, goals, number * run));
    Some(())
}

/// Fills run `number` with its own results; `next` is where each run's next one comes.
fn deal_run<T>(
    results: &mut [T],
    goals: &mut [u32],
    next: &mut [usize],
    (number, run): (usize, usize),
) {
    let end = results.len().min((number + 1) * run);
    while next[number] < end {
        let place = next[number];
        let goal = goals[place] as usize / run;
        if goal != number {
            results.swap(place, next[goal]);
            goals.swap(place, next[goal]);
        }
        next[goal] += 1;
    }
}

/// Permutes the results of sites that follow each other from `first` on to where `goals` says.
fn order_run<T>(results: &mut [T], goals: &mut [u32], first: usize) {
    for place in 0..results.len() {
        while goals[place] as usize - first != place {
            let goal = goals[place] as usize - first;
            results.swap(place, goal);
            goals.swap(place, goal);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_result_comes_to_its_goal() {
        // Around the lengths of one run and of the most runs.
        for count in [0, 1, 2, 1023, 1024, 1025, 5000, 600_000] {
            // The multiples of a number without a divisor in common with the count.
            let step = (1..)
                .map(|k| 7919 + k)
                .find(|&step| gcd(step, count.max(1)) == 1);
            let step = step.expect("there are primes");
            for shift in [0, 1, count / 2] {
                let goal = |place: usize| (place * step + shift) % count;
                let goals: Vec<u32> = (0..count).map(|place| goal(place) as u32).collect();
                let mut results: Vec<String> = Vec::new();
                let mut numbers = goals.clone();
                if count <= 5000 {
                    results.extend(goals.iter().map(u32::to_string));
                    bring_into_order(&mut results, goals.clone(), &|| false).expect("not stopped");
                    assert!((0..count).all(|place| results[place] == place.to_string()));
                }
                bring_into_order(&mut numbers, goals, &|| false).expect("not stopped");
                assert!(
                    (0..count).all(|place| numbers[place] as usize == place),
                    "{count}"
                );
            }
        }
        assert!(bring_into_order(&mut [1, 0], vec![1, 0], &|| true).is_none());
    }

    fn gcd(a: usize, b: usize) -> usize {
        if b == 0 { a } else { gcd(b, a % b) }
    }
}
