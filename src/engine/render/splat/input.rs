//! What the stages of one picture read, and how they divide the picture among threads.

use glam::Vec3;

use crate::capture::Camera;
use crate::job::Job;
use crate::render::geometry::{Projector, RowBand, rays_in_world};
use crate::render::input::FrameSamples;
use crate::render::input::{RelativeWidth, focal};
use crate::settings::{Kernel, RenderSettings};

/// What the stages of one picture share.
pub(crate) struct StageInput<'a> {
    pub(crate) frame: &'a FrameSamples<'a>,
    /// Carries each camera into the target.
    pub(crate) projectors: Vec<Projector>,
    /// The size of the footprints of each camera, relative to the distance.
    pub(super) per_footprint: Vec<RelativeWidth>,
    /// World-space ray of the target's corner, and its growth by column and row.
    pub(super) rays_in_world: [Vec3; 3],
    /// Columns of the target.
    pub(crate) width: usize,
    /// Inverse depths from this share of the nearest one on belong to the same surface.
    pub(crate) surface_ratio: f32,
    pub(crate) kernel: Kernel,
    pub(crate) job: &'a Job,
}

impl<'a> StageInput<'a> {
    /// For the samples of `frame`, seen by `target`.
    pub(crate) fn new(
        frame: &'a FrameSamples<'a>,
        target: &Camera,
        settings: &RenderSettings,
        job: &'a Job,
    ) -> Self {
        let cameras = &frame.set.cameras;
        Self {
            frame,
            projectors: cameras.iter().map(|camera| Projector::new(camera, target)).collect(),
            per_footprint: cameras.iter().map(|camera| RelativeWidth::of(1.0, camera)).collect(),
            rays_in_world: rays_in_world(target, 0.0),
            width: target.intrinsics.size().0,
            surface_ratio: 1.0 / (1.0 + settings.depth_tolerance / focal(target)),
            kernel: settings.kernel,
            job,
        }
    }

    /// Whether the kernel blends the samples of a surface.
    pub(crate) fn blends(&self) -> bool {
        matches!(self.kernel, Kernel::Block | Kernel::Surfel)
    }
}

/// Cuts a buffer of `width` columns into the rows of each band; bands ascend.
pub(super) fn split_at_bands<'a, 'b, T>(
    bands: &'a [RowBand],
    width: usize,
    buffer: &'b mut [T],
) -> Vec<(&'a RowBand, &'b mut [T])> {
    let (mut rest, mut row) = (buffer, 0);
    let mut parts = Vec::with_capacity(bands.len());
    for band in bands {
        let (_, from) = rest.split_at_mut((band.rows.start - row) * width);
        let (part, after) = from.split_at_mut(band.rows.len() * width);
        parts.push((band, part));
        (rest, row) = (after, band.rows.end);
    }
    parts
}
