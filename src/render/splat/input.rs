//! What the surface and blend stages read, and how they divide the picture among threads.

use glam::Vec3;

use crate::job::Job;
use crate::render::geometry::{Projector, RowBand};
use crate::render::input::FrameSamples;
use crate::settings::Kernel;

/// What the surface and blend stages of one picture share.
pub(crate) struct SplatInput<'a> {
    pub(crate) frame: &'a FrameSamples<'a>,
    /// Carries each camera into the target.
    pub(crate) projectors: &'a [Projector],
    /// Reciprocal focal length of each camera: the size of its footprints at unit distance.
    pub(crate) per_footprint: &'a [f32],
    /// World-space ray of the target's corner, and its growth by column and row.
    pub(crate) rays_in_world: [Vec3; 3],
    /// Columns of the target.
    pub(crate) width: usize,
    pub(crate) kernel: Kernel,
    pub(crate) job: &'a Job,
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
