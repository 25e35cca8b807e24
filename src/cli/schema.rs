//! `chebloyd schema`.

use chebloyd::scene::schema::schema;

use crate::cli::failure::Failure;
use crate::cli::stdout;

pub(crate) fn run() -> Result<(), Failure> {
    stdout::print(format!("{:#}\n", schema()))
}
