//! Captures: opened from any folder or traced from a built-in scene.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::{PyArray2, PyArray3};
use pyo3::exceptions::{PyIndexError, PyKeyError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyModule};

use super::camera::PyCamera;
use super::choices::{edit_list, settings_over};
use super::exceptions::to_exception;
use super::store::PyStore;
use super::values::{self, PyValueChannel};
use super::{arrays, work};
use overlook_engine::capture::{self, Capture, Frame, TruthView, ValueChannel, transforms};
use overlook_engine::demo::{Demo, DemoSpec};
use overlook_engine::error::Error;
use overlook_engine::plural::counted;
use overlook_engine::preprocess::preprocess_edited;
use overlook_engine::settings::Settings;
use overlook_lab::{compare, truth};

/// Opens a capture, whatever wrote it.
///
/// # Errors
/// `Error` as [`capture::open`], and for settings that are unknown or out of range.
#[pyfunction]
#[pyo3(signature = (path, settings=None))]
pub fn open(py: Python<'_>, path: PathBuf, settings: Option<&Bound<'_, PyDict>>) -> PyResult<PyCapture> {
    let settings = settings_over(Settings::default(), settings)?;
    let capture = work::run(py, None, |_| capture::open(&path, &settings.capture))?;
    Ok(PyCapture { capture, views: TruthSource::Beside(path) })
}

/// A built-in scene, traced on demand.
///
/// # Errors
/// `Error` as [`Demo::new`].
#[pyfunction]
#[pyo3(signature = (name, *, cameras=None, frames=None, size=None))]
pub fn demo(
    name: &str,
    cameras: Option<usize>,
    frames: Option<usize>,
    size: Option<(u32, u32)>,
) -> PyResult<PyCapture> {
    let spec = DemoSpec { cameras, frames, size, ..DemoSpec::new(name) };
    let demo = Demo::new(&spec).map_err(|error| to_exception(&error))?;
    let capture = demo.capture(&Settings::default().capture);
    Ok(PyCapture { capture, views: TruthSource::Traced(Arc::new(demo)) })
}

/// Where the truth of new viewpoints comes from.
enum TruthSource {
    /// The folder `novel` of the capture at this path.
    Beside(PathBuf),
    /// The scene.
    Traced(Arc<Demo>),
}

/// What was recorded.
#[pyclass(name = "Capture", module = "overlook", frozen)]
pub struct PyCapture {
    pub(super) capture: Capture,
    views: TruthSource,
}

#[pymethods]
impl PyCapture {
    #[getter]
    fn name(&self) -> &str {
        &self.capture.name
    }

    #[getter]
    fn cameras(&self) -> Vec<PyCamera> {
        self.capture.cameras.iter().cloned().map(PyCamera).collect()
    }

    #[getter]
    fn frame_numbers(&self) -> Vec<i64> {
        self.capture.frame_numbers.clone()
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.capture.warnings.clone()
    }

    /// The channels of scalar values.
    #[getter]
    fn values(&self) -> Vec<PyValueChannel> {
        values::channels(self.capture.value_channels())
    }

    /// One frame of one camera, by name or index.
    #[pyo3(signature = (camera, frame=0))]
    fn frame(&self, py: Python<'_>, camera: &Bound<'_, PyAny>, frame: usize) -> PyResult<PyFrame> {
        let camera = self.camera_index(camera)?;
        let frames = self.capture.frame_count();
        if frame >= frames {
            return Err(PyIndexError::new_err(format!(
                "frame {frame}: '{}' has {frames}",
                self.capture.name
            )));
        }
        let channels = self.capture.value_channels().to_vec();
        Ok(PyFrame(work::run(py, None, |_| self.capture.frame(camera, frame))?, channels))
    }

    /// The whole method: scan over time, split into spans, prune between cameras.
    #[pyo3(signature = (settings=None, progress=None, *, edits=None))]
    fn preprocess(
        &self,
        py: Python<'_>,
        settings: Option<&Bound<'_, PyDict>>,
        progress: Option<&Bound<'_, PyAny>>,
        edits: Option<PathBuf>,
    ) -> PyResult<PyStore> {
        let settings = settings_over(Settings::default(), settings)?;
        let done = work::run(py, progress, |job| {
            preprocess_edited(&self.capture, &settings, &edit_list(edits)?, job)?.into_memory()
        })?;
        PyStore::of(done)
    }

