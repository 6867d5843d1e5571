//! The engine's errors as a Python exception.

use pyo3::prelude::*;

pyo3::create_exception!(
    overlook,
    Error,
    pyo3::exceptions::PyException,
    "What is wrong, where, and what to do about it."
);

/// The exception that an error of the engine becomes.
pub(super) fn to_exception(error: &overlook_engine::error::Error) -> PyErr {
    Error::new_err(error.to_string())
}
