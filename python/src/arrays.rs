//! From the engine's grids to numpy arrays, rows first.

use half::f16;
use numpy::ndarray::{Array2, Array3};
use numpy::{IntoPyArray, PyArray2, PyArray3};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use overlook_engine::grid::Grid;

/// Planar depth from its reciprocal: infinite at the sky, NaN without depth.
pub(super) fn depth_of(inverse_depth: f32) -> f32 {
    if inverse_depth < 0.0 { f32::NAN } else { 1.0 / inverse_depth }
}

/// Rows × columns × 3.
pub(super) fn colors<'py>(py: Python<'py>, grid: &Grid<[f16; 3]>) -> PyResult<Bound<'py, PyArray3<f32>>> {
    channels(py, grid.size(), grid.as_slice().iter().map(|color| color.map(f16::to_f32)))
}

/// Rows × columns × 3.
pub(super) fn vectors<'py>(py: Python<'py>, grid: &Grid<[f32; 3]>) -> PyResult<Bound<'py, PyArray3<f32>>> {
    channels(py, grid.size(), grid.as_slice().iter().copied())
}

fn channels(
    py: Python<'_>,
    (width, height): (usize, usize),
    values: impl Iterator<Item = [f32; 3]>,
) -> PyResult<Bound<'_, PyArray3<f32>>> {
    let array = Array3::from_shape_vec((height, width, 3), values.flatten().collect());
    Ok(array.map_err(shape_error)?.into_pyarray(py))
}

/// Rows × columns.
pub(super) fn plane<'py, T, U: numpy::Element>(
    py: Python<'py>,
    grid: &Grid<T>,
    value: impl Fn(&T) -> U,
) -> PyResult<Bound<'py, PyArray2<U>>> {
    let (width, height) = grid.size();
    let values = grid.as_slice().iter().map(value).collect();
    Ok(Array2::from_shape_vec((height, width), values).map_err(shape_error)?.into_pyarray(py))
}

/// One row for each of `values`.
pub(super) fn rows<T: numpy::Element, const N: usize>(
    py: Python<'_>,
    values: Vec<[T; N]>,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    let shape = (values.len(), N);
    let array = Array2::from_shape_vec(shape, values.into_iter().flatten().collect());
    Ok(array.map_err(shape_error)?.into_pyarray(py))
}

fn shape_error(error: numpy::ndarray::ShapeError) -> PyErr {
    PyRuntimeError::new_err(error.to_string())
}
