//! Cameras: a lens and a pose.

use glam::{DAffine3, DMat3, DVec3};
use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use super::arrays;
use overlook_engine::capture::{Camera, Intrinsics, Projection};

/// How far a matrix of a pose may be from a rotation.
const ROTATION_TOLERANCE: f64 = 1e-4;

/// Size and projection of a camera, in pixels.
#[pyclass(name = "Lens", module = "overlook", frozen, get_all, from_py_object)]
#[derive(Clone, Copy)]
pub struct PyLens {
    width: u32,
    height: u32,
    fx: f64,
    fy: f64,
    cx: f64,
    cy: f64,
    orthographic: bool,
}

#[pymethods]
impl PyLens {
    #[new]
    #[pyo3(signature = (width, height, fx, fy=None, cx=None, cy=None, orthographic=false))]
    fn new(
        width: u32,
        height: u32,
        fx: f64,
        fy: Option<f64>,
        cx: Option<f64>,
        cy: Option<f64>,
        orthographic: bool,
    ) -> Self {
        let center = |given: Option<f64>, size: u32| given.unwrap_or(f64::from(size) / 2.0);
        let (cx, cy) = (center(cx, width), center(cy, height));
        Self { width, height, fx, fy: fy.unwrap_or(fx), cx, cy, orthographic }
    }

    fn __repr__(&self) -> String {
        let Self { width, height, fx, fy, cx, cy, orthographic } = self;
        let parallel = if *orthographic { ", orthographic=True" } else { "" };
        format!("Lens(width={width}, height={height}, fx={fx}, fy={fy}, cx={cx}, cy={cy}{parallel})")
    }
}

impl PyLens {
    pub(super) fn intrinsics(self) -> Intrinsics {
        let Self { width, height, fx, fy, cx, cy, orthographic } = self;
        let projection = if orthographic { Projection::Orthographic } else { Projection::Perspective };
        Intrinsics { width, height, fx, fy, cx, cy, projection }
    }
}

/// A camera of a capture.
#[pyclass(name = "Camera", module = "overlook", frozen)]
pub struct PyCamera(pub(super) Camera);

#[pymethods]
impl PyCamera {
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    #[getter]
    fn lens(&self) -> PyLens {
        let Intrinsics { width, height, fx, fy, cx, cy, projection } = self.0.intrinsics;
        PyLens { width, height, fx, fy, cx, cy, orthographic: projection == Projection::Orthographic }
    }

    #[getter]
    fn pose<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let DAffine3 { matrix3: axes, translation } = self.0.world_from_camera;
        let row = |at: usize| [axes.x_axis[at], axes.y_axis[at], axes.z_axis[at], translation[at]];
        arrays::rows(py, vec![row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]])
    }

    fn __repr__(&self) -> String {
        let Intrinsics { width, height, .. } = self.0.intrinsics;
        format!("<overlook.Camera '{}', {width}×{height}>", self.0.name)
    }
}

/// The pose in a matrix of 4×4 or 3×4 numbers, world from camera.
///
/// # Errors
/// `ValueError` where the matrix has another shape, or is no rigid pose.
pub(super) fn pose_of(matrix: &PyReadonlyArray2<'_, f64>) -> PyResult<DAffine3> {
    let rows = matrix.as_array();
    let refuse = |what: &str| Err(PyValueError::new_err(format!("pose: {what}")));
    if !matches!(rows.dim(), (3 | 4, 4)) {
        return refuse("is not a 4×4 or 3×4 matrix; give world_from_camera");
    }
    let column = |at: usize| DVec3::new(rows[[0, at]], rows[[1, at]], rows[[2, at]]);
    let axes = DMat3::from_cols(column(0), column(1), column(2));
    let off = axes.transpose() * axes - DMat3::IDENTITY;
    let is_rotation = off.to_cols_array().iter().all(|entry| entry.abs() <= ROTATION_TOLERANCE);
    if !is_rotation || axes.determinant() < 0.0 {
        return refuse(
            "its axes are not at right angles, of length 1 and right-handed; give a rotation and a translation",
        );
    }
    Ok(DAffine3 { matrix3: axes, translation: column(3) })
}
