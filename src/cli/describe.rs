//! `chebloyd schema`, `chebloyd completions` and `chebloyd man`: the program describes itself.

use clap::{Args, Command};
use clap_complete::Shell;
use clap_mangen::Man;

use crate::cli::failure::{Failure, print};
use crate::scene::description::Scene;
use crate::scene::field_file::FieldFile;

/// Print a completion script for a shell
#[derive(Debug, Args)]
pub(crate) struct CompletionsOptions {
    /// The shell to complete in
    shell: Shell,
}

/// Print the manual page, or that of one command
#[derive(Debug, Args)]
pub(crate) struct ManOptions {
    /// The command to describe
    command: Option<String>,
}

/// Print the JSON Schema of scenes, or of field files
#[derive(Debug, Args)]
pub(crate) struct SchemaOptions {
    /// That of field files, which `--density @field.json` reads
    #[arg(long)]
    field: bool,
}

pub(crate) fn schema(options: &SchemaOptions) -> Result<(), Failure> {
    let schema = if options.field {
        FieldFile::schema()
    } else {
        Scene::schema()
    };
    print(format!("{schema:#}\n"))
}

pub(crate) fn completions(
    options: &CompletionsOptions,
    mut program: Command,
) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(options.shell, &mut program, "chebloyd", &mut script);
    print(script)
}

pub(crate) fn man(options: &ManOptions, mut program: Command) -> Result<(), Failure> {
    program.build();
    let page = match &options.command {
        None => program,
        Some(name) => {
            let found = program.find_subcommand(name).cloned();
            found.ok_or_else(|| {
                Failure::input(format!(
                    "there is no command `{name}`; `chebloyd help` lists them"
                ))
            })?
        }
    };
    let mut text = Vec::new();
    Man::new(page).render(&mut text).map_err(Failure::run)?;
    print(text)
}