    fn __repr__(&self) -> String {
        let (cameras, frames) = (self.capture.cameras.len(), self.capture.frame_count());
        let (cameras, frames) = (counted(cameras, "camera"), counted(frames, "frame"));
        format!("<overlook.Capture '{}', {cameras}, {frames}>", self.capture.name)
    }
}

impl PyCapture {
    fn camera_index(&self, camera: &Bound<'_, PyAny>) -> PyResult<usize> {
        let cameras = &self.capture.cameras;
        if let Ok(index) = camera.extract::<usize>() {
            let what = || format!("camera {index}: '{}' has {}", self.capture.name, cameras.len());
            return (index < cameras.len()).then_some(index).ok_or_else(|| PyIndexError::new_err(what()));
        }
        let name: String =
            camera.extract().map_err(|_| PyTypeError::new_err("camera: give its name or its index"))?;
        let what = || format!("camera '{name}': '{}' has no such camera", self.capture.name);
        cameras.iter().position(|camera| camera.name == name).ok_or_else(|| PyKeyError::new_err(what()))
    }

    /// The views whose truth is known.
    fn truth_views(&self, views: Option<PathBuf>) -> overlook_engine::error::Result<Vec<TruthView>> {
        let beside = match (&views, &self.views) {
            (Some(path), _) => Some(path.clone()),
            (None, TruthSource::Traced(demo)) => return Ok(demo.truth_views()),
            (None, TruthSource::Beside(path)) => transforms::truth_beside(path),
        };
        let Some(path) = beside else {
            let what = "comes without truth views; give views=, or hold_out= with names of cameras";
            return Err(Error::invalid(&self.capture.name, what));
        };
        transforms::open_views_of(&path, self.capture.frames_are_ranked())
    }
}

/// Accuracy, speed and size of one setting, beside no pruning and first camera wins, as `overlook evaluate --json` gives them.
///
/// # Errors
/// `Error` as [`compare`], and without any truth; `KeyboardInterrupt`, and what `progress` raises.
#[pyfunction]
#[pyo3(signature = (capture, *, views=None, hold_out=None, align_views=false, settings=None, progress=None))]
pub fn evaluate<'py>(
    py: Python<'py>,
    capture: &PyCapture,
    views: Option<PathBuf>,
    hold_out: Option<Vec<String>>,
    align_views: bool,
    settings: Option<&Bound<'_, PyDict>>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let settings = settings_over(Settings::default(), settings)?;
    let comparison = work::run(py, progress, |job| {
        let (seen, views) = match &hold_out {
            Some(names) => truth::split(&capture.capture, names)?,
            None => (capture.capture.clone(), capture.truth_views(views)?),
        };
        compare(&seen, &views, &settings, align_views, job)
    })?;
    let json = serde_json::to_string(&comparison)
        .map_err(|error| pyo3::exceptions::PyRuntimeError::new_err(error.to_string()))?;
    PyModule::import(py, "json")?.getattr("loads")?.call1((json,))
}

/// One frame of one camera.
#[pyclass(name = "Frame", module = "overlook", frozen)]
pub struct PyFrame(Arc<Frame>, Vec<ValueChannel>);

#[pymethods]
impl PyFrame {
    #[getter]
    fn color<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        arrays::colors(py, &self.0.color)
    }

    #[getter]
    fn depth<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        arrays::plane(py, &self.0.inverse_depth, |w| arrays::depth_of(*w))
    }

    /// Scalar values by the names of their channels.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        values::planes(py, &self.1, &self.0.values, self.0.size())
    }

    #[getter]
    fn normal_in_world<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray3<f32>>>> {
        self.0.normal_in_world.as_ref().map(|normals| arrays::vectors(py, normals)).transpose()
    }
}
