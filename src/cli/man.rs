//! `chebloyd man`.

use clap::{Args, CommandFactory};
use clap_mangen::Man;

use crate::cli::arguments::Arguments;
use crate::cli::failure::Failure;
use crate::cli::stdout;

/// Print the manual page, or that of one command
#[derive(Debug, Args)]
pub(crate) struct Options {
    /// The command to describe
    command: Option<String>,
}

pub(crate) fn run(options: &Options) -> Result<(), Failure> {
    let mut command = Arguments::command();
    command.build();
    let page = match &options.command {
        None => command,
        Some(name) => {
            let found = command.find_subcommand(name).cloned();
            found.ok_or_else(|| {
                Failure::input(format!(
                    "there is no command `{name}`; `chebloyd help` lists them"
                ))
            })?
        }
    };
    let mut text = Vec::new();
    Man::new(page).render(&mut text).map_err(Failure::run)?;
    stdout::print(text)
}
