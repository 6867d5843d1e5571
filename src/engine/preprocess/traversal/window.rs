//! The layers of those cameras that are worked on: all, or those that memory has room for, put together when they are needed.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

use glam::Vec3;
use rayon::prelude::*;

use super::groups::{LAYERS_AT_A_TIME, Recording};
use crate::capture::overlap::OverlapGraph;
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::agreement::SmoothDepths;
use crate::preprocess::layers::{CameraLayer, LayerBuilder, RatedSamples};
use crate::preprocess::noise::NoiseBetween;
use crate::preprocess::pruning::{ABSENT, SpanSource, static_layer};
use crate::preprocess::temporal::{ROOT, SpanLevel};
use crate::samples::{RecordPlace, Span, SpillFile, samples_in_memory};

/// Bytes of a pixel in a layer of this window, without its normal: color, inverse depth, rank, geometry, packed color, level, and
/// the smoothed depth.
const PIXEL_BYTES: usize = 6 + 4 + 4 + 16 + 8 + 1 + 4;
const NORMAL_BYTES: usize = 12;

/// The share of the memory for samples that those of one span take before they go to a temporary file: several spans are entered at once.
const SPAN_SHARE: usize = 4;

/// The samples of all cameras over one span.
struct SpanSamples {
    level: SpanLevel,
    of_camera: Vec<CameraSamples>,
    spill: SpillFile,
}

/// The samples of a camera over one span.
enum CameraSamples {
    None,
    Some(RecordPlace<RatedSamples>),
    /// Those of all frames, as a layer: most pixels have one, and it is needed again and again.
    Layer(RecordPlace<CameraLayer>),
}

/// Layers of some cameras; those of all others are without samples, and take part in nothing.
pub(super) struct LayerWindow<'a> {
    recording: Recording<'a>,
    builder: LayerBuilder<'a>,
    /// The spans that were entered, from all frames down.
    path: Vec<SpanSamples>,
    pub(super) layers: Vec<CameraLayer>,
    /// Depths of these layers.
    pub(super) smooth: Arc<SmoothDepths>,
    /// Per camera, when it was last needed; 0 if its layer is not held.
    used: Vec<u64>,
    /// Layers that were given up, whose memory is used again.
    spare: Vec<CameraLayer>,
    turn: u64,
    /// Bytes of the share of layers that something else takes.
    reserved: usize,
    /// Whether all layers fit, and are held throughout.
    pub(super) holds_all: bool,
}

impl<'a> LayerWindow<'a> {
    /// No span was entered yet.
    pub(super) fn new(recording: Recording<'a>, pairs: &OverlapGraph<'_>) -> Self {
        let Recording { capture, settings, .. } = recording;
        let count = capture.cameras.len();
        let mut window = Self {
            recording,
            builder: LayerBuilder::new(settings, &capture.cameras, capture.antialiased_color),
            path: Vec::new(),
            layers: (0..count).map(|_| CameraLayer::empty(0, 0)).collect(),
            smooth: Arc::new(SmoothDepths::new(pairs, ROOT)),
            used: vec![0; count],
            spare: Vec::new(),
            turn: 0,
            reserved: 0,
            holds_all: false,
        };
        window.holds_all = (0..count).map(|camera| window.bytes(camera)).sum::<usize>() <= recording.bound;
        window
    }

    /// Sets the noise of each camera beside the others.
    pub(super) fn set_noise(&mut self, noise: Vec<Option<Arc<NoiseBetween>>>) {
        self.layers.iter_mut().zip(noise).for_each(|(layer, noise)| layer.noise_between = noise);
    }

    /// The largest standard deviation of depth between cameras, relative; 0 where depth is not noisy.
    pub(super) fn most_noise(&self) -> f32 {
        let noise = self.layers.iter().filter_map(|layer| layer.noise_between.as_ref());
        noise.flat_map(|noise| noise.depth_relative).fold(0.0, f32::max)
    }

    /// Bytes of a camera's layer.
    pub(super) fn bytes(&self, camera: usize) -> usize {
        let normals = if self.recording.settings.store.normals { NORMAL_BYTES } else { 0 };
        let values = size_of::<f32>() * self.recording.capture.value_channels().len();
        self.recording.capture.cameras[camera].intrinsics.pixel_count() * (PIXEL_BYTES + normals + values)
    }

    /// The samples of a camera over the span that was entered last.
    ///
    /// # Errors
    /// `Io` where the temporary file cannot be read.
    pub(super) fn samples(&self, camera: usize) -> Result<Arc<RatedSamples>> {
        let Some(step) = self.path.last() else { return Ok(Arc::default()) };
        match &step.of_camera[camera] {
            CameraSamples::None => Ok(Arc::default()),
            CameraSamples::Some(place) => step.spill.get(place),
            CameraSamples::Layer(_) if self.used[camera] > 0 => {
                Ok(Arc::new(RatedSamples::of_level(&self.layers[camera], step.level)))
            }
            CameraSamples::Layer(place) => {
                let layer = step.spill.get(place)?;
                Ok(Arc::new(RatedSamples::of_level(&layer, step.level)))
            }
        }
    }

