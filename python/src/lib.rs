//! The Python module: the engine for notebooks, as numpy arrays.
//!
//! ```text
//! overlook.open(path), overlook.demo(name) ─▶ Capture ─ preprocess ─▶ Store ─ render ─▶ color, depth, coverage
//!                                              │ frame ─▶ Frame        │ samples ─▶ Samples, splats ─▶ Splats, page ─▶ Page
//! ```
//!
//! `python/overlook/__init__.pyi` documents every name with its types, shapes, units and frames. Numbers are those of the command
//! line: the same calls are made. Errors are `overlook.Error` with the line that the command line prints. The interpreter is let go
//! while something works, and Ctrl-C stops it (`work.rs`).

#![warn(clippy::unwrap_used, clippy::expect_used)]
#![expect(clippy::needless_pass_by_value, reason = "Python's arguments arrive by value")]

mod arrays;
mod camera;
mod capture;
mod choices;
mod exceptions;
mod page;
mod placement;
mod splats;
mod store;
mod values;
mod work;

pub use camera::{PyCamera, PyLens};
pub use capture::{PyCapture, PyFrame, demo, evaluate, open};
pub use exceptions::Error;
pub use page::PyPage;
pub use placement::{PyPlacement, place};
pub use splats::PySplats;
pub use store::{PySamples, PyStore, open_store};
pub use values::PyValueChannel;

/// The module `overlook._engine`, which the package `overlook` re-exports.
#[pyo3::pymodule]
mod _engine {
    #[pymodule_export]
    use crate::{
        Error, PyCamera, PyCapture, PyFrame, PyLens, PyPage, PyPlacement, PySamples, PySplats, PyStore,
        PyValueChannel, demo, evaluate, open, open_store, place,
    };

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
