//! Stores: the kept samples, in memory after preprocessing or played from a file.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use glam::{DVec2, DVec3};
use half::f16;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray2};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyModule};

use super::camera::{PyCamera, PyLens, pose_of};
use super::choices::{edit_list, settings_over};
use super::exceptions::to_exception;
use super::page::PyPage;
use super::splats::PySplats;
use super::values::{self, PyValueChannel};
use super::{arrays, work};
use overlook_engine::capture::{Camera, ValueChannel};
use overlook_engine::edited_store::open_edited;
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::page::{self, PageOptions};
use overlook_engine::plural::counted;
use overlook_engine::preprocess::Preprocessed;
use overlook_engine::render::output::PictureValues;
use overlook_engine::render::{NO_IMAGE, Picture, Renderer, Vantage};
use overlook_engine::samples::{SampleImage, SampleSet, VerdictBuffer};
use overlook_engine::settings::RenderSettings;
use overlook_engine::splats::{self, SplatAmount, SplatSky};
use overlook_engine::store::file::{Extras, write_with};
use overlook_engine::store::playback::{DEFAULT_CACHE_BYTES, Playback};
use overlook_engine::store::write_again;

/// Opens a store, or what edits leave of it, for playing it from disk.
///
/// # Errors
/// `Error` as [`open_edited`], and where the list is none.
#[pyfunction]
#[pyo3(signature = (path, *, edits=None))]
pub fn open_store(py: Python<'_>, path: PathBuf, edits: Option<PathBuf>) -> PyResult<PyStore> {
    let store = work::run(py, None, |job| open_edited(&path, &edit_list(edits)?, job))?;
    let (report, warnings) = (store.info().report.clone(), store.info().warnings.clone());
    let playback = Playback::new(store, DEFAULT_CACHE_BYTES);
    let outline = playback.outline().clone();
    Ok(PyStore {
        samples: Samples::OnDisk(path, Box::new(playback)),
        outline,
        report,
        warnings,
        renderer: Mutex::default(),
    })
}

/// Most bytes of a page in a notebook, which keeps what it shows.
const SHOWN_AT_MOST: u64 = 8_000_000;

enum Samples {
    InMemory(Arc<SampleSet>, Option<Arc<VerdictBuffer>>),
    OnDisk(PathBuf, Box<Playback>),
}

impl Samples {
    /// Those of one frame, or all.
    fn at(&self, frame: Option<usize>, job: &Job) -> Result<Arc<SampleSet>> {
        match (self, frame) {
            (Self::InMemory(samples, _), _) => Ok(samples.clone()),
            (Self::OnDisk(_, playback), Some(frame)) => playback.at(frame, job),
            (Self::OnDisk(_, playback), None) => Ok(Arc::new(playback.store().read_undamaged(job)?)),
        }
    }
}

/// The kept samples of a capture.
#[pyclass(name = "Store", module = "overlook", frozen)]
pub struct PyStore {
    samples: Samples,
    /// Cameras, frames and settings.
    outline: Arc<SampleSet>,
    /// JSON.
    report: String,
    warnings: Vec<String>,
    renderer: Mutex<Renderer>,
}

impl PyStore {
    /// Refuses a frame and a camera that there are not.
    fn check_place(&self, frame: Option<usize>, camera: Option<usize>) -> PyResult<()> {
        let (frames, cameras) = (self.outline.frame_count(), self.outline.cameras.len());
        if frame.is_none_or(|frame| frame < frames) && camera.is_none_or(|camera| camera < cameras) {
            return Ok(());
        }
        let (frames, cameras) = (counted(frames, "frame"), counted(cameras, "camera"));
        Err(PyIndexError::new_err(format!("'{}' has {frames} and {cameras}", self.outline.name)))
    }

