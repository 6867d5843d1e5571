//! Red, green and blue of one picture, and the half-float pixels that they make.

use half::f16;
use half::slice::HalfFloatSliceExt;

use super::plane::ChannelPlane;
use crate::capture::frame::INVALID_INVERSE_DEPTH;
use crate::simd::{self, VectorLoop};

/// Linear red, green and blue, row-major, not yet checked.
#[derive(Clone, Debug)]
pub(crate) enum ColorPlanes {
    /// As most renderers write them.
    Half([Vec<f16>; 3]),
    /// Where one of them is more precise.
    Single([Vec<f32>; 3]),
}

impl From<[ChannelPlane; 3]> for ColorPlanes {
    fn from(planes: [ChannelPlane; 3]) -> Self {
        match planes {
            [ChannelPlane::Half(red), ChannelPlane::Half(green), ChannelPlane::Half(blue)] => {
                Self::Half([red, green, blue])
            }
            planes => Self::Single(planes.map(ChannelPlane::into_single)),
        }
    }
}

/// Pixels whose color is narrowed at a time: each conversion detects the processor's features anew.
const NARROWED: usize = 256;

/// Sign taken off and with these bits set, a half float is infinite or not a number.
const NOT_FINITE: u16 = 0x7c00;

impl ColorPlanes {
    /// As `f32`.
    pub(crate) fn into_single(self) -> [Vec<f32>; 3] {
        match self {
            Self::Half(planes) => planes.map(|plane| plane.to_f32_vec()),
            Self::Single(planes) => planes,
        }
    }

    /// The nearest half floats, channel by channel in turn; beyond the largest one the largest, and 0 for channels that are not
    /// finite. Pixels with such a channel lose their inverse depth; how many there were comes back too.
    ///
    /// # Panics
    /// Where planes are not of one size.
    pub(crate) fn into_halves(self, inverse_depth: &mut [f32]) -> (Vec<[f16; 3]>, usize) {
        let mut color = vec![[f16::ZERO; 3]; inverse_depth.len()];
        let without = match self {
            Self::Half(planes) => {
                let planes = planes.each_ref().map(|plane| &plane[..inverse_depth.len()]);
                simd::run(Halves { planes, inverse_depth, color: &mut color })
            }
            Self::Single(planes) => narrow(&planes, inverse_depth, &mut color),
        };
        (color, without)
    }
}

/// Invalidates the inverse depth of pixels with a channel that is not finite; gives their number.
#[inline(always)]
fn invalidate<T: Copy>(
    [red, green, blue]: [&[T]; 3],
    inverse_depth: &mut [f32],
    is_finite: impl Fn(T) -> bool,
) -> usize {
    let mut without = 0_u32;
    for (((red, green), blue), inverse) in red.iter().zip(green).zip(blue).zip(inverse_depth) {
        let are_finite = is_finite(*red) & is_finite(*green) & is_finite(*blue);
        *inverse = if are_finite { *inverse } else { INVALID_INVERSE_DEPTH };
        without += u32::from(!are_finite);
    }
    without as usize
}

struct Halves<'a> {
    planes: [&'a [f16]; 3],
    inverse_depth: &'a mut [f32],
    color: &'a mut [[f16; 3]],
}

impl VectorLoop for Halves<'_> {
    type Output = usize;

    #[inline(always)]
    fn run(self) -> usize {
        let Self { planes: [red, green, blue], inverse_depth, color } = self;
        let finite = |half: f16| half.to_bits() & NOT_FINITE != NOT_FINITE;
        let kept = |half: f16| f16::from_bits(if finite(half) { half.to_bits() } else { 0 });
        let without = invalidate([red, green, blue], inverse_depth, finite);
        for (((red, green), blue), color) in red.iter().zip(green).zip(blue).zip(color) {
            *color = [kept(*red), kept(*green), kept(*blue)];
        }
        without
    }
}

fn narrow(planes: &[Vec<f32>; 3], inverse_depth: &mut [f32], color: &mut [[f16; 3]]) -> usize {
    let without = invalidate(planes.each_ref().map(Vec::as_slice), inverse_depth, f32::is_finite);
    let mut finite = [0.0; NARROWED];
    let mut halves = [f16::ZERO; NARROWED];
    for (index, color) in color.chunks_mut(NARROWED).enumerate() {
        for (channel, plane) in planes.iter().enumerate() {
            for (finite, value) in finite.iter_mut().zip(&plane[index * NARROWED..]) {
                let within = value.max(f16::MIN.to_f32_const()).min(f16::MAX.to_f32_const());
                *finite = if value.is_finite() { within } else { 0.0 };
            }
            halves.convert_from_f32_slice(&finite);
            for (color, half) in color.iter_mut().zip(&halves) {
                color[channel] = *half;
            }
        }
    }
    without
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_floats_make_the_pixels_that_the_same_numbers_in_single_precision_make() {
        let halves: [Vec<f16>; 3] = [0, 7, 311].map(|shift| {
            (0..=u16::MAX)
                .map(|bits: u16| f16::from_bits(bits.wrapping_mul(31).wrapping_add(shift)))
                .collect()
        });
        let single = ColorPlanes::Single(halves.each_ref().map(|plane| plane.to_f32_vec()));
        let made = |planes: ColorPlanes| {
            let mut inverse_depth = vec![0.5; 1 << 16];
            let (color, without) = planes.into_halves(&mut inverse_depth);
            let bits: Vec<u16> = color.as_flattened().iter().map(|half| half.to_bits()).collect();
            (bits, inverse_depth, without)
        };
        let expected = made(single);
        assert!(expected.2 > 1000 && expected.1.iter().filter(|w| **w < 0.0).count() == expected.2);
        assert!(
            simd::at_every_level(|| made(ColorPlanes::Half(halves.clone()))).iter().all(|it| *it == expected)
        );
    }
}
