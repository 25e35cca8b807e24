//! Stops a run after ten moves, keeps its checkpoint in memory, and goes on in a pool of one's own.
//!
//!     cargo run --release --example checkpoint

use std::ops::ControlFlow;

use chebloyd::{Checkpoint, Cuboid, Method, Relaxation, random_sites};
use rayon::ThreadPoolBuilder;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sites = random_sites(&Cuboid::unit(), 500, 7)?;
    let relaxation = Relaxation::new(Cuboid::unit()).method(Method::quasi_newton(40));
    let mut checkpoint = Checkpoint::at_start(sites);
    relaxation.resume(&mut checkpoint, |record, _| {
        if record.iteration < 10 {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        }
    })?;

    // As plain numbers it can be kept anywhere; the run then goes on to the same bits.
    let numbers = checkpoint.state_numbers();
    let record = checkpoint.record.ok_or("no record")?;
    let mut kept = Checkpoint::from_parts(checkpoint.sites, record, &numbers)?;
    let pool = ThreadPoolBuilder::new().num_threads(1).build()?;
    let ended = pool.install(|| relaxation.resume(&mut kept, |_, _| ControlFlow::Continue(())))?;
    let last = kept.record.ok_or("no record")?;
    println!(
        "{ended:?} after {} moves at {:.4} %",
        last.iteration, last.energy_percent
    );
    Ok(())
}