    /// Puts the samples of all cameras over `span`, which is at `level` within the span that was entered last. Gives what `look` makes
    /// of each camera's layer and its new samples, and the number of these.
    ///
    /// # Errors
    /// Whatever the capture gives (naming file and frame), `Io` where a temporary file cannot be used, and `Cancelled`.
    pub(super) fn enter<T: Send>(
        &mut self,
        span: Span,
        level: SpanLevel,
        look: impl Fn(usize, &CameraLayer, &RatedSamples) -> T + Sync,
        job: &Job,
    ) -> Result<Vec<(T, usize)>> {
        let settings = self.recording.settings;
        let share = samples_in_memory(settings) / SPAN_SHARE;
        let mut step = SpanSamples {
            level,
            of_camera: (0..self.layers.len()).map(|_| CameraSamples::None).collect(),
            spill: SpillFile::new(if self.holds_all { usize::MAX } else { share }),
        };
        let mut looked = Vec::with_capacity(self.layers.len());
        let cameras: Vec<usize> = (0..self.layers.len()).collect();
        let together = if self.holds_all { cameras.len() } else { rayon::current_num_threads() };
        for cameras in cameras.chunks(together.max(1)) {
            if level > ROOT {
                self.hold(cameras, job)?;
            } else {
                self.turn += 1;
                self.give_up_for(cameras);
            }
            let layers: Vec<(usize, CameraLayer)> = cameras
                .iter()
                .map(|&camera| {
                    (camera, std::mem::replace(&mut self.layers[camera], CameraLayer::empty(0, 0)))
                })
                .collect();
            let put = layers.into_par_iter().map(|(camera, layer)| {
                job.check()?;
                let (layer, pixels) = self.put(camera, layer, span, level)?;
                let samples = RatedSamples::of(&layer, level, pixels, settings.store.normals);
                let looked = look(camera, &layer, &samples);
                Ok((self.kept_planes(layer), samples, looked))
            });
            let put: Vec<_> = put.collect::<Result<_>>()?;
            for (&camera, (layer, samples, found)) in cameras.iter().zip(put) {
                looked.push((found, samples.len()));
                self.used[camera] = self.turn;
                self.layers[camera] = layer;
                if samples.len() == 0 {
                    continue;
                }
                step.of_camera[camera] = if level > ROOT || self.holds_all {
                    CameraSamples::Some(step.spill.put(samples)?)
                } else {
                    let known = self.layers[camera].without_samples();
                    let layer = std::mem::replace(&mut self.layers[camera], known);
                    self.used[camera] = 0;
                    CameraSamples::Layer(step.spill.put(layer)?)
                };
            }
        }
        self.path.push(step);
        Ok(looked)
    }

    /// A camera's layer with its samples over a span, and their pixels.
    fn put(
        &self,
        camera: usize,
        mut layer: CameraLayer,
        span: Span,
        level: SpanLevel,
    ) -> Result<(CameraLayer, Vec<u32>)> {
        let Recording { capture, scan, settings, .. } = self.recording;
        if level == ROOT {
            let (mut layer, pixels) = static_layer(&self.builder, capture, scan, settings, camera)?;
            self.builder.rate(&mut layer, &capture.cameras[camera], &pixels);
            return Ok((layer, pixels));
        }
        layer.normal.resize(layer.level.len(), Vec3::ZERO);
        let source = SpanSource { capture, scan: Some(scan), builder: &self.builder };
        let pixels = source.put(camera, &mut layer, span, level)?;
        Ok((layer, pixels))
    }

    /// A layer without what nothing reads any more.
    fn kept_planes(&self, mut layer: CameraLayer) -> CameraLayer {
        layer.footprint = Vec::new();
        let is_left_again = self.holds_all && !self.recording.is_of_one_moment();
        if !self.recording.settings.store.normals && !is_left_again {
            layer.normal = Vec::new();
        }
        layer
    }

    /// Lets go of the samples of the span that was entered last, where layers are not put together from them again.
    pub(super) fn forget_samples(&mut self) {
        if let Some(step) = self.path.last_mut().filter(|_| self.holds_all) {
            step.of_camera.iter_mut().for_each(|samples| *samples = CameraSamples::None);
        }
    }

