//! The numbers of one channel, as precise as the file holds them: half floats stay what they are, as color does in the end.

use std::ops::Range;

use exr::meta::attribute::SampleType;
use half::f16;
use half::slice::HalfFloatSliceExt;

/// One channel, row-major over the asked-for window; NaN where the file's data window does not reach.
#[derive(Clone, Debug)]
pub enum ChannelPlane {
    /// A channel of half floats.
    Half(Vec<f16>),
    /// A channel of floats or whole numbers.
    Single(Vec<f32>),
}

impl ChannelPlane {
    /// A plane of NaN.
    pub(crate) fn unknown(is_half: bool, pixels: usize) -> Self {
        if is_half { Self::Half(vec![f16::NAN; pixels]) } else { Self::Single(vec![f32::NAN; pixels]) }
    }

    /// The numbers in single precision.
    #[must_use]
    pub fn into_single(self) -> Vec<f32> {
        match self {
            Self::Half(values) => values.to_f32_vec(),
            Self::Single(values) => values,
        }
    }

    /// Sets some numbers to those of a line of the file.
    pub(crate) fn set(&mut self, range: Range<usize>, line: &[u8], kind: SampleType) {
        match (self, kind) {
            (Self::Half(values), _) => read(line, &mut values[range], f16::from_ne_bytes),
            (Self::Single(values), SampleType::U32) => {
                read(line, &mut values[range], |bytes| u32::from_ne_bytes(bytes) as f32);
            }
            (Self::Single(values), _) => read(line, &mut values[range], f32::from_ne_bytes),
        }
    }
}

fn read<const BYTES: usize, T>(line: &[u8], target: &mut [T], decode: impl Fn([u8; BYTES]) -> T) {
    let (samples, _) = line.as_chunks::<BYTES>();
    for (value, sample) in target.iter_mut().zip(samples) {
        *value = decode(*sample);
    }
}
