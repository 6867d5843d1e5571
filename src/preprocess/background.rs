//! The background: every camera's static pixels, pruned against each other once for all frames.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use glam::Vec3;

use super::PixelClass;
use super::layer::{Layer, LayerBuilder};
use super::pruning::{self, Decided, Rig};
use super::temporal::{CameraScan, TemporalScan};
use crate::capture::Capture;
use crate::error::Result;
use crate::job::Job;
use crate::settings::{CaptureSettings, RenderSettings, Settings, StoreSettings};

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
            statuses: layers.iter().map(|layer| vec![pruning::ABSENT; layer.class.len()]).collect(),
            decided: layers.iter().map(|_| Decided::default()).collect(),
            layers,
        }
    }

    fn new(capture: &Capture, scan: &TemporalScan, settings: &Settings, job: &Job) -> Result<Self> {
        let builder = LayerBuilder::new(settings, &capture.cameras, capture.antialiased_color);
        let mut layers = Vec::with_capacity(capture.cameras.len());
        for (camera, scan_of_camera) in capture.cameras.iter().zip(&scan.cameras) {
            job.check()?;
            let is_static = scan_of_camera.static_pixels(&settings.spans, scan.frames);
            let mut layer = static_layer(scan_of_camera, &is_static);
            builder.complete(&mut layer, camera, |class| class == PixelClass::Background);
            layers.push(layer);
        }
        let rig = Rig::new(&capture.cameras);
        let statuses = pruning::no_statuses(&layers);
        let decided = pruning::prune(&rig, &layers, &statuses, PixelClass::Background, settings, job)?;
        let statuses = statuses
            .iter()
            .map(|camera| camera.iter().map(|status| status.load(Ordering::Relaxed)).collect());
        Ok(Self { statuses: statuses.collect(), decided, layers })
    }
}

fn static_layer(scan: &CameraScan, is_static: &[bool]) -> Layer {
    let (width, height) = scan.mean_color.size();
    let mut layer = Layer::empty(width, height);
    layer.noise = scan.noise.clone();
    layer.depth_step_relative = scan.depth_step_relative;
    for (pixel, _) in is_static.iter().enumerate().filter(|(_, is_static)| **is_static) {
        layer.class[pixel] = PixelClass::Background;
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
        if let Ok(memo) = self.background.lock()
            && let Some((made_with, background)) = memo.as_ref()
            && *made_with == key
        {
            return Ok(background.clone());
        }
        let background = Arc::new(Background::new(capture, self, settings, job)?);
        if let Ok(mut memo) = self.background.lock() {
            *memo = Some((key, background.clone()));
        }
        Ok(background)
    }
}