    /// A picture, and the samples that it was made of.
    fn picture(
        &self,
        vantage: &Vantage,
        settings: &RenderSettings,
        job: &Job,
    ) -> Result<(Arc<Picture>, Arc<SampleSet>)> {
        vantage.check(&self.outline)?;
        let samples = match &self.samples {
            Samples::InMemory(samples, _) => samples.clone(),
            Samples::OnDisk(_, playback) => playback.seen_from(&vantage.camera, vantage.frame, job)?,
        };
        let mut renderer = self.renderer.lock().unwrap_or_else(PoisonError::into_inner);
        let picture = renderer.render(&samples, vantage, settings, job)?.0;
        Ok((picture, samples))
    }

    pub(super) fn of(Preprocessed { samples, verdicts, report }: Preprocessed) -> PyResult<Self> {
        let warnings = report.warnings();
        let report = report.to_json().map_err(|error| to_exception(&error))?;
        let outline = samples.clone();
        Ok(Self {
            samples: Samples::InMemory(samples, verdicts),
            outline,
            report,
            warnings,
            renderer: Mutex::default(),
        })
    }
}

#[pymethods]
impl PyStore {
    #[getter]
    fn name(&self) -> &str {
        &self.outline.name
    }

    #[getter]
    fn cameras(&self) -> Vec<PyCamera> {
        self.outline.cameras.iter().cloned().map(PyCamera).collect()
    }

    #[getter]
    fn frame_numbers(&self) -> Vec<i64> {
        self.outline.frame_numbers.clone()
    }

    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// The channels of scalar values.
    #[getter]
    fn values(&self) -> Vec<PyValueChannel> {
        values::channels(&self.outline.values)
    }

