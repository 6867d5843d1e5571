//! Flat Gaussians as numpy arrays.

use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;

use super::arrays;
use overlook_engine::splats::SplatArrays;

/// Splats, one row each.
#[pyclass(name = "Splats", module = "overlook", frozen, get_all)]
pub struct PySplats {
    center_in_world: Py<PyArray2<f64>>,
    rotation: Py<PyArray2<f32>>,
    scale: Py<PyArray2<f32>>,
    color: Py<PyArray2<f32>>,
    opacity: Py<PyArray1<f32>>,
}

impl PySplats {
    pub(super) fn of(py: Python<'_>, splats: SplatArrays) -> PyResult<Self> {
        let SplatArrays { center_in_world, rotation, scale, color, opacity } = splats;
        Ok(Self {
            center_in_world: arrays::rows(py, center_in_world)?.unbind(),
            rotation: arrays::rows(py, rotation)?.unbind(),
            scale: arrays::rows(py, scale)?.unbind(),
            color: arrays::rows(py, color)?.unbind(),
            opacity: opacity.into_pyarray(py).unbind(),
        })
    }
}

#[pymethods]
impl PySplats {
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.opacity.bind(py).len()
    }
}