    /// Takes the samples of the span that was entered last away again, and their statuses.
    ///
    /// # Errors
    /// `Io` where the temporary file cannot be read.
    pub(super) fn leave(&mut self, statuses: &[Vec<AtomicU8>]) -> Result<()> {
        let Some(step) = self.path.pop() else { return Ok(()) };
        let SpanSamples { of_camera, spill, .. } = step;
        let cameras = self.layers.par_iter_mut().zip(statuses).zip(of_camera);
        cameras.try_for_each(|((layer, statuses), samples)| {
            // Nothing leaves the span of all frames.
            let CameraSamples::Some(place) = samples else { return Ok(()) };
            let is_held = !layer.geometry.is_empty();
            for &pixel in &spill.get(&place)?.pixels {
                statuses[pixel as usize].store(ABSENT, Ordering::Relaxed);
                if is_held {
                    layer.clear(pixel as usize);
                }
            }
            Ok(())
        })
    }

    /// Puts together those layers that are not held yet. Others are given up where all together would take too much, first those that
    /// were not asked for the longest.
    ///
    /// # Errors
    /// `Io` where the temporary file cannot be read, and `Cancelled`.
    pub(super) fn hold(&mut self, cameras: &[usize], job: &Job) -> Result<()> {
        self.turn += 1;
        let missing: Vec<usize> = cameras.iter().copied().filter(|camera| self.used[*camera] == 0).collect();
        for camera in cameras {
            self.used[*camera] = self.turn;
        }
        if missing.is_empty() {
            return Ok(());
        }
        self.give_up_for(&missing);
        let mut spare = std::mem::take(&mut self.spare).into_iter();
        let missing_with_spare: Vec<_> =
            missing.iter().map(|camera| (*camera, spare.next().unwrap_or_default())).collect();
        let made = missing_with_spare.into_par_iter().map(|(camera, spare)| {
            job.check()?;
            self.layer(camera, spare)
        });
        let made: Vec<CameraLayer> = made.collect::<Result<_>>()?;
        missing.into_iter().zip(made).for_each(|(camera, layer)| self.layers[camera] = layer);
        Ok(())
    }

    /// Leaves so many bytes of the share of layers to what is worked on, and gives layers up for it, unless all are held.
    pub(super) fn reserve(&mut self, bytes: usize) {
        if !self.holds_all {
            self.reserved = bytes;
            self.turn += 1;
            self.give_up_for(&[]);
        }
    }

    /// Holds the layers of these cameras and of no others.
    ///
    /// # Errors
    /// As [`LayerWindow::hold`].
    pub(super) fn hold_only(&mut self, cameras: &[usize], job: &Job) -> Result<()> {
        for camera in 0..self.layers.len() {
            if self.used[camera] > 0 && !cameras.contains(&camera) {
                self.give_up(camera);
            }
        }
        self.hold(cameras, job)
    }

    fn give_up(&mut self, camera: usize) {
        let known = self.layers[camera].without_samples();
        let given_up = std::mem::replace(&mut self.layers[camera], known);
        if self.spare.len() < LAYERS_AT_A_TIME {
            self.spare.push(given_up);
        }
        self.used[camera] = 0;
        if let Some(smooth) = Arc::get_mut(&mut self.smooth) {
            smooth.forget(camera);
        }
    }

    fn give_up_for(&mut self, missing: &[usize]) {
        let mut bytes = self.reserved;
        bytes += missing.iter().map(|camera| self.bytes(*camera)).sum::<usize>();
        let is_held = |camera: &usize| !self.layers[*camera].geometry.is_empty();
        let mut held: Vec<usize> = (0..self.layers.len()).filter(is_held).collect();
        bytes += held.iter().map(|camera| self.bytes(*camera)).sum::<usize>();
        held.retain(|camera| self.used[*camera] < self.turn);
        held.sort_by_key(|camera| self.used[*camera]);
        for camera in held {
            if bytes <= self.recording.bound {
                break;
            }
            bytes -= self.bytes(camera);
            self.give_up(camera);
        }
    }

    /// The layer of a camera with the samples of all spans that were entered, in the memory of a `spare` one where that fits.
    fn layer(&self, index: usize, mut spare: CameraLayer) -> Result<CameraLayer> {
        let (width, height) = self.recording.capture.cameras[index].intrinsics.size();
        let known = self.layers[index].without_samples();
        let root = self.path.first().map(|step| (&step.of_camera[index], &step.spill));
        let has_room = spare.level.len() == width * height && spare.width == width;
        let mut layer = match root {
            Some((CameraSamples::Layer(place), spill)) if has_room => {
                spill.fill(place, &mut spare.planes_mut())?;
                known.with_planes_of(spare)
            }
            Some((CameraSamples::Layer(place), spill)) => {
                known.with_planes_of(Arc::unwrap_or_clone(spill.get(place)?))
            }
            _ => {
                let mut layer = known.of_size(width, height);
                if self.recording.settings.store.normals {
                    layer.normal = vec![Vec3::ZERO; width * height];
                }
                layer
            }
        };
        for step in &self.path {
            if let CameraSamples::Some(place) = &step.of_camera[index] {
                step.spill.get(place)?.put_into(&mut layer);
            }
        }
        Ok(layer)
    }
}
