//! The kept samples of a capture as they come, an image at a time: in memory up to a bound, beyond it in a temporary file. So a
//! sequence of any length is preprocessed and stored in memory that does not grow with it.
//!
//! ```text
//! record in the file: tiles, tiles of depth, color, low halves of depth, high bytes of depth, [normals], masks of doubtful samples, [values]
//! ```

use std::cmp::Reverse;
use std::sync::Arc;

use half::f16;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::depth_plane::{DepthPlane, DepthTile};
use super::oct_normal::OctNormal;
use super::sample_set::{SampleImage, Span};
use super::spill_file::{Record, RecordPlace, SpillFile};
use super::tile::{SampleTile, TileMask};
use crate::capture::Values;
use crate::error::Result;

/// What is known of an image without its samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ImageFacts {
    /// As [`SampleImage::camera`].
    pub camera: u32,
    /// As [`SampleImage::span`].
    pub span: Span,
    /// Samples in the image.
    pub samples: usize,
    /// Tiles that hold one.
    pub tiles: usize,
    /// Doubtful samples.
    pub doubtful: usize,
    /// Bytes that the image takes in memory.
    pub bytes: usize,
}

impl ImageFacts {
    fn of(image: &SampleImage) -> Self {
        let SampleImage { camera, span, ref tiles, .. } = *image;
        let (samples, tiles, doubtful) = (image.len(), tiles.len(), image.doubtful_count());
        Self { camera, span, samples, tiles, doubtful, bytes: image.bytes() }
    }
}

/// What is kept in memory of an image in the file.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct ImageShape {
    facts: ImageFacts,
    high_bytes: usize,
    normals: bool,
    doubtful_tiles: usize,
    value_channels: usize,
}

impl Record for SampleImage {
    type RecordShape = ImageShape;

    fn bytes(&self) -> usize {
        self.bytes()
    }

    fn shape(&self) -> ImageShape {
        ImageShape {
            facts: ImageFacts::of(self),
            high_bytes: self.depth.high().len(),
            normals: self.normal.is_some(),
            doubtful_tiles: self.doubtful.len(),
            value_channels: self.values.channels(),
        }
    }

    fn planes(&self) -> Vec<&[u8]> {
        vec![
            bytemuck::cast_slice(&self.tiles),
            bytemuck::cast_slice(self.depth.tiles()),
            bytemuck::cast_slice(&self.color),
            bytemuck::cast_slice(self.depth.low()),
            self.depth.high(),
            bytemuck::cast_slice(self.normal.as_deref().unwrap_or_default()),
            bytemuck::cast_slice(&self.doubtful),
            self.values.as_bytes(),
        ]
    }

    fn read(
        &ImageShape { facts, high_bytes, normals, doubtful_tiles, value_channels }: &ImageShape,
        fill: impl FnOnce(&mut [&mut [u8]]) -> Result<()>,
    ) -> Result<Self> {
        let ImageFacts { camera, span, samples, tiles, .. } = facts;
        let mut tiles = vec![<SampleTile as bytemuck::Zeroable>::zeroed(); tiles];
        let mut depth_tiles = vec![<DepthTile as bytemuck::Zeroable>::zeroed(); tiles.len()];
        let (mut color, mut low) = (vec![[f16::ZERO; 3]; samples], vec![0; samples]);
        let (mut high, mut normal) =
            (vec![0; high_bytes], vec![OctNormal::default(); if normals { samples } else { 0 }]);
        let mut doubtful = vec![<TileMask as bytemuck::Zeroable>::zeroed(); doubtful_tiles];
        let mut values = Values::missing(value_channels, samples);
        fill(&mut [
            bytemuck::cast_slice_mut(&mut tiles),
            bytemuck::cast_slice_mut(&mut depth_tiles),
            bytemuck::cast_slice_mut(&mut color),
            bytemuck::cast_slice_mut(&mut low),
            &mut high,
            bytemuck::cast_slice_mut(&mut normal),
            bytemuck::cast_slice_mut(&mut doubtful),
            values.as_bytes_mut(),
        ])?;
        let depth = DepthPlane::of_planes(depth_tiles, low, high);
        let normal = normals.then_some(normal);
        Ok(Self { camera, span, tiles, color, depth, normal, doubtful, values })
    }
}

/// Sample images, in the order they are painted once [`ImageBuffer::sort`] was called.
#[derive(Debug)]
pub struct ImageBuffer {
    images: Vec<(ImageFacts, RecordPlace<SampleImage>)>,
    spill: SpillFile,
}

/// Images that are worked on at a time: enough for every thread, few enough to be held in memory.
const BATCH: usize = 64;

impl ImageBuffer {
    /// An empty buffer that holds at most `bound` bytes in memory.
    #[must_use]
    pub fn new(bound: usize) -> Self {
        Self { images: Vec::new(), spill: SpillFile::new(bound) }
    }

    /// Images that are in memory already, in their order.
    #[must_use]
    pub fn of(images: &[Arc<SampleImage>]) -> Self {
        let place = |image: &Arc<SampleImage>| (ImageFacts::of(image), RecordPlace::Memory(image.clone()));
        Self { images: images.iter().map(place).collect(), ..Self::new(usize::MAX) }
    }

    /// An empty buffer that holds as much in memory as this one may.
    pub(crate) fn empty_like(&self) -> Self {
        Self::new(self.spill.bound)
    }

    /// Takes an image.
    ///
    /// # Errors
    /// `Io` where the temporary file cannot be written.
    pub fn push(&mut self, image: impl Into<Arc<SampleImage>>) -> Result<()> {
        let image = image.into();
        self.images.push((ImageFacts::of(&image), self.spill.put(image)?));
        Ok(())
    }

