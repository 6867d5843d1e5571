//! The span stack: from the background to one frame, the samples of ever shorter spans are put where longer ones left room.

use std::sync::Arc;

use rayon::prelude::*;

use crate::capture::overlap::OverlapGraph;
use crate::capture::{Capture, Frame};
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::agreement::measure_noise_between;
use crate::preprocess::layers::{CameraLayer, LayerBuilder};
use crate::preprocess::temporal::{ROOT, SpanLevel, SpanTree, TemporalScan, all_frames};
use crate::samples::Span;
use crate::settings::{AgreementRule, Settings, SpanLevels};

/// The level of samples of one frame where nothing is known of other frames.
pub const FRAME: SpanLevel = 1;

/// Where the samples of spans come from.
#[derive(Clone, Copy)]
pub(crate) struct SpanSource<'a> {
    pub(crate) capture: &'a Capture,
    /// Without a scan every pixel is one of its frame alone.
    pub(crate) scan: Option<&'a TemporalScan>,
    pub(crate) builder: &'a LayerBuilder<'a>,
}

impl SpanSource<'_> {
    /// Puts and completes the samples of a camera over `span`, which is at `level`, into the layer that holds those of all longer
    /// spans. Gives their pixels.
    ///
    /// # Errors
    /// Whatever the capture gives (naming file and frame), and `Io` where the temporary file cannot be read.
    pub(crate) fn put(
        self,
        camera: usize,
        layer: &mut CameraLayer,
        span: Span,
        level: SpanLevel,
    ) -> Result<Vec<u32>> {
        let Self { capture, scan, builder } = self;
        layer.noise_share.resize(usize::from(level), 0.0);
        layer.noise_share.push((span.len() as f32).sqrt().recip());
        let pixels = if let Some(spans) = scan.and_then(|scan| scan.spans.as_ref()) {
            let samples = spans.get(camera, span)?.unwrap_or_default();
            layer.put(level, &samples);
            samples.pixels.clone()
        } else {
            let frame = capture.frame(camera, span.start as usize)?;
            if scan.is_none() {
                layer.depth_step_relative = frame.depth_step_relative;
            }
            layer.put_frame(level, &frame)
        };
        builder.estimate_normals(layer, &capture.cameras[camera], &pixels);
        builder.rate(layer, &capture.cameras[camera], &pixels);
        Ok(pixels)
    }
}

/// The samples of all cameras in the spans from all frames to the one put last.
pub(crate) struct SpanStack<'a> {
    capture: &'a Capture,
    scan: Option<&'a TemporalScan>,
    settings: &'a Settings,
    builder: LayerBuilder<'a>,
    /// Per camera, every sample that was put so far.
    pub(crate) layers: Vec<CameraLayer>,
}

impl<'a> SpanStack<'a> {
    /// Begins with layers of static pixels. Without a `scan` every pixel is one of its frame alone.
    pub(crate) fn new(
        capture: &'a Capture,
        scan: Option<&'a TemporalScan>,
        settings: &'a Settings,
        background: Vec<CameraLayer>,
    ) -> Self {
        let builder = LayerBuilder::new(settings, &capture.cameras, capture.antialiased_color);
        Self { capture, scan, settings, builder, layers: background }
    }

    /// The spans there are.
    pub(crate) fn tree(&self) -> SpanTree {
        let frames = self.capture.frame_count();
        match self.scan {
            Some(scan) => scan.tree(&self.settings.spans),
            None => SpanTree::new(frames, SpanLevels::Paper),
        }
    }

    /// Puts and completes the samples of `span`, which is at `level` below the span that was put last.
    ///
    /// # Errors
    /// As [`SpanSource::put`], and `Cancelled`.
    pub(crate) fn put_span(&mut self, span: Span, level: SpanLevel, job: &Job) -> Result<()> {
        let source = SpanSource { capture: self.capture, scan: self.scan, builder: &self.builder };
        self.layers.par_iter_mut().enumerate().try_for_each(|(camera, layer)| {
            job.check()?;
            source.put(camera, layer, span, level).map(|_| ())
        })
    }
}