    /// What preprocessing counted and measured.
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        PyModule::import(py, "json")?.getattr("loads")?.call1((&self.report,))
    }

    /// Writes the store to a file; gives its size in bytes.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<u64> {
        work::run(py, None, |job| match &self.samples {
            Samples::InMemory(samples, verdicts) => {
                let (report, verdicts) = (self.report.clone(), verdicts.clone());
                let extras = Extras { report, verdicts, ..Extras::default() };
                write_with(&path, samples, &extras, job)
            }
            Samples::OnDisk(_, playback) => write_again(&path, playback.store(), None, job),
        })
    }

    /// Writes one HTML file that plays the scene in any browser; gives its size in bytes.
    #[pyo3(signature = (path, *, title=None, text=None, fps=24.0, at_most=None))]
    fn export_page(
        &self,
        py: Python<'_>,
        path: PathBuf,
        title: Option<String>,
        text: Option<String>,
        fps: f64,
        at_most: Option<u64>,
    ) -> PyResult<u64> {
        let options = page_options(title, text, fps, at_most)?;
        work::run(py, None, |job| {
            let samples = self.samples.at(None, job)?;
            Ok(page::write_set(&path, &samples, &options, job)?.bytes)
        })
    }

    /// The same page for a notebook, which shows it.
    #[pyo3(signature = (*, title=None, text=None, fps=24.0, at_most=SHOWN_AT_MOST, height=480))]
    fn page(
        &self,
        py: Python<'_>,
        title: Option<String>,
        text: Option<String>,
        fps: f64,
        at_most: u64,
        height: u32,
    ) -> PyResult<PyPage> {
        let options = page_options(title, text, fps, Some(at_most))?;
        let (page, of_store) = work::run(py, None, |job| {
            let samples = self.samples.at(None, job)?;
            Ok((page::page(&samples, &options, job)?, samples.sample_count()))
        })?;
        Ok(PyPage::new(options.title.unwrap_or_else(|| self.outline.name.clone()), page, of_store, height))
    }

    /// The samples that show one frame as flat Gaussians.
    #[pyo3(signature = (frame=0, *, at_most=None, sky="out"))]
    fn splats(&self, py: Python<'_>, frame: usize, at_most: Option<u64>, sky: &str) -> PyResult<PySplats> {
        let sky = sky.parse::<SplatSky>().map_err(|what| PyValueError::new_err(format!("sky: {what}")))?;
        self.check_place(Some(frame), None)?;
        let found = work::run(py, None, |job| {
            let samples = self.samples.at(Some(frame), job)?;
            splats::arrays(&samples, frame, SplatAmount { at_most, sky }, job)
        })?;
        PySplats::of(py, found)
    }

    /// The samples of one frame, or of all spans; of one camera, or of all.
    #[pyo3(signature = (frame=None, camera=None))]
    fn samples(&self, py: Python<'_>, frame: Option<usize>, camera: Option<usize>) -> PyResult<PySamples> {
        self.check_place(frame, camera)?;
        let rows = work::run(py, None, |job| {
            let samples = self.samples.at(frame, job)?;
            let is_wanted = |image: &&Arc<SampleImage>| {
                frame.is_none_or(|frame| image.span.contains(frame))
                    && camera.is_none_or(|camera| image.camera as usize == camera)
            };
            let mut rows = SampleRows::default();
            for image in samples.images.iter().filter(is_wanted) {
                rows.add(image, &samples.cameras[image.camera as usize]);
            }
            Ok(rows)
        })?;
        rows.into_arrays(py, &self.outline.values)
    }

    /// A picture from any place: color, depth, and where samples were seen.
    #[pyo3(signature = (pose, lens, frame=0, settings=None))]
    fn render<'py>(
        &self,
        py: Python<'py>,
        pose: PyReadonlyArray2<'_, f64>,
        lens: PyLens,
        frame: usize,
        settings: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Rendered<'py>> {
        let settings = settings_over(self.outline.settings.clone(), settings)?.render;
        let vantage = vantage_at(&pose, lens, frame)?;
        let (picture, _) = work::run(py, None, |job| self.picture(&vantage, &settings, job))?;
        Ok((
            arrays::vectors(py, &picture.color)?,
            arrays::plane(py, &picture.inverse_depth, |w| arrays::depth_of(*w))?,
            arrays::plane(py, &picture.image, |image| *image != NO_IMAGE)?,
        ))
    }

    /// The scalar values that such a picture shows, those of the nearest surface, by the names of their channels.
    #[pyo3(signature = (pose, lens, frame=0, settings=None))]
    fn render_values<'py>(
        &self,
        py: Python<'py>,
        pose: PyReadonlyArray2<'_, f64>,
        lens: PyLens,
        frame: usize,
        settings: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let settings = settings_over(self.outline.settings.clone(), settings)?.render;
        let vantage = vantage_at(&pose, lens, frame)?;
        let PictureValues { channels, values } = work::run(py, None, |job| {
            let (picture, samples) = self.picture(&vantage, &settings, job)?;
            Ok(PictureValues::of(&samples, &vantage, &picture))
        })?;
        values::planes(py, &channels, &values, vantage.camera.intrinsics.size())
    }

    fn __repr__(&self) -> String {
        let place = match &self.samples {
            Samples::InMemory(samples, _) => counted(samples.sample_count(), "sample") + " in memory",
            Samples::OnDisk(path, _) => path.display().to_string(),
        };
        format!("<overlook.Store '{}', {place}>", self.outline.name)
    }
}

fn vantage_at(pose: &PyReadonlyArray2<'_, f64>, lens: PyLens, frame: usize) -> PyResult<Vantage> {
    let (name, intrinsics) = ("python".to_owned(), lens.intrinsics());
    Ok(Vantage { camera: Camera { name, intrinsics, world_from_camera: pose_of(pose)? }, frame })
}

fn page_options(
    title: Option<String>,
    text: Option<String>,
    fps: f64,
    at_most: Option<u64>,
) -> PyResult<PageOptions> {
    if !(fps > 0.0 && fps.is_finite()) {
        return Err(PyValueError::new_err(format!("fps: {fps} is no number of frames a second")));
    }
    Ok(PageOptions { title, text, frames_per_second: fps, path: None, at_most, scalar_bar: None })
}

