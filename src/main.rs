//! The `chebloyd` program: parse, run, print the error once, exit code.

mod cli;

use std::process::ExitCode;

use clap::Parser;

use crate::cli::arguments::Arguments;
use crate::cli::processor;

fn main() -> ExitCode {
    let ran = processor::check().and_then(|()| cli::command::run(&Arguments::parse()));
    match ran {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // Where stderr is closed there is nobody to tell.
            let _ = std::io::Write::write_fmt(
                &mut std::io::stderr(),
                format_args!("error: {failure}\n"),
            );
            failure.exit_code()
        }
    }
}
