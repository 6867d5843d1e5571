//! The foreground of one frame: every pixel that is not background, pruned against the other cameras' foreground of the
//! same frame and against the background.

use std::sync::Arc;
use std::sync::atomic::AtomicU8;

use glam::Vec3;
use rayon::prelude::*;

use super::background::Background;
use super::layer::{Layer, LayerBuilder, Level, NO_SAMPLE};
use super::pruning::{self, Decided, Rig, Statuses};
use crate::capture::{Capture, Frame};
use crate::error::Result;
use crate::job::Job;
use crate::settings::Settings;

/// The level of samples of one frame.
pub const FRAME: Level = 1;

/// All cameras at one frame, pruned.
pub struct PrunedFrame {
    /// The recorded pictures.
    pub frames: Vec<Arc<Frame>>,
    /// Background and foreground together, per camera.
    pub layers: Vec<Layer>,
    /// The verdicts on foreground samples.
    pub decided: Vec<Decided>,
}

/// Loads, completes and prunes one frame.
///
/// # Errors
/// Whatever the capture gives (naming file and frame), and `Cancelled`.
pub fn prune_frame(
    capture: &Capture,
    rig: &Rig<'_>,
    background: &Background,
    settings: &Settings,
    frame: usize,
    job: &Job,
) -> Result<PrunedFrame> {
    let builder = LayerBuilder::new(settings, &capture.cameras, capture.antialiased_color);
    let loaded: Vec<(Arc<Frame>, Layer)> = (0..capture.cameras.len())
        .into_par_iter()
        .map(|camera| {
            job.check()?;
            let recorded = capture.frame(camera, frame)?;
            let mut layer = background.layers[camera].clone();
            overlay(&mut layer, &recorded);
            builder.estimate_normals(&mut layer, &capture.cameras[camera], FRAME);
            builder.rate(&mut layer, &capture.cameras[camera], FRAME);
            Ok((recorded, layer))
        })
        .collect::<Result<_>>()?;
    let (frames, layers): (Vec<_>, Vec<_>) = loaded.into_iter().unzip();
    let statuses: Statuses = background
        .statuses
        .par_iter()
        .map(|camera| camera.iter().map(|&status| AtomicU8::new(status)).collect())
        .collect();
    let decided = pruning::prune(rig, &layers, &statuses, FRAME, settings, job)?;
    Ok(PrunedFrame { frames, layers, decided })
}

/// Puts the frame's samples wherever the background has none.
fn overlay(layer: &mut Layer, frame: &Frame) {
    layer.depth_step_relative = layer.depth_step_relative.max(frame.depth_step_relative);
    layer.noise_share = vec![0.0, 1.0];
    for pixel in 0..layer.level.len() {
        let inverse_depth = frame.inverse_depth.as_slice()[pixel];
        if layer.level[pixel] != NO_SAMPLE || inverse_depth < 0.0 {
            continue;
        }
        layer.level[pixel] = FRAME;
        layer.inverse_depth[pixel] = inverse_depth;
        layer.color[pixel] = frame.color.as_slice()[pixel];
        if let Some(normals) = &frame.normal_in_world {
            layer.normal[pixel] = Vec3::from(normals.as_slice()[pixel]);
        }
    }
}
