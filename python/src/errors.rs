//! Python's exceptions for the program's sentences.

use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;

/// `OSError` with its number where the system refused something, else `ValueError`; with the sentence as it
/// is.
pub(crate) fn refused(error: impl std::fmt::Display) -> PyErr {
    let message = error.to_string();
    match system_error(&message) {
        Some(number) => PyOSError::new_err((number, message)),
        None => PyValueError::new_err(message),
    }
}

/// For what cannot be the caller's fault.
pub(crate) fn failed(error: impl std::fmt::Display) -> PyErr {
    PyRuntimeError::new_err(error.to_string())
}

/// The number in `std::io::Error`'s "… (os error 2)".
fn system_error(message: &str) -> Option<i32> {
    let (_, rest) = message.rsplit_once("(os error ")?;
    rest.split_once(')')?.0.parse().ok()
}
