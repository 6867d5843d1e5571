//! A page that plays a scene, shown by a notebook.

use std::path::PathBuf;

use pyo3::prelude::*;

use super::exceptions::to_exception;
use overlook_engine::page::{PageText, escaped};
use overlook_engine::plural::counted;
use overlook_engine::whole_file;

/// A page as text.
#[pyclass(name = "Page", module = "overlook", frozen)]
pub struct PyPage {
    title: String,
    page: PageText,
    /// Samples of the store.
    of_store: u64,
    /// Rows of the frame in a notebook, CSS pixels.
    height: u32,
}

impl PyPage {
    pub(super) fn new(title: String, page: PageText, of_store: u64, height: u32) -> Self {
        Self { title, page, of_store, height }
    }

    /// What it is, in one sentence.
    fn sentence(&self) -> String {
        let megabytes = self.page.html.len() as f64 / 1e6;
        let samples = counted(self.page.samples as usize, "sample");
        let merged = if self.page.samples < self.of_store {
            format!(", merged from {}", self.of_store)
        } else {
            String::new()
        };
        format!(
            "'{}' as a page of {megabytes:.1} MB: {samples}{merged}. Drag to turn it, scroll to come closer.",
            self.title
        )
    }
}

#[pymethods]
impl PyPage {
    #[getter]
    fn html(&self) -> &str {
        &self.page.html
    }

    /// Writes it to a file.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        whole_file::write_all(&path, &self.page.html).map_err(|error| to_exception(&error))
    }

    fn _repr_html_(&self) -> String {
        let (sentence, height) = (escaped(&self.sentence()), self.height);
        let (title, page) = (escaped(&self.title), escaped(&self.page.html));
        format!(
            "<p>{sentence}</p><iframe title=\"{title}\" srcdoc=\"{page}\" width=\"100%\" height=\"{height}\" \
             style=\"border: 0\" allow=\"fullscreen\"></iframe>"
        )
    }

    fn __repr__(&self) -> String {
        format!("<overlook.Page: {}>", self.sentence())
    }
}
