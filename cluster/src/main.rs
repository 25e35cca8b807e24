//! `chebloyd-mpi`: the library's run over ranks, its messages sent by MPI.

use std::panic;
use std::process::ExitCode;

use chebloyd_mpi::World;
use mpi::Threading;
use mpi::traits::Communicator;

/// What `MPI_Abort` hands to the launcher where a rank panics.
const PANICKED: i32 = 101;

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
