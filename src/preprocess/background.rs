//! The background: every camera's static pixels, pruned against each other once for all frames.

use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};

use glam::Vec3;

use super::layer::{Layer, LayerBuilder, ROOT};
use super::pruning::{self, Decided, Rig};
use super::temporal::{CameraScan, TemporalScan};
use crate::capture::Capture;
use crate::error::Result;
use crate::job::Job;
use crate::settings::{
    CaptureSettings, NormalSettings, RenderSettings, Settings, SpanSettings, StoreSettings,
};

/// Static pixels of all cameras with their verdicts.
#[derive(Debug)]
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
        let layers: Vec<Layer> = capture
            .cameras
            .iter()
            .map(|camera| {
                let (width, height) = camera.intrinsics.size();
                Layer::empty(width, height)
            })
            .collect();
        Self {
            statuses: layers.iter().map(|layer| vec![pruning::ABSENT; layer.level.len()]).collect(),
            decided: layers.iter().map(|_| Decided::default()).collect(),
            layers,
        }
    }

    /// Prunes static layers, which need their rates yet, against each other.
    fn prune(capture: &Capture, mut layers: Vec<Layer>, settings: &Settings, job: &Job) -> Result<Self> {
        let builder = LayerBuilder::new(settings, &capture.cameras, capture.antialiased_color);
        for (layer, camera) in layers.iter_mut().zip(&capture.cameras) {
            job.check()?;
            builder.rate(layer, camera, ROOT);
        }
        let rig = Rig::new(&capture.cameras);
        let statuses = pruning::no_statuses(&layers);
        let decided = pruning::prune(&rig, &layers, &statuses, ROOT, settings, job)?;
        let statuses = statuses
            .iter()
            .map(|camera| camera.iter().map(|status| status.load(Ordering::Relaxed)).collect());
        Ok(Self { statuses: statuses.collect(), decided, layers })
    }
}

/// The last results that depend on settings but on no frame, each with the settings it was made with: whoever looks at
/// frame after frame, or turns one threshold, pays once for what stays.
#[derive(Debug, Default)]
pub(super) struct Memo {
    static_layers: Mutex<Option<(StaticKey, Arc<Vec<Layer>>)>>,
    background: Mutex<Option<(Settings, Arc<Background>)>>,
}

type StaticKey = (NormalSettings, SpanSettings);

fn remembered<K: PartialEq, V: Clone>(memo: &Mutex<Option<(K, V)>>, key: &K) -> Option<V> {
    let memo = memo.lock().ok()?;
    memo.as_ref().filter(|(made_with, _)| made_with == key).map(|(_, value)| value.clone())
}

fn remember<K, V>(memo: &Mutex<Option<(K, V)>>, key: K, value: V) {
    if let Ok(mut memo) = memo.lock() {
        *memo = Some((key, value));
    }
}

fn static_layer(scan: &CameraScan, is_static: &[bool]) -> Layer {
    let (width, height) = scan.mean_color.size();
    let mut layer = Layer::empty(width, height);
    layer.noise = scan.noise.clone();
    layer.depth_step_relative = scan.depth_step_relative;
    for (pixel, _) in is_static.iter().enumerate().filter(|(_, is_static)| **is_static) {
        layer.level[pixel] = ROOT;
        layer.color[pixel] = scan.mean_color.as_slice()[pixel];
        layer.inverse_depth[pixel] = scan.mean_inverse_depth.as_slice()[pixel];
        if let Some(normals) = &scan.mean_normal {
            layer.normal[pixel] = Vec3::from(normals.as_slice()[pixel]);
        }
    }
    layer
}

impl TemporalScan {
    /// The pruned background under `settings`; computed once for as long as the settings stay.
    ///
    /// # Errors
    /// `Cancelled`.
    pub fn background(&self, capture: &Capture, settings: &Settings, job: &Job) -> Result<Arc<Background>> {
        // What is done with the samples later does not change them.
        let key = Settings {
            store: StoreSettings::default(),
            render: RenderSettings::default(),
            capture: CaptureSettings::default(),
            ..settings.clone()
        };
        if let Some(background) = remembered(&self.memo.background, &key) {
            return Ok(background);
        }
        let layers = self.static_layers(capture, settings, job)?;
        let background = Arc::new(Background::prune(capture, layers.as_ref().clone(), settings, job)?);
        remember(&self.memo.background, key, background.clone());
        Ok(background)
    }

    /// Every camera's static pixels with normals, not rated yet: no pruning threshold touches them.
    fn static_layers(&self, capture: &Capture, settings: &Settings, job: &Job) -> Result<Arc<Vec<Layer>>> {
        let key = (settings.normals.clone(), settings.spans.clone());
        if let Some(layers) = remembered(&self.memo.static_layers, &key) {
            return Ok(layers);
        }
        let builder = LayerBuilder::new(settings, &capture.cameras, capture.antialiased_color);
        let mut layers = Vec::with_capacity(capture.cameras.len());
        for (camera, scan) in capture.cameras.iter().zip(&self.cameras) {
            job.check()?;
            let mut layer = static_layer(scan, &scan.static_pixels(&settings.spans, self.frames));
            builder.estimate_normals(&mut layer, camera, ROOT);
            layers.push(layer);
        }
        let layers = Arc::new(layers);
        remember(&self.memo.static_layers, key, layers.clone());
        Ok(layers)
    }
}
