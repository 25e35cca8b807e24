//! The program `chebloyd`: the library's command line.

use std::process::ExitCode;

fn main() -> ExitCode {
    chebloyd::command_line()
}
