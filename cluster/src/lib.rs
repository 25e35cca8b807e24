//! The ranks of an MPI job, as [`chebloyd::Ranks`]: what a run needs of MPI, sent in words of 8 bytes.

use chebloyd::Ranks;
use mpi::collective::SystemOperation;
use mpi::datatype::{Partition, PartitionMut};
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives};

/// The ranks of a job. Asked by the thread that initialized MPI alone.
#[derive(Clone, Copy, Debug, Default)]
pub struct World;

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