type Rendered<'py> = (Bound<'py, PyArray3<f32>>, Bound<'py, PyArray2<f32>>, Bound<'py, PyArray2<bool>>);

/// Samples as rows, before they become arrays.
#[derive(Default)]
struct SampleRows {
    camera: Vec<u32>,
    pixel: Vec<[u32; 2]>,
    span: Vec<[u32; 2]>,
    color: Vec<[f32; 3]>,
    depth: Vec<f32>,
    point_in_world: Vec<[f64; 3]>,
    normal_in_world: Vec<[f32; 3]>,
    /// Channel by channel.
    values: Vec<Vec<f32>>,
}

impl SampleRows {
    fn add(&mut self, image: &SampleImage, camera: &Camera) {
        let inverse_depths = image.inverse_depths();
        for sample in image.samples() {
            let inverse_depth = inverse_depths[sample.index];
            let pixel = DVec2::new(sample.x as f64 + 0.5, sample.y as f64 + 0.5);
            let ray = camera.intrinsics.ray_in_camera(pixel);
            let point = if camera.intrinsics.is_orthographic() && inverse_depth != 0.0 {
                camera.unproject(pixel, f64::from(inverse_depth).recip())
            } else if inverse_depth == 0.0 {
                // Of a sample at infinity nothing but the direction is known.
                camera.world_from_camera.transform_vector3(ray) * f64::INFINITY
            } else {
                camera.world_from_camera.transform_point3(ray / f64::from(inverse_depth))
            };
            self.camera.push(image.camera);
            self.pixel.push([sample.x as u32, sample.y as u32]);
            self.span.push([image.span.start, image.span.end]);
            self.color.push(image.color[sample.index].map(f16::to_f32));
            self.depth.push(arrays::depth_of(inverse_depth));
            self.point_in_world.push(no_nan(point).to_array());
            self.values.resize_with(image.values.channels(), Vec::new);
            for (column, value) in self.values.iter_mut().zip(image.values.of(sample.index)) {
                column.push(*value);
            }
            if let Some(normals) = &image.normal {
                self.normal_in_world.push(normals[sample.index].decode().to_array());
            }
        }
    }

    fn into_arrays(mut self, py: Python<'_>, channels: &[ValueChannel]) -> PyResult<PySamples> {
        self.values.resize_with(channels.len(), Vec::new);
        let has_normals = self.normal_in_world.len() == self.camera.len();
        let normals = has_normals.then(|| arrays::rows(py, self.normal_in_world)).transpose()?;
        Ok(PySamples {
            camera: self.camera.into_pyarray(py).unbind(),
            pixel: arrays::rows(py, self.pixel)?.unbind(),
            span: arrays::rows(py, self.span)?.unbind(),
            color: arrays::rows(py, self.color)?.unbind(),
            depth: self.depth.into_pyarray(py).unbind(),
            point_in_world: arrays::rows(py, self.point_in_world)?.unbind(),
            normal_in_world: normals.map(Bound::unbind),
            values: values::columns(py, channels, self.values)?.unbind(),
        })
    }
}

/// An infinite vector along an axis has no part along the others.
fn no_nan(point: DVec3) -> DVec3 {
    DVec3::from_array(point.to_array().map(|along| if along.is_nan() { 0.0 } else { along }))
}

/// Samples, one row each.
#[pyclass(name = "Samples", module = "overlook", frozen, get_all)]
pub struct PySamples {
    camera: Py<PyArray1<u32>>,
    pixel: Py<PyArray2<u32>>,
    span: Py<PyArray2<u32>>,
    color: Py<PyArray2<f32>>,
    depth: Py<PyArray1<f32>>,
    point_in_world: Py<PyArray2<f64>>,
    normal_in_world: Option<Py<PyArray2<f32>>>,
    values: Py<PyDict>,
}

#[pymethods]
impl PySamples {
    fn __len__(&self, py: Python<'_>) -> PyResult<usize> {
        self.camera.bind(py).len()
    }
}
