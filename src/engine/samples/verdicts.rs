//! What became of every pixel that had a sample, span by span: for each the number of a rule, and the camera that stands for it. As
//! samples, verdicts wait in memory up to a bound, and beyond it in a temporary file.

use std::cmp::Reverse;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::sample_set::Span;
use super::spill_file::{Record, RecordPlace, SpillFile};
use crate::error::Result;

/// What became of one pixel over one span.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PixelVerdict {
    /// The number of the rule that decided, as stores have it; 0 where the pixel has no sample.
    pub rule: u8,
    /// The camera whose kept sample stands for it; [`PixelVerdict::NO_WITNESS`] without one.
    pub witness: u16,
}

impl PixelVerdict {
    /// In place of a camera where no sample of another stands for the pixel.
    pub const NO_WITNESS: u16 = u16::MAX;
    /// No sample.
    pub const NONE: Self = Self { rule: 0, witness: Self::NO_WITNESS };
}

/// The verdicts on one camera's samples over one span.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SpanVerdicts {
    /// Index of the camera.
    pub camera: u32,
    /// The frames.
    pub span: Span,
    /// Pixels with a sample, `y * width + x`, ascending.
    pub pixels: Vec<u32>,
    /// One rule per pixel, as [`PixelVerdict::rule`].
    pub rules: Vec<u8>,
    /// One camera per pixel, as [`PixelVerdict::witness`].
    pub witnesses: Vec<u16>,
}

/// What is kept in memory of verdicts in the file.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct VerdictShape {
    camera: u32,
    span: Span,
    pixels: usize,
}

impl Record for SpanVerdicts {
    type RecordShape = VerdictShape;

    fn bytes(&self) -> usize {
        self.pixels.len() * (size_of::<u32>() + size_of::<u8>() + size_of::<u16>())
    }

    fn shape(&self) -> VerdictShape {
        VerdictShape { camera: self.camera, span: self.span, pixels: self.pixels.len() }
    }

    fn planes(&self) -> Vec<&[u8]> {
        vec![bytemuck::cast_slice(&self.pixels), &self.rules, bytemuck::cast_slice(&self.witnesses)]
    }

    fn read(
        &VerdictShape { camera, span, pixels }: &VerdictShape,
        fill: impl FnOnce(&mut [&mut [u8]]) -> Result<()>,
    ) -> Result<Self> {
        let mut read = Self {
            camera,
            span,
            pixels: vec![0; pixels],
            rules: vec![0; pixels],
            witnesses: vec![0; pixels],
        };
        fill(&mut [
            bytemuck::cast_slice_mut(&mut read.pixels),
            &mut read.rules,
            bytemuck::cast_slice_mut(&mut read.witnesses),
        ])?;
        Ok(read)
    }
}

/// The verdicts of all cameras and spans.
#[derive(Debug)]
pub struct VerdictBuffer {
    spans: Vec<(u32, Span, RecordPlace<SpanVerdicts>)>,
    spill: SpillFile,
}

impl VerdictBuffer {
    /// An empty buffer that holds at most `bound` bytes in memory.
    #[must_use]
    pub fn new(bound: usize) -> Self {
        Self { spans: Vec::new(), spill: SpillFile::new(bound) }
    }

    /// Takes the verdicts of a camera and span; without any pixel they are left out.
    ///
    /// # Errors
    /// `Io` where the temporary file cannot be written.
    pub fn push(&mut self, verdicts: SpanVerdicts) -> Result<()> {
        if !verdicts.pixels.is_empty() {
            let (camera, span) = (verdicts.camera, verdicts.span);
            self.spans.push((camera, span, self.spill.put(verdicts)?));
        }
        Ok(())
    }

    /// Puts the spans into the order of images: longest first, then earliest, then by camera.
    pub fn sort(&mut self) {
        self.spans.sort_by_key(|(camera, span, _)| (Reverse(span.len()), *span, *camera));
    }

    /// Spans of cameras.
    #[must_use]
    pub fn len(&self) -> usize {
        self.spans.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.spans.is_empty()
    }

    /// The verdicts in a place.
    ///
    /// # Errors
    /// `Io` where the temporary file cannot be read.
    pub fn get(&self, index: usize) -> Result<Arc<SpanVerdicts>> {
        self.spill.get(&self.spans[index].2)
    }
}
