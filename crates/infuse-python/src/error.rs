//! The exception: with the words of the Rust errors.

use std::fmt::Display;

use pyo3::PyErr;

pyo3::create_exception!(
    infuse,
    Error,
    pyo3::exceptions::PyValueError,
    "What was asked for is wrong; the message names the field, the value and what is allowed."
);

/// An error of a Rust library as the exception, in the same words.
pub(crate) fn refusal(error: impl Display) -> PyErr {
    Error::new_err(error.to_string())
}
