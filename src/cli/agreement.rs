//! Agreement of all ranks of a run: a failure on one is a failure on all, told once.

use crate::cli::failure::Failure;
use crate::relax::ranks::{Ranks, agreed};

/// The exit code of bad input.
const BAD_INPUT: f64 = 2.0;

/// What every rank has, or on all the failure of the first that has none.
pub(crate) fn together<T>(ranks: &dyn Ranks, own: Result<T, Failure>) -> Result<T, Failure> {
    let code = own.as_ref().map_or_else(Failure::code, |_| 0);
    let mut code = [f64::from(code)];
    ranks.largest(&mut code);
    let agreed = agreed(ranks, own.map_err(|failure| failure.to_string()));
    agreed.map_err(|message| match code[0] >= BAD_INPUT {
        true => Failure::input(message),
        false => Failure::run(message),
    })
}
