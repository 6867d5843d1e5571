//! The shared library that `import overlook` loads. Everything in it is [`overlook::python`]; a package of its own spares the program
//! a shared library at every build.

/// The engine.
#[pyo3::pymodule]
mod _engine {
    #[pymodule_export]
    use overlook::python::{
        Error, PyCamera, PyCapture, PyFrame, PyLens, PySamples, PyStore, demo, evaluate, open, open_store,
    };

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
