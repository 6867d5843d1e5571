//! The samples of one camera over one span, ready to be compared with what other cameras saw.
//!
//! Purpose: samples are looked for in the layers of other cameras. Their own layer need not be there for that: of a short span it
//! holds little but samples of longer ones, and of many cameras not all layers fit into memory. Layers are put together from these
//! samples again.
//!
//! ```text
//! record in a file: pixel u32 …, rank u32 …, geometry 4 × f32 …, packed color 2 × u32 …, color 3 × f16 …, [normal 3 × f32 …] [values f32 …]
//! ```

use std::ops::Range;

use glam::Vec3;
use half::f16;

use super::layer::CameraLayer;
use super::packed_sample::{PackedColor, PackedGeometry, Rank};
use crate::capture::Values;
use crate::error::Result;
use crate::preprocess::temporal::SpanLevel;
use crate::samples::Record;
use crate::simd::LANES;

/// Pixels that are passed over at once where none has a sample of a level: most levels have few.
const RUN: usize = 64;

/// Samples of one level of a layer, in the order of their pixels.
#[derive(Clone, Debug, Default)]
pub(crate) struct RatedSamples {
    /// Columns of the picture.
    pub(crate) width: usize,
    pub(crate) level: SpanLevel,
    /// `y * width + x`, ascending.
    pub(crate) pixels: Vec<u32>,
    pub(crate) ranks: Vec<Rank>,
    pub(crate) geometry: Vec<PackedGeometry>,
    pub(crate) packed_colors: Vec<PackedColor>,
    /// Linear color.
    color: Vec<[f16; 3]>,
    /// World-space normals; empty where they are not stored.
    normal: Vec<Vec3>,
    /// Scalar values; empty where the capture has none.
    pub(crate) values: Values,
}

/// Samples within sixteen pixels of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct SampleRun {
    pub(crate) row: usize,
    /// Which sixteen columns these are.
    pub(crate) nth: usize,
    /// Which of them hold a sample.
    pub(crate) lanes: u32,
    /// Index of the first sample.
    pub(crate) first: usize,
}

impl RatedSamples {
    /// The samples of `layer` at `pixels`, ascending, which are of a level; with their normals where these are to be stored.
    pub(crate) fn of(layer: &CameraLayer, level: SpanLevel, pixels: Vec<u32>, normals: bool) -> Self {
        Self {
            width: layer.width,
            level,
            ranks: at_places(&layer.ranks, &pixels),
            geometry: at_places(&layer.geometry, &pixels),
            packed_colors: at_places(&layer.packed_colors, &pixels),
            color: at_places(&layer.color, &pixels),
            normal: if normals { at_places(&layer.normal, &pixels) } else { Vec::new() },
            values: layer.values.at_places(&pixels),
            pixels,
        }
    }

    /// All samples of a level of `layer`, without normals.
    pub(crate) fn of_level(layer: &CameraLayer, level: SpanLevel) -> Self {
        let mut pixels = Vec::new();
        for (run, levels) in layer.level.chunks(RUN).enumerate().filter(|(_, levels)| levels.contains(&level))
        {
            let found = levels.iter().enumerate().filter(|(_, found)| **found == level);
            pixels.extend(found.map(|(at, _)| (run * RUN + at) as u32));
        }
        Self::of(layer, level, pixels, false)
    }

    /// Those at some places, ascending, without colors and normals.
    pub(crate) fn at(&self, places: &[u32]) -> Self {
        Self {
            width: self.width,
            level: self.level,
            pixels: at_places(&self.pixels, places),
            ranks: at_places(&self.ranks, places),
            geometry: at_places(&self.geometry, places),
            packed_colors: at_places(&self.packed_colors, places),
            values: self.values.at_places(places),
            ..Self::default()
        }
    }

    /// Puts the samples into a layer of the same camera.
    pub(crate) fn put_into(&self, layer: &mut CameraLayer) {
        for (index, &pixel) in self.pixels.iter().enumerate() {
            let pixel = pixel as usize;
            layer.level[pixel] = self.level;
            layer.color[pixel] = self.color[index];
            layer.inverse_depth[pixel] = self.geometry[index].inverse_depth;
            layer.ranks[pixel] = self.ranks[index];
            layer.geometry[pixel] = self.geometry[index];
            layer.packed_colors[pixel] = self.packed_colors[index];
            layer.values.put(pixel, self.values.of(index));
        }
        for (&pixel, normal) in self.pixels.iter().zip(&self.normal) {
            layer.normal[pixel as usize] = *normal;
        }
    }

