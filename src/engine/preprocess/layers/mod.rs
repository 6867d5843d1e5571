//! Layers: one camera at one frame with everything that a comparison needs.
//!
//! A layer in a temporary file: its samples, without what is known of the camera and without footprints.
//!
//! ```text
//! level u8 …, rank u32 …, geometry 4 × f32 …, packed color 2 × u32 …, color 3 × f16 …, inverse depth f32 …, [normal 3 × f32 …] [values f32 …]
//! ```

mod builder;
mod flying_pixels;
mod layer;
mod packed_sample;
mod rated_samples;
mod sampling_rate;

use glam::Vec3;

use crate::capture::Values;
use crate::error::Result;
use crate::samples::Record;
pub(crate) use builder::LayerBuilder;
pub(crate) use layer::CameraLayer;
pub(crate) use packed_sample::{
    ABSENT_RANK, COLOR_STEPS, PackedColor, PackedGeometry, Rank, has_unknown_normal, is_blended_sky, is_mixed,
};
pub(crate) use rated_samples::{RatedSamples, SampleRun};
pub(crate) use sampling_rate::{Rate, ViewingRays, footprint};

impl CameraLayer {
    /// The planes that are put away, in the order of the file.
    pub(crate) fn planes_mut(&mut self) -> [&mut [u8]; 8] {
        [
            &mut self.level,
            bytemuck::cast_slice_mut(&mut self.ranks),
            bytemuck::cast_slice_mut(&mut self.geometry),
            bytemuck::cast_slice_mut(&mut self.packed_colors),
            bytemuck::cast_slice_mut(&mut self.color),
            bytemuck::cast_slice_mut(&mut self.inverse_depth),
            bytemuck::cast_slice_mut(&mut self.normal),
            self.values.as_bytes_mut(),
        ]
    }

    /// The planes of another layer of as many pixels, whatever they hold, with what is known of this camera.
    pub(crate) fn with_planes_of(self, other: Self) -> Self {
        let Self { noise, noise_share, depth_step_relative, noise_between, value_tolerances, .. } = self;
        Self { value_tolerances, noise, noise_share, depth_step_relative, noise_between, ..other }
    }
}

impl Record for CameraLayer {
    /// Columns, rows, whether there are normals, and channels of values.
    type RecordShape = (usize, usize, bool, usize);

    fn bytes(&self) -> usize {
        self.planes().iter().map(|plane| plane.len()).sum()
    }

    fn shape(&self) -> Self::RecordShape {
        (self.width, self.height(), !self.normal.is_empty(), self.values.channels())
    }

    fn planes(&self) -> Vec<&[u8]> {
        vec![
            &self.level,
            bytemuck::cast_slice(&self.ranks),
            bytemuck::cast_slice(&self.geometry),
            bytemuck::cast_slice(&self.packed_colors),
            bytemuck::cast_slice(&self.color),
            bytemuck::cast_slice(&self.inverse_depth),
            bytemuck::cast_slice(&self.normal),
            self.values.as_bytes(),
        ]
    }

    fn read(
        &(width, height, normals, channels): &Self::RecordShape,
        fill: impl FnOnce(&mut [&mut [u8]]) -> Result<()>,
    ) -> Result<Self> {
        let mut layer = Self::default().of_size(width, height);
        layer.normal = vec![Vec3::ZERO; if normals { width * height } else { 0 }];
        layer.values = Values::missing(channels, width * height);
        fill(&mut layer.planes_mut())?;
        Ok(layer)
    }
}
