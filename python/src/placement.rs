//! Where to put cameras, told from a coarse capture.

use std::path::PathBuf;

use glam::DVec3;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::camera::PyCamera;
use super::capture::PyCapture;
use super::choices::settings_over;
use super::exceptions::to_exception;
use super::{arrays, work};
use overlook_engine::capture::transforms::write_cameras;
use overlook_engine::placement::{self, PlaceOptions, Placement, Stand};
use overlook_engine::settings::{AlignSettings, Settings};

/// A box as its lowest and its highest coordinates.
type Corners = ([f64; 3], [f64; 3]);

/// The poses that together show most of what a coarse capture saw.
///
/// # Errors
/// `Error` as [`placement::place`]; `ValueError` for both a ring and a box; `KeyboardInterrupt`, and what `progress` raises.
#[pyfunction]
#[pyo3(signature = (capture, cameras=6, *, ring=false, within=None, size=None, rate=None, settings=None, progress=None))]
#[expect(clippy::too_many_arguments, reason = "Python's arguments have names")]
pub fn place(
    py: Python<'_>,
    capture: &PyCapture,
    cameras: usize,
    ring: bool,
    within: Option<Corners>,
    size: Option<(u32, u32)>,
    rate: Option<f64>,
    settings: Option<&Bound<'_, PyDict>>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<PyPlacement> {
    let stand = match within {
        Some(_) if ring => return Err(PyValueError::new_err("ring and within: give one of them")),
        Some((low, high)) => Stand::Within([DVec3::from(low), DVec3::from(high)]),
        None if ring => Stand::Ring,
        None => Stand::Between,
    };
    // Poses of renderers are exact.
    let base = Settings { align: AlignSettings::OFF, ..Settings::default() };
    let settings = settings_over(base, settings)?;
    let options = PlaceOptions { cameras, stand, size, rate };
    let placed = work::run(py, progress, |job| placement::place(&capture.capture, &options, &settings, job))?;
    Ok(PyPlacement(placed))
}

/// Placed cameras.
#[pyclass(name = "Placement", module = "overlook", frozen)]
pub struct PyPlacement(Placement);

#[pymethods]
impl PyPlacement {
    #[getter]
    fn cameras(&self) -> Vec<PyCamera> {
        self.0.cameras.iter().map(|placed| PyCamera(placed.camera.clone())).collect()
    }

    #[getter]
    fn adds<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let adds: Vec<f64> = self.0.cameras.iter().map(|placed| placed.adds).collect();
        adds.into_pyarray(py)
    }

    #[getter]
    fn seen(&self) -> f64 {
        self.0.cameras.last().map_or(0.0, |placed| placed.seen)
    }

    #[getter]
    fn coarse_cameras_see(&self) -> f64 {
        self.0.coarse_cameras_see
    }

    #[getter]
    fn unseen(&self) -> f64 {
        self.0.unseen
    }

    #[getter]
    fn unseen_points_in_world<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let points = self.0.unseen_surfels.iter().map(|surfel| surfel.point_in_world.to_array());
        arrays::rows(py, points.collect())
    }

    /// Writes the poses as a manifest.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        let Placement { cameras, frame_number, up_in_world, .. } = &self.0;
        let cameras: Vec<_> = cameras.iter().map(|placed| placed.camera.clone()).collect();
        write_cameras(&path, &cameras, *frame_number, *up_in_world).map_err(|error| to_exception(&error))
    }

    fn __repr__(&self) -> String {
        let (cameras, seen) = (self.0.cameras.len(), 100.0 * self.seen());
        format!("<overlook.Placement of {cameras}, which see {seen:.1} %>")
    }
}
