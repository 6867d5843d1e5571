//! The samples of one camera over one span before pruning: a sparse picture. There are many of them. Beyond a bound of memory
//! they wait in a temporary file, as kept samples do ([`crate::samples`]).
//!
//! ```text
//! record in the file: pixel u32 …, inverse depth f32 …, [normal 3 × f32 …,] color 3 × f16 … [values f32 …]    machine's byte order
//! ```

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::Vec3;
use half::f16;

use crate::capture::Values;
use crate::error::Result;
use crate::samples::{Record, RecordPlace, Span, SpillFile};

/// Samples with their pixels, in ascending order of the pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpanSamples {
    /// `y * width + x`, ascending.
    pub pixels: Vec<u32>,
    /// Linear color, one per pixel.
    pub color: Vec<[f16; 3]>,
    /// 1/z, one per pixel; 0 at infinity, never negative.
    pub inverse_depth: Vec<f32>,
    /// Given world-space normals, one per pixel (zero if not given); empty if the capture gives none.
    pub normal: Vec<Vec3>,
    /// Scalar values, those of the span's first frame; empty if the capture gives none.
    pub values: Values,
}

impl SpanSamples {
    /// Samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.pixels.len()
    }

    /// Whether there are no samples.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.pixels.is_empty()
    }

    /// No samples, with room for `count` of them, without normals.
    pub(crate) fn with_capacity(count: usize) -> Self {
        Self {
            pixels: Vec::with_capacity(count),
            color: Vec::with_capacity(count),
            inverse_depth: Vec::with_capacity(count),
            normal: Vec::new(),
            values: Values::default(),
        }
    }

    /// Adds samples of later pixels.
    pub fn extend(&mut self, later: &Self) {
        self.pixels.extend_from_slice(&later.pixels);
        self.color.extend_from_slice(&later.color);
        self.inverse_depth.extend_from_slice(&later.inverse_depth);
        self.normal.extend_from_slice(&later.normal);
        self.values.extend(&later.values);
    }

    /// Makes room for more samples, without normals.
    pub(crate) fn reserve(&mut self, count: usize) {
        self.pixels.reserve_exact(count);
        self.color.reserve_exact(count);
        self.inverse_depth.reserve_exact(count);
    }
}

/// Bytes of a sample without its normal.
const SAMPLE_BYTES: usize = size_of::<u32>() + size_of::<[f16; 3]>() + size_of::<f32>();

impl Record for SpanSamples {
    /// Samples, whether they have normals, and how many channels of values.
    type RecordShape = (usize, bool, usize);

    fn bytes(&self) -> usize {
        self.len() * SAMPLE_BYTES + size_of_val(self.normal.as_slice()) + self.values.bytes()
    }

    fn shape(&self) -> (usize, bool, usize) {
        (self.len(), !self.normal.is_empty(), self.values.channels())
    }

    fn planes(&self) -> Vec<&[u8]> {
        vec![
            bytemuck::cast_slice(&self.pixels),
            bytemuck::cast_slice(&self.inverse_depth),
            bytemuck::cast_slice(&self.normal),
            bytemuck::cast_slice(&self.color),
            self.values.as_bytes(),
        ]
    }

    fn read(
        &(samples, normals, channels): &(usize, bool, usize),
        fill: impl FnOnce(&mut [&mut [u8]]) -> Result<()>,
    ) -> Result<Self> {
        let mut read = Self {
            pixels: vec![0; samples],
            color: vec![[f16::ZERO; 3]; samples],
            inverse_depth: vec![0.0; samples],
            normal: vec![Vec3::ZERO; if normals { samples } else { 0 }],
            values: Values::missing(channels, samples),
        };
        fill(&mut [
            bytemuck::cast_slice_mut(&mut read.pixels),
            bytemuck::cast_slice_mut(&mut read.inverse_depth),
            bytemuck::cast_slice_mut(&mut read.normal),
            bytemuck::cast_slice_mut(&mut read.color),
            read.values.as_bytes_mut(),
        ])?;
        Ok(read)
    }
}

/// The samples of every camera and span.
#[derive(Debug)]
pub struct SpanStore {
    places: BTreeMap<(usize, Span), RecordPlace<SpanSamples>>,
    spill: SpillFile,
}

impl SpanStore {
    /// An empty store that holds at most `bound` bytes in memory.
    pub(crate) fn new(bound: usize) -> Self {
        Self { places: BTreeMap::new(), spill: SpillFile::new(bound) }
    }

    /// Takes the samples of `camera` over `span`.
    ///
    /// # Errors
    /// `Io` where the temporary file cannot be written.
    pub fn insert(&mut self, camera: usize, span: Span, samples: SpanSamples) -> Result<()> {
        if !samples.is_empty() {
            self.places.insert((camera, span), self.spill.put(samples)?);
        }
        Ok(())
    }

    /// The cameras and spans that have samples, in order.
    pub(crate) fn spans(&self) -> Vec<(usize, Span)> {
        self.places.keys().copied().collect()
    }

    /// The samples of `camera` over `span`; `None` if it has none.
    ///
    /// # Errors
    /// `Io` where the temporary file cannot be read.
    pub fn get(&self, camera: usize, span: Span) -> Result<Option<Arc<SpanSamples>>> {
        self.places.get(&(camera, span)).map(|place| self.spill.get(place)).transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(seed: u32, normals: bool) -> SpanSamples {
        let pixels: Vec<u32> = (0..40).map(|i| i * 7 + seed).collect();
        SpanSamples {
            color: pixels.iter().map(|p| [f16::from_f32(*p as f32 / 64.0); 3]).collect(),
            inverse_depth: pixels.iter().map(|p| 1.0 / (1.0 + *p as f32)).collect(),
            normal: pixels.iter().filter(|_| normals).map(|p| Vec3::X * *p as f32).collect(),
            values: Values::from_planes(&vec![pixels.iter().map(|p| *p as f32).collect(); seed as usize % 3]),
            pixels,
        }
    }

    #[test]
    fn samples_come_back_bit_for_bit_from_memory_and_from_the_file() {
        for bound in [0, 1000, usize::MAX] {
            let mut store = SpanStore::new(bound);
            let span = |start| Span { start, end: start + 2 };
            for n in 0..6 {
                store.insert(n as usize % 2, span(n), samples(n, n % 3 == 0)).unwrap();
            }
            for n in 0..6 {
                let read = store.get(n as usize % 2, span(n)).unwrap().unwrap();
                assert_eq!(*read, samples(n, n % 3 == 0));
            }
            assert_eq!(store.get(1, span(0)).unwrap(), None);
        }
    }
}
