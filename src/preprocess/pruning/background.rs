//! The background: every camera's static pixels, pruned against each other once for all frames.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use rayon::prelude::*;

use super::decision::Decided;
use super::search;
use super::status::{ABSENT, no_statuses};
use crate::capture::Capture;
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::layers::{CameraLayer, LayerBuilder};
use crate::preprocess::registration::CameraPairs;
use crate::preprocess::temporal::{ROOT, TemporalScan, all_frames};
use crate::settings::Settings;

/// Static pixels of all cameras with their verdicts.
#[derive(Clone, Debug)]
pub(crate) struct PrunedBackground {
    /// Per camera; pixels that are not static hold no sample.
    pub(crate) layers: Vec<CameraLayer>,
    /// Per camera and pixel: as [`Statuses`](super::status::Statuses).
    pub(crate) statuses: Vec<Vec<u8>>,
    /// The verdicts.
    pub(crate) decided: Vec<Decided>,
}

impl PrunedBackground {
    /// A background without any sample: every pixel will count as foreground.
    pub(crate) fn none(capture: &Capture) -> Self {
        let layers = capture
            .cameras
            .iter()
            .map(|camera| {
                let (width, height) = camera.intrinsics.size();
                CameraLayer::empty(width, height)
            })
            .collect();
        Self::undecided(layers)
    }

    /// Layers on which nothing was decided.
    pub(crate) fn undecided(layers: Vec<CameraLayer>) -> Self {
        Self {
            statuses: layers.iter().map(|layer| vec![ABSENT; layer.level.len()]).collect(),
            decided: layers.iter().map(|_| Decided::default()).collect(),
            layers,
        }
    }

    /// The pruned background under `settings`, which `scan` serves.
    ///
    /// # Errors
    /// `Cancelled`, and `Io` where a temporary file cannot be read.
    pub(crate) fn of(capture: &Capture, scan: &TemporalScan, settings: &Settings, job: &Job) -> Result<Self> {
        Self::prune(capture, static_layers(capture, scan, settings, job)?, settings, job)
    }

    /// Prunes static layers, which need their rates yet, against each other.
    fn prune(capture: &Capture, layers: Vec<StaticLayer>, settings: &Settings, job: &Job) -> Result<Self> {
        let layers = rated(capture, layers, settings, job)?;
        let pairs = CameraPairs::new(&capture.cameras);
        let statuses = no_statuses(&layers);
        let decided = search::prune(&pairs, &layers, &statuses, ROOT, settings, job)?;
        let statuses = statuses
            .iter()
            .map(|camera| camera.iter().map(|status| status.load(Ordering::Relaxed)).collect());
        Ok(Self { statuses: statuses.collect(), decided, layers })
    }
}

/// A layer with normals, and the pixels of its samples, ascending.
pub(crate) type StaticLayer = (CameraLayer, Vec<u32>);

/// The same with rates, ready to be pruned.
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
    rated.collect()
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
        let mut layer = CameraLayer::empty(width, height);
        layer.noise = of_camera.noise.clone();
        // Those of all frames are their means.
        layer.noise_share = vec![(scan.frames.max(1) as f32).sqrt().recip()];
        layer.depth_step_relative = of_camera.depth_step_relative;
        layer.put(ROOT, &samples);
        builder.estimate_normals(&mut layer, camera, &samples.pixels);
        Ok((layer, samples.pixels.clone()))
    };
    (0..scan.cameras.len()).into_par_iter().map(of_camera).collect()
}