    /// Samples.
    pub(crate) fn len(&self) -> usize {
        self.pixels.len()
    }

    /// The samples of some rows, as a range of indices.
    pub(crate) fn within_rows(&self, rows: Range<usize>) -> Range<usize> {
        let before = |row: usize| self.pixels.partition_point(|pixel| (*pixel as usize) < row * self.width);
        before(rows.start)..before(rows.end)
    }

    /// A range of samples, by sixteen pixels of a row.
    pub(crate) fn runs(&self, range: Range<usize>) -> Vec<SampleRun> {
        let mut runs = Vec::with_capacity(range.len() / LANES + 1);
        let mut next = range.start;
        while next < range.end {
            let pixel = self.pixels[next] as usize;
            let (row, nth) = (pixel / self.width, pixel % self.width / LANES);
            let begin = row * self.width + nth * LANES;
            let end = (begin + LANES).min((row + 1) * self.width);
            let (first, mut lanes) = (next, 0);
            while let Some(&pixel) =
                self.pixels[..range.end].get(next).filter(|pixel| (**pixel as usize) < end)
            {
                lanes |= 1 << (pixel as usize - begin);
                next += 1;
            }
            runs.push(SampleRun { row, nth, lanes, first });
        }
        runs
    }
}

fn at_places<T: Copy>(plane: &[T], places: &[u32]) -> Vec<T> {
    places.iter().map(|place| plane[*place as usize]).collect()
}

impl Record for RatedSamples {
    /// Columns, level, samples, whether they have normals, and channels of values.
    type RecordShape = (usize, SpanLevel, usize, bool, usize);

    fn bytes(&self) -> usize {
        self.planes().iter().map(|plane| plane.len()).sum()
    }

    fn shape(&self) -> Self::RecordShape {
        (self.width, self.level, self.len(), !self.normal.is_empty(), self.values.channels())
    }

    fn planes(&self) -> Vec<&[u8]> {
        vec![
            bytemuck::cast_slice(&self.pixels),
            bytemuck::cast_slice(&self.ranks),
            bytemuck::cast_slice(&self.geometry),
            bytemuck::cast_slice(&self.packed_colors),
            bytemuck::cast_slice(&self.color),
            bytemuck::cast_slice(&self.normal),
            self.values.as_bytes(),
        ]
    }

    fn read(
        &(width, level, count, normals, channels): &Self::RecordShape,
        fill: impl FnOnce(&mut [&mut [u8]]) -> Result<()>,
    ) -> Result<Self> {
        let mut read = Self {
            width,
            level,
            pixels: vec![0; count],
            ranks: vec![0; count],
            geometry: vec![PackedGeometry::ABSENT; count],
            packed_colors: vec![PackedColor::ABSENT; count],
            color: vec![[f16::ZERO; 3]; count],
            normal: vec![Vec3::ZERO; if normals { count } else { 0 }],
            values: Values::missing(channels, count),
        };
        fill(&mut [
            bytemuck::cast_slice_mut(&mut read.pixels),
            bytemuck::cast_slice_mut(&mut read.ranks),
            bytemuck::cast_slice_mut(&mut read.geometry),
            bytemuck::cast_slice_mut(&mut read.packed_colors),
            bytemuck::cast_slice_mut(&mut read.color),
            bytemuck::cast_slice_mut(&mut read.normal),
            read.values.as_bytes_mut(),
        ])?;
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_cut_into_runs_of_sixteen_pixels_that_end_with_the_row() {
        let pixels = vec![0, 15, 16, 19, 20, 35, 40];
        let samples = RatedSamples { width: 20, pixels, ..RatedSamples::default() };
        let run = |row, nth, lanes, first| SampleRun { row, nth, lanes, first };
        let all =
            [run(0, 0, 1 | 1 << 15, 0), run(0, 1, 1 | 1 << 3, 2), run(1, 0, 1 | 1 << 15, 4), run(2, 0, 1, 6)];
        assert_eq!(samples.runs(0..7), all);
        assert_eq!(samples.within_rows(1..2), 4..6);
        assert_eq!(samples.runs(4..6), all[2..3]);
    }
}