/// The recorded pictures of all cameras at one frame.
///
/// # Errors
/// Whatever the capture gives, and `Cancelled`.
pub(crate) fn load_frame(capture: &Capture, frame: usize, job: &Job) -> Result<Vec<Arc<Frame>>> {
    let load = |camera| {
        job.check()?;
        capture.frame(camera, frame)
    };
    (0..capture.cameras.len()).into_par_iter().map(load).collect()
}

/// A layer with normals, and the pixels of its samples, ascending.
pub(crate) type StaticLayer = (CameraLayer, Vec<u32>);

/// The same with rates and noise between cameras, ready to be pruned.
pub(crate) fn rated(
    capture: &Capture,
    layers: Vec<StaticLayer>,
    settings: &Settings,
    job: &Job,
) -> Result<Vec<CameraLayer>> {
    let builder = LayerBuilder::new(settings, &capture.cameras, capture.antialiased_color);
    let rated = layers.into_par_iter().zip(&capture.cameras).map(|((mut layer, pixels), camera)| {
        job.check()?;
        builder.rate(&mut layer, camera, &pixels);
        Ok(layer)
    });
    let mut rated: Vec<CameraLayer> = rated.collect::<Result<_>>()?;
    measure_others_noise(&mut rated, capture, settings, job)?;
    Ok(rated)
}

/// Notes in each layer how noisy it is beside those of other cameras, where cameras vote.
///
/// # Errors
/// `Cancelled`.
pub(crate) fn measure_others_noise(
    layers: &mut [CameraLayer],
    capture: &Capture,
    settings: &Settings,
    job: &Job,
) -> Result<()> {
    if settings.pruning.agreement != AgreementRule::Off && !capture.is_noise_free() {
        let noise = measure_noise_between(&OverlapGraph::complete(&capture.cameras), layers, job)?;
        layers.iter_mut().zip(noise).for_each(|(layer, noise)| layer.noise_between = noise);
    }
    Ok(())
}

/// Every camera's static pixels with normals, not rated yet: no pruning threshold touches them.
pub(crate) fn static_layers(
    capture: &Capture,
    scan: &TemporalScan,
    settings: &Settings,
    job: &Job,
) -> Result<Vec<StaticLayer>> {
    let builder = LayerBuilder::new(settings, &capture.cameras, capture.antialiased_color);
    let of_camera = |index: usize| {
        job.check()?;
        static_layer(&builder, capture, scan, settings, index)
    };
    (0..scan.cameras.len()).into_par_iter().map(of_camera).collect()
}

/// The same of one camera.
///
/// # Errors
/// `Io` where the temporary file cannot be read.
pub(crate) fn static_layer(
    builder: &LayerBuilder<'_>,
    capture: &Capture,
    scan: &TemporalScan,
    settings: &Settings,
    index: usize,
) -> Result<StaticLayer> {
    let (camera, of_camera) = (&capture.cameras[index], &scan.cameras[index]);
    let (width, height) = camera.intrinsics.size();
    let samples = match (&scan.spans, &of_camera.ranges) {
        (Some(spans), _) => spans.get(index, all_frames(scan.frames))?.unwrap_or_default(),
        (None, Some(ranges)) => {
            let test = scan.static_test(index, &settings.spans);
            Arc::new(ranges.samples(&ranges.static_pixels(&settings.spans, &test)))
        }
        (None, None) => Arc::default(),
    };
    let mut layer = CameraLayer::empty_for(width, height, capture.value_channels());
    layer.noise = of_camera.noise.clone();
    // Those of all frames are their means.
    layer.noise_share = vec![(scan.frames.max(1) as f32).sqrt().recip()];
    layer.depth_step_relative = of_camera.depth_step_relative;
    layer.put(ROOT, &samples);
    builder.estimate_normals(&mut layer, camera, &samples.pixels);
    Ok((layer, samples.pixels.clone()))
}
