//! `chebloyd-mpi`: the library's run over ranks, its messages sent by MPI.

use std::panic;
use std::process::ExitCode;

use chebloyd::Ranks;
use mpi::Threading;
use mpi::collective::SystemOperation;
use mpi::datatype::{Partition, PartitionMut};
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives};

/// What `MPI_Abort` hands to the launcher where a rank panics.
const PANICKED: i32 = 101;

/// The ranks of a job. Asked by the thread that initialized MPI alone.
struct World;

/// The communicator of all ranks.
fn world() -> SimpleCommunicator {
    SimpleCommunicator::world()
}

impl Ranks for World {
    fn rank(&self) -> usize {
        world().rank() as usize
    }

    fn size(&self) -> usize {
        world().size() as usize
    }

    fn exchange(&self, parts: Vec<Vec<u64>>) -> Vec<Vec<u64>> {
        let counts: Vec<i32> = parts.iter().map(|part| count(part.len())).collect();
        let mut incoming = vec![0_i32; counts.len()];
        world().all_to_all_into(&counts[..], &mut incoming[..]);
        let (from, to) = (starts(&counts), starts(&incoming));
        let sent = parts.concat();
        let total: usize = incoming.iter().map(|&count| count as usize).sum();
        let mut came = vec![0_u64; total];
        let sent = Partition::new(&sent[..], &counts[..], &from[..]);
        let mut place = PartitionMut::new(&mut came[..], &incoming[..], &to[..]);
        world().all_to_all_varcount_into(&sent, &mut place);
        split(&came, &incoming)
    }

    fn share(&self, words: Vec<u64>) -> Vec<Vec<u64>> {
        let mut counts = vec![0_i32; self.size()];
        world().all_gather_into(&count(words.len()), &mut counts[..]);
        let to = starts(&counts);
        let total: usize = counts.iter().map(|&count| count as usize).sum();
        let mut came = vec![0_u64; total];
        let mut place = PartitionMut::new(&mut came[..], &counts[..], &to[..]);
        world().all_gather_varcount_into(&words[..], &mut place);
        split(&came, &counts)
    }

    fn add(&self, numbers: &mut [i64]) {
        let own = numbers.to_vec();
        world().all_reduce_into(&own[..], numbers, SystemOperation::sum());
    }

    fn largest(&self, numbers: &mut [f64]) {
        let own = numbers.to_vec();
        world().all_reduce_into(&own[..], numbers, SystemOperation::max());
    }
}

/// Parts of so many words each.
fn split(words: &[u64], counts: &[i32]) -> Vec<Vec<u64>> {
    let mut rest = words;
    let take = |&count: &i32| {
        let (part, others) = rest.split_at(count as usize);
        rest = others;
        part.to_vec()
    };
    counts.iter().map(take).collect()
}

/// A count as MPI takes it: at most 2³¹ − 1 numbers of 8 bytes to a rank.
fn count(length: usize) -> i32 {
    i32::try_from(length).expect("one message holds at most 16 GB; use more ranks")
}

/// Where each part begins.
fn starts(counts: &[i32]) -> Vec<i32> {
    let all = counts.iter().scan(0_i32, |end, count| {
        let start = *end;
        *end = end
            .checked_add(*count)
            .expect("one rank's messages hold at most 16 GB; use more ranks");
        Some(start)
    });
    all.collect()
}

fn main() -> ExitCode {
    let Some((universe, _)) = mpi::initialize_with_threading(Threading::Funneled) else {
        eprintln!("error: MPI is initialized already");
        return ExitCode::FAILURE;
    };
    let world = universe.world();
    let machine = world.split_shared(world.rank());
    let neighbors = machine.size() as usize;
    let ran = panic::catch_unwind(panic::AssertUnwindSafe(|| {
        chebloyd::command_line_over(std::env::args_os(), &World, neighbors)
    }));
    match ran {
        Ok(code) => ExitCode::from(code),
        // The others would wait for this one.
        Err(_) => universe.world().abort(PANICKED),
    }
}
