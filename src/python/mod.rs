//! The Python module: the engine for notebooks, as numpy arrays.
//!
//! ```text
//! overlook.open(path), overlook.demo(name) ─▶ Capture ─ preprocess ─▶ Store ─ render ─▶ color, depth, coverage
//!                                              │ frame ─▶ Frame        │ samples ─▶ Samples
//! ```
//!
//! `python/overlook/__init__.pyi` documents every name with its types, shapes, units and frames. Numbers are those of the command
//! line: the same calls are made. Errors are `overlook.Error` with the line that the command line prints. The interpreter is let go
//! while something works, and Ctrl-C stops it (`work.rs`).

#![expect(clippy::needless_pass_by_value, reason = "Python's arguments arrive by value")]

mod arrays;
mod camera;
mod capture;
mod choices;
mod store;
mod work;

use pyo3::prelude::*;

pyo3::create_exception!(
    overlook,
    Error,
    pyo3::exceptions::PyException,
    "What is wrong, where, and what to do about it."
);

pub use camera::{PyCamera, PyLens};
pub use capture::{PyCapture, PyFrame, demo, evaluate, open};
pub use store::{PySamples, PyStore, open_store};

/// The exception that an error of the engine becomes.
fn to_exception(error: &crate::error::Error) -> PyErr {
    Error::new_err(error.to_string())
}
