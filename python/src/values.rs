//! Scalar values: what their channels mean, and their arrays by name.

use numpy::ndarray::{Array1, Array2};
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use overlook_engine::capture::{ValueChannel, Values};

/// What the numbers of a channel mean.
#[pyclass(name = "ValueChannel", module = "overlook", frozen)]
pub struct PyValueChannel(ValueChannel);

#[pymethods]
impl PyValueChannel {
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    #[getter]
    fn unit(&self) -> &str {
        &self.0.unit
    }

    #[getter]
    fn range(&self) -> (f32, f32) {
        (self.0.range[0], self.0.range[1])
    }

    #[getter]
    fn tolerance(&self) -> f32 {
        self.0.tolerance
    }

    fn __repr__(&self) -> String {
        let ValueChannel { name, unit, range: [low, high], .. } = &self.0;
        format!("<overlook.ValueChannel '{name}', {low} to {high} {unit}>")
    }
}

/// The channels, in their order.
pub(super) fn channels(channels: &[ValueChannel]) -> Vec<PyValueChannel> {
    channels.iter().cloned().map(PyValueChannel).collect()
}

/// Rows × columns of each channel, by its name.
pub(super) fn planes<'py>(
    py: Python<'py>,
    channels: &[ValueChannel],
    values: &Values,
    (width, height): (usize, usize),
) -> PyResult<Bound<'py, PyDict>> {
    let planes = PyDict::new(py);
    for (index, channel) in channels.iter().enumerate() {
        let plane = Array2::from_shape_vec((height, width), values.channel(index).collect());
        let plane = plane.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
        let plane: Bound<'py, PyArray2<f32>> = plane.into_pyarray(py);
        planes.set_item(&channel.name, plane)?;
    }
    Ok(planes)
}

/// One row for each sample of each channel, by its name.
pub(super) fn columns<'py>(
    py: Python<'py>,
    channels: &[ValueChannel],
    columns: Vec<Vec<f32>>,
) -> PyResult<Bound<'py, PyDict>> {
    let by_name = PyDict::new(py);
    for (channel, column) in channels.iter().zip(columns) {
        let column: Bound<'py, PyArray1<f32>> = Array1::from_vec(column).into_pyarray(py);
        by_name.set_item(&channel.name, column)?;
    }
    Ok(by_name)
}