    /// Takes an image, joined with the one of the same camera and span if there is one; no pixel is in both.
    ///
    /// # Errors
    /// As [`ImageBuffer::push`] and [`ImageBuffer::get`].
    pub(crate) fn join(&mut self, image: SampleImage) -> Result<()> {
        let same = |(facts, _): &(ImageFacts, _)| (facts.camera, facts.span) == (image.camera, image.span);
        let Some(at) = self.images.iter().position(same) else { return self.push(image) };
        let joined = self.get(at)?.joined_with(&[image]);
        self.images[at] = (ImageFacts::of(&joined), self.spill.put(joined)?);
        Ok(())
    }

    /// Puts the images into the order of [`SampleSet::images`](super::sample_set::SampleSet::images).
    pub fn sort(&mut self) {
        self.images.sort_by_key(|(image, _)| (Reverse(image.span.len()), image.span, image.camera));
    }

    /// Images.
    #[must_use]
    pub fn len(&self) -> usize {
        self.images.len()
    }

    /// Whether it is empty.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.images.is_empty()
    }

    /// What is known of every image, in order.
    pub fn facts(&self) -> impl ExactSizeIterator<Item = &ImageFacts> + Clone {
        self.images.iter().map(|(facts, _)| facts)
    }

    /// What is known of an image.
    pub(crate) fn facts_of(&self, index: usize) -> &ImageFacts {
        &self.images[index].0
    }

    /// An image, bit for bit as it was pushed.
    ///
    /// # Errors
    /// `Io` where the temporary file cannot be read.
    pub fn get(&self, index: usize) -> Result<Arc<SampleImage>> {
        self.spill.get(&self.images[index].1)
    }

    /// The images after `change`, in the same order and within the same bound.
    ///
    /// # Errors
    /// Whatever `change` gives; `Io` as [`ImageBuffer::push`] and [`ImageBuffer::get`].
    pub fn map(&self, change: impl Fn(&SampleImage) -> Result<SampleImage> + Sync) -> Result<Self> {
        let mut changed = Self::new(self.spill.bound);
        for first in (0..self.len()).step_by(BATCH) {
            let batch = (first..self.len().min(first + BATCH)).into_par_iter();
            let images: Result<Vec<_>> = batch.map(|index| change(&*self.get(index)?)).collect();
            images?.into_iter().try_for_each(|image| changed.push(image))?;
        }
        Ok(changed)
    }

    /// All images, in memory.
    ///
    /// # Errors
    /// `Io` as [`ImageBuffer::get`].
    pub fn into_images(self) -> Result<Vec<Arc<SampleImage>>> {
        (0..self.len()).map(|index| self.get(index)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::tile::TILE;

    fn image(camera: u32, start: u32, normals: bool) -> SampleImage {
        let tile = |nth: u32| SampleTile {
            tile_x: nth as u16,
            tile_y: 1,
            first: nth * TILE as u32,
            rows: std::array::from_fn(|row| u16::from(row == 3) * u16::MAX),
        };
        let tiles: Vec<SampleTile> = (0..3).map(tile).collect();
        let count = tiles.len() * TILE;
        // The second tile spans more than three bytes hold.
        let depths: Vec<f32> =
            (0..count).map(|i| if i % 40 == 20 { 0.0 } else { 0.1 + i as f32 + start as f32 }).collect();
        SampleImage {
            camera,
            span: Span { start, end: start + 2 },
            depth: DepthPlane::pack(&tiles, &depths),
            tiles,
            color: (0..count).map(|i| [f16::from_f32(i as f32), f16::NEG_ONE, f16::ONE]).collect(),
            normal: normals.then(|| (0..count).map(|i| OctNormal([i as i8, -3])).collect()),
            doubtful: (camera..2)
                .map(|tile| TileMask {
                    tile,
                    rows: std::array::from_fn(|row| u16::from(row == 3) << (start % 16)),
                })
                .collect(),
            values: Values::from_planes(&vec![(0..count).map(|i| i as f32).collect(); start as usize % 3]),
        }
    }

    #[test]
    fn images_come_back_bit_for_bit_and_in_order_from_memory_and_from_the_file() {
        let pushed: Vec<SampleImage> = (0..8).map(|n| image(n % 2, 14 - n / 2 * 2, n % 3 == 0)).collect();
        for bound in [0, 3 * pushed[0].bytes(), usize::MAX] {
            let mut buffer = ImageBuffer::new(bound);
            pushed.iter().cloned().try_for_each(|image| buffer.push(image)).unwrap();
            buffer.sort();
            let in_memory = buffer.images.iter().filter(|(_, place)| matches!(place, RecordPlace::Memory(_)));
            let bytes: usize = in_memory.map(|(facts, _)| facts.bytes).sum();
            assert!(bytes <= bound && (bound == 0 || bytes > 0), "{bytes} of {bound}");
            let facts: Vec<ImageFacts> = buffer.facts().copied().collect();
            assert!(facts.is_sorted_by_key(|image| (image.span.start, image.camera)));
            let twice =
                buffer.map(|image| Ok(SampleImage { camera: image.camera + 2, ..image.clone() })).unwrap();
            for (facts, (read, changed)) in
                facts.iter().zip(buffer.into_images().unwrap().iter().zip(twice.into_images().unwrap()))
            {
                let same = |image: &&SampleImage| (image.camera, image.span) == (facts.camera, facts.span);
                let image = pushed.iter().find(same).unwrap();
                assert_eq!(**read, *image);
                assert_eq!(ImageFacts::of(image), *facts);
                assert_eq!(*changed, SampleImage { camera: image.camera + 2, ..image.clone() });
            }
        }
    }
}
