//! The background: every camera's static pixels, pruned against each other once for all frames.

use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};

use rayon::prelude::*;

use super::descent::put;
use super::frame_layers::{FrameKey, FrameLayers};
use super::layer::{Layer, LayerBuilder, ROOT};
use super::normal_errors::NormalErrors;
use super::pruning::{self, Decided, Rig};
use super::span_tree::all_frames;
use super::temporal::TemporalScan;
use crate::capture::Capture;
use crate::error::Result;
use crate::job::Job;
use crate::settings::{NormalSettings, Settings, SpanSettings};

/// Static pixels of all cameras with their verdicts.
#[derive(Clone, Debug)]
pub struct Background {
    /// Per camera; pixels that are not static hold no sample.
    pub layers: Vec<Layer>,
    /// Per camera and pixel: [`pruning::ABSENT`], [`pruning::KEPT`] or [`pruning::DROPPED`].
    pub statuses: Vec<Vec<u8>>,
    /// The verdicts.
    pub decided: Vec<Decided>,
}

impl Background {
    /// A background without any sample: every pixel will count as foreground.
    #[must_use]
    pub fn none(capture: &Capture) -> Self {
        let layers = capture
            .cameras
            .iter()
            .map(|camera| {
                let (width, height) = camera.intrinsics.size();
                Layer::empty(width, height)
            })
            .collect();
        Self::undecided(layers)
    }

    /// Layers on which nothing was decided.
    #[must_use]
    pub fn undecided(layers: Vec<Layer>) -> Self {
        Self {
            statuses: layers.iter().map(|layer| vec![pruning::ABSENT; layer.level.len()]).collect(),
            decided: layers.iter().map(|_| Decided::default()).collect(),
            layers,
        }
    }

    /// The pruned background under `settings`, which `scan` serves.
    ///
    /// # Errors
    /// `Cancelled`, and `Io` where a temporary file cannot be read.
    pub fn of(capture: &Capture, scan: &TemporalScan, settings: &Settings, job: &Job) -> Result<Self> {
        Self::prune(capture, scan.static_layers(capture, settings, job)?, settings, job)
    }

    /// Prunes static layers, which need their rates yet, against each other.
    fn prune(capture: &Capture, layers: Vec<StaticLayer>, settings: &Settings, job: &Job) -> Result<Self> {
        let layers = rated(capture, layers, settings, job)?;
        let rig = Rig::new(&capture.cameras);
        let statuses = pruning::no_statuses(&layers);
        let decided = pruning::prune(&rig, &layers, &statuses, ROOT, settings, job)?;
        let statuses = statuses
            .iter()
            .map(|camera| camera.iter().map(|status| status.load(Ordering::Relaxed)).collect());
        Ok(Self { statuses: statuses.collect(), decided, layers })
    }
}

/// A layer with normals, and the pixels of its samples, ascending.
type StaticLayer = (Layer, Vec<u32>);

fn rated(capture: &Capture, layers: Vec<StaticLayer>, settings: &Settings, job: &Job) -> Result<Vec<Layer>> {
    let builder = LayerBuilder::new(settings, &capture.cameras, capture.antialiased_color);
    let rated = layers.into_par_iter().zip(&capture.cameras).map(|((mut layer, pixels), camera)| {
        job.check()?;
        builder.rate(&mut layer, camera, &pixels);
        Ok(layer)
    });
    rated.collect()
}

/// The last results that no tolerance touches, each with what it was made with: whoever looks at frame after frame, or turns
/// one threshold, pays once for what stays.
#[derive(Debug, Default)]
pub(super) struct Memo {
    static_layers: Mutex<Option<(StaticKey, Arc<Vec<StaticLayer>>)>>,
    pub(super) frame: Mutex<Option<(FrameKey, Arc<FrameLayers>)>>,
    pub(super) normal_errors: Mutex<Option<(f32, AllNormalErrors)>>,
}

type StaticKey = (NormalSettings, SpanSettings);

/// Per camera.
pub(super) type AllNormalErrors = Arc<Vec<Vec<NormalErrors>>>;

pub(super) fn remembered<K: PartialEq, V: Clone>(memo: &Mutex<Option<(K, V)>>, key: &K) -> Option<V> {
    let memo = memo.lock().ok()?;
    memo.as_ref().filter(|(made_with, _)| made_with == key).map(|(_, value)| value.clone())
}

pub(super) fn remember<K, V>(memo: &Mutex<Option<(K, V)>>, key: K, value: V) {
    if let Ok(mut memo) = memo.lock() {
        *memo = Some((key, value));
    }
}

impl TemporalScan {
    /// Every camera's static pixels under `settings`, which the scan serves, ready to be pruned.
    ///
    /// # Errors
    /// As [`Background::of`].
    pub(super) fn rated_layers(
        &self,
        capture: &Capture,
        settings: &Settings,
        job: &Job,
    ) -> Result<Vec<Layer>> {
        let layers_key = (settings.normals.clone(), settings.spans.clone());
        let layers = if let Some(layers) = remembered(&self.memo.static_layers, &layers_key) {
            layers
        } else {
            let layers = Arc::new(self.static_layers(capture, settings, job)?);
            remember(&self.memo.static_layers, layers_key, layers.clone());
            layers
        };
        rated(capture, layers.as_ref().clone(), settings, job)
    }

    /// Every camera's static pixels with normals, not rated yet: no pruning threshold touches them.
    fn static_layers(&self, capture: &Capture, settings: &Settings, job: &Job) -> Result<Vec<StaticLayer>> {
        let builder = LayerBuilder::new(settings, &capture.cameras, capture.antialiased_color);
        let of_camera = |index: usize| {
            job.check()?;
            let (camera, scan) = (&capture.cameras[index], &self.cameras[index]);
            let (width, height) = camera.intrinsics.size();
            let samples = match (&self.spans, &scan.ranges) {
                (Some(spans), _) => spans.get(index, all_frames(self.frames))?.unwrap_or_default(),
                (None, Some(ranges)) => {
                    let test = self.static_test(index, &settings.spans);
                    Arc::new(ranges.samples(&ranges.static_pixels(&settings.spans, &test)))
                }
                (None, None) => Arc::default(),
            };
            let mut layer = Layer::empty(width, height);
            layer.noise = scan.noise.clone();
            // Those of all frames are their means.
            layer.noise_share = vec![(self.frames.max(1) as f32).sqrt().recip()];
            layer.depth_step_relative = scan.depth_step_relative;
            put(&mut layer, ROOT, &samples);
            builder.estimate_normals(&mut layer, camera, &samples.pixels);
            Ok((layer, samples.pixels.clone()))
        };
        (0..self.cameras.len()).into_par_iter().map(of_camera).collect()
    }
}
