//! What is known of the pixels of a span, as a file of a part holds it.

use super::pixel_stats::SpanSums;
use super::value_ranges::ValueRanges;
use crate::error::Result;
use crate::samples::Record;

impl Record for SpanSums {
    /// Frames, pixels, whether there are normals, and channels of values.
    type RecordShape = (u32, usize, bool, usize);

    fn bytes(&self) -> usize {
        self.planes().iter().map(|plane| plane.len()).sum()
    }

    fn shape(&self) -> (u32, usize, bool, usize) {
        (self.frames, self.pixels(), !self.normal.is_empty(), self.values.first.channels())
    }

    fn planes(&self) -> Vec<&[u8]> {
        vec![
            bytemuck::cast_slice(&self.is_open),
            bytemuck::cast_slice(&self.min_color),
            bytemuck::cast_slice(&self.max_color),
            bytemuck::cast_slice(&self.color),
            bytemuck::cast_slice(&self.min_inverse_depth),
            bytemuck::cast_slice(&self.max_inverse_depth),
            bytemuck::cast_slice(&self.inverse_depth),
            bytemuck::cast_slice(&self.normal),
            self.values.low.as_bytes(),
            self.values.high.as_bytes(),
            self.values.first.as_bytes(),
        ]
    }

    fn read(
        &(frames, pixels, normals, channels): &(u32, usize, bool, usize),
        fill: impl FnOnce(&mut [&mut [u8]]) -> Result<()>,
    ) -> Result<Self> {
        let mut is_open = vec![0_u8; pixels];
        let mut sums = Self {
            frames,
            is_open: Vec::new(),
            min_color: vec![0; 3 * pixels],
            max_color: vec![0; 3 * pixels],
            color: vec![0.0; 3 * pixels],
            min_inverse_depth: vec![0.0; pixels],
            max_inverse_depth: vec![0.0; pixels],
            inverse_depth: vec![0.0; pixels],
            normal: vec![0.0; if normals { 3 * pixels } else { 0 }],
            values: ValueRanges::missing(channels, pixels),
        };
        fill(&mut [
            &mut is_open,
            bytemuck::cast_slice_mut(&mut sums.min_color),
            bytemuck::cast_slice_mut(&mut sums.max_color),
            bytemuck::cast_slice_mut(&mut sums.color),
            bytemuck::cast_slice_mut(&mut sums.min_inverse_depth),
            bytemuck::cast_slice_mut(&mut sums.max_inverse_depth),
            bytemuck::cast_slice_mut(&mut sums.inverse_depth),
            bytemuck::cast_slice_mut(&mut sums.normal),
            sums.values.low.as_bytes_mut(),
            sums.values.high.as_bytes_mut(),
            sums.values.first.as_bytes_mut(),
        ])?;
        sums.is_open = is_open.into_iter().map(|open| open != 0).collect();
        Ok(sums)
    }
}
