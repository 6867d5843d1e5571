//! The span stack: from the background to one frame, the samples of ever shorter spans are put where longer ones left room,
//! and decided against each other and against all that is decided above.
//!
//! Layers are changed in place and changed back, so that going down to a frame costs what its short-lived samples cost.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use rayon::prelude::*;

use super::background::PrunedBackground;
use super::decision::LevelVerdicts;
use super::pass::{ABSENT, Statuses};
use super::search;
use crate::capture::{Capture, Frame};
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::layers::{CameraLayer, LayerBuilder};
use crate::preprocess::registration::CameraPairs;
use crate::preprocess::temporal::{SpanLevel, SpanTree, TemporalScan};
use crate::samples::Span;
use crate::settings::{Settings, SpanLevels};

/// The level of samples of one frame where nothing is known of other frames.
pub const FRAME: SpanLevel = 1;

/// The samples of all cameras in the spans from all frames to the one entered last.
pub(crate) struct SpanStack<'a> {
    capture: &'a Capture,
    scan: Option<&'a TemporalScan>,
    pairs: &'a CameraPairs<'a>,
    settings: &'a Settings,
    builder: LayerBuilder<'a>,
    /// Per camera, every sample that was put so far.
    pub(crate) layers: Vec<CameraLayer>,
    statuses: Statuses,
}

/// What was put and decided at a step down, per camera.
pub(crate) struct StackStep {
    /// The samples, ascending.
    pub(crate) pixels: Vec<Vec<u32>>,
    /// The verdicts on them.
    pub(crate) decided: Vec<LevelVerdicts>,
}

impl<'a> SpanStack<'a> {
    /// Begins at `background`. Without a `scan` every pixel is one of its frame alone.
    pub(crate) fn new(
        capture: &'a Capture,
        scan: Option<&'a TemporalScan>,
        pairs: &'a CameraPairs<'a>,
        settings: &'a Settings,
        background: PrunedBackground,
    ) -> Self {
        let builder = LayerBuilder::new(settings, &capture.cameras, capture.antialiased_color);
        Self {
            capture,
            scan,
            pairs,
            settings,
            builder,
            layers: background.layers,
            statuses: background.statuses,
        }
    }

    /// The spans there are.
    pub(crate) fn tree(&self) -> SpanTree {
        let frames = self.capture.frame_count();
        match self.scan {
            Some(scan) => scan.tree(&self.settings.spans),
            None => SpanTree::new(frames, SpanLevels::Paper),
        }
    }

    /// Puts and decides the samples of `span`, which is at `level` below the span that was entered last.
    ///
    /// # Errors
    /// Whatever the capture gives (naming file and frame), `Io` where the temporary file cannot be read, and `Cancelled`.
    pub(crate) fn enter(&mut self, span: Span, level: SpanLevel, job: &Job) -> Result<StackStep> {
        let pixels = self.put_span(span, level, job)?;
        let decided = search::prune(self.pairs, &self.layers, &self.statuses, level, self.settings, job)?;
        Ok(StackStep { pixels, decided })
    }

    /// Puts and completes the samples of `span`, undecided. Gives their pixels, per camera.
    pub(crate) fn put_span(&mut self, span: Span, level: SpanLevel, job: &Job) -> Result<Vec<Vec<u32>>> {
        let (capture, scan, builder) = (self.capture, self.scan, &self.builder);
        let of_camera = |(camera, layer): (usize, &mut CameraLayer)| {
            job.check()?;
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
        };
        self.layers.par_iter_mut().enumerate().map(of_camera).collect()
    }

    /// Takes the samples of a step away again; later steps must be taken away before.
    pub(crate) fn leave(&mut self, step: &StackStep) {
        let cameras = self.layers.par_iter_mut().zip(&self.statuses).zip(&step.pixels);
        cameras.for_each(|((layer, statuses), pixels)| {
            for &pixel in pixels {
                layer.clear(pixel as usize);
                statuses[pixel as usize].store(ABSENT, Ordering::Relaxed);
            }
        });
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
