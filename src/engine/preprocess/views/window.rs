//! The layers of those views that are worked on, made when they are needed.

use std::sync::Arc;

use rayon::prelude::*;

use super::neighborhoods::{ViewGroup, groups};
use super::recording::Views;
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::agreement::SmoothDepths;
use crate::preprocess::layers::{CameraLayer, KnownMixed, LayerBuilder};
use crate::preprocess::noise::NoiseBetween;
use crate::preprocess::pruning::static_layer;
use crate::preprocess::registration::CameraPairs;
use crate::preprocess::temporal::ROOT;

/// Bytes of a pixel in a layer of this window, without its normal: color, inverse depth, rank, geometry, packed color, level, and
/// the smoothed depth.
const PIXEL_BYTES: usize = 6 + 4 + 4 + 16 + 8 + 1 + 4;
const NORMAL_BYTES: usize = 12;

/// Layers of some views; those of all others are empty, and take part in nothing.
pub(super) struct LayerWindow<'a> {
    views: Views<'a>,
    builder: LayerBuilder<'a>,
    noise: Vec<Option<Arc<NoiseBetween>>>,
    /// Mixed pixels of those that were given up.
    mixed: Vec<Option<KnownMixed>>,
    pub(super) layers: Vec<CameraLayer>,
    /// Depths of these layers.
    pub(super) smooth: Arc<SmoothDepths>,
    /// Per view, when it was last needed; 0 if its layer is not held.
    used: Vec<u64>,
    turn: u64,
    /// Bytes that layers may take: what the recording gives them, or what the largest group so far took.
    bound: usize,
}

impl<'a> LayerWindow<'a> {
    /// No layer is held yet.
    pub(super) fn new(views: Views<'a>, pairs: &CameraPairs<'_>) -> Self {
        let Views { capture, settings, .. } = views;
        let count = capture.cameras.len();
        Self {
            views,
            builder: LayerBuilder::new(settings, &capture.cameras, capture.antialiased_color),
            noise: vec![None; count],
            mixed: vec![None; count],
            layers: (0..count).map(|_| CameraLayer::empty(0, 0)).collect(),
            smooth: Arc::new(SmoothDepths::new(pairs, ROOT)),
            used: vec![0; count],
            turn: 0,
            bound: views.bound,
        }
    }

    /// The noise that layers have from now on, those that are held as well.
    pub(super) fn set_noise(&mut self, noise: Vec<Option<Arc<NoiseBetween>>>) {
        let held = self.layers.iter_mut().zip(&noise).zip(&self.used).filter(|(_, used)| **used > 0);
        held.for_each(|((layer, noise), _)| layer.noise_between.clone_from(noise));
        self.noise = noise;
    }

    /// The largest standard deviation of depth between views, relative; 0 where depth is not noisy.
    pub(super) fn most_noise(&self) -> f32 {
        self.noise.iter().flatten().flat_map(|noise| noise.depth_relative).fold(0.0, f32::max)
    }

    /// Cuts an order of views into groups that fit, each with the others that matter to its views.
    pub(super) fn groups<I: Iterator<Item = usize>>(
        &mut self,
        order: &[usize],
        others: impl Fn(usize) -> I,
    ) -> Vec<ViewGroup> {
        let groups = groups(order, |camera| self.bytes(camera), self.bound, others);
        let of_group = |group: &ViewGroup| group.held.iter().map(|camera| self.bytes(*camera)).sum();
        self.bound = groups.iter().map(of_group).fold(self.bound, usize::max);
        groups
    }

    fn bytes(&self, camera: usize) -> usize {
        let normals = if self.views.settings.store.normals { NORMAL_BYTES } else { 0 };
        self.views.capture.cameras[camera].intrinsics.pixel_count() * (PIXEL_BYTES + normals)
    }

    /// Makes those layers that are not held yet. Others are given up where all together would take too much, first those that were
    /// not asked for the longest.
    ///
    /// # Errors
    /// `Io` where the temporary file cannot be read, and `Cancelled`.
    pub(super) fn hold(&mut self, cameras: &[usize], job: &Job) -> Result<()> {
        self.turn += 1;
        let missing: Vec<usize> = cameras.iter().copied().filter(|camera| self.used[*camera] == 0).collect();
        for camera in cameras {
            self.used[*camera] = self.turn;
        }
        self.give_up_for(&missing);
        let made = missing.par_iter().map(|&camera| {
            job.check()?;
            self.layer(camera)
        });
        let made: Vec<CameraLayer> = made.collect::<Result<_>>()?;
        missing.into_iter().zip(made).for_each(|(camera, layer)| self.layers[camera] = layer);
        Ok(())
    }

    fn give_up_for(&mut self, missing: &[usize]) {
        let mut bytes: usize = missing.iter().map(|camera| self.bytes(*camera)).sum();
        let is_held = |camera: &usize| !self.layers[*camera].geometry.is_empty();
        let mut held: Vec<usize> = (0..self.layers.len()).filter(is_held).collect();
        bytes += held.iter().map(|camera| self.bytes(*camera)).sum::<usize>();
        held.retain(|camera| self.used[*camera] < self.turn);
        held.sort_by_key(|camera| self.used[*camera]);
        for camera in held {
            if bytes <= self.bound {
                break;
            }
            bytes -= self.bytes(camera);
            let layer = std::mem::replace(&mut self.layers[camera], CameraLayer::empty(0, 0));
            self.mixed[camera].get_or_insert_with(|| KnownMixed::of(&layer));
            self.used[camera] = 0;
            if let Some(smooth) = Arc::get_mut(&mut self.smooth) {
                smooth.forget(camera);
            }
        }
    }

    fn layer(&self, index: usize) -> Result<CameraLayer> {
        let Views { capture, scan, settings, .. } = self.views;
        let (mut layer, pixels) = static_layer(&self.builder, capture, scan, settings, index)?;
        let known = self.mixed[index].as_ref();
        self.builder.rate_with(&mut layer, &capture.cameras[index], &pixels, known);
        layer.noise_between.clone_from(&self.noise[index]);
        // Nothing reads these any more.
        layer.footprint = Vec::new();
        if !settings.store.normals {
            layer.normal = Vec::new();
        }
        Ok(layer)
    }
}
