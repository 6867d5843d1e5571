//! Which pixels of a layer are mixed, in two bits each.

use super::layer::CameraLayer;
use super::packed_sample::is_mixed;

/// Pixels in a byte.
const PER_BYTE: usize = 4;
const FLYING: u8 = 1;
const MIXED: u8 = 2;

/// Which pixels of a layer are mixed.
#[derive(Clone, Debug)]
pub(crate) struct KnownMixed(Vec<u8>);

impl KnownMixed {
    /// Those of a layer that was rated.
    pub(crate) fn of(layer: &CameraLayer) -> Self {
        let mut bits = vec![0; layer.ranks.len().div_ceil(PER_BYTE)];
        let samples = layer.ranks.iter().zip(&layer.packed_colors).zip(&layer.inverse_depth);
        for (pixel, ((rank, color), inverse_depth)) in samples.enumerate() {
            let flying = if color.is_flying() { FLYING } else { 0 };
            let mixed = if *inverse_depth >= 0.0 && is_mixed(*rank) { MIXED } else { 0 };
            bits[pixel / PER_BYTE] |= (flying | mixed) << (2 * (pixel % PER_BYTE));
        }
        Self(bits)
    }

    /// Whether a pixel flies, and whether it is mixed at all.
    pub(crate) fn at(&self, pixel: usize) -> (bool, bool) {
        let bits = self.0[pixel / PER_BYTE] >> (2 * (pixel % PER_BYTE));
        (bits & FLYING != 0, bits & MIXED != 0)
    }
}
