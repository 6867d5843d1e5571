//! Red, green and blue of one picture, and the half-float pixels that they make.

use exr::meta::attribute::Chromaticities;
use glam::{DMat3, DVec3};
use half::f16;
use half::slice::HalfFloatSliceExt;
use moxcms::{Chromaticity, ColorPrimaries, Matrix3d, WHITE_POINT_D65, XyY, adapt_to_d50_d};

use super::channels::ChannelPlane;
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
    /// Every channel times a number.
    pub(crate) fn multiplied_by(self, factor: f32) -> Self {
        if factor == 1.0 {
            return self;
        }
        Self::Single(self.into_single().map(|plane| plane.into_iter().map(|value| value * factor).collect()))
    }

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

/// Chromaticities that differ from those of Rec.709 by no more than this are taken for them.
const CHROMATICITY_SLACK: f32 = 1e-3;

/// The primaries of Rec.709 and its white.
const REC_709: [[f32; 2]; 4] = [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]];

/// CIE XYZ: colors of that space have no white of their own.
const XYZ: [[f32; 2]; 3] = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]];

/// What the primaries of a picture are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Primaries {
    /// Those of Rec.709, as the program's.
    Rec709,
    /// Linear Rec.709 from the picture's linear colors.
    Others(DMat3),
    /// Numbers that no colors have.
    Absurd,
}

impl Primaries {
    /// From an OpenEXR header.
    pub(crate) fn of_header(Chromaticities { red, green, blue, white }: Chromaticities) -> Self {
        Self::of([red, green, blue, white].map(|place| [place.0, place.1]))
    }

    /// From the chromaticities x, y of red, green, blue and white. Colors are adapted to the white of Rec.709 (Bradford), as are those of
    /// every profile; CIE XYZ is taken as it is.
    pub(crate) fn of(places: [[f32; 2]; 4]) -> Self {
        let is_near = |[a, b]: [f32; 2], [x, y]: [f32; 2]| {
            (a - x).abs() <= CHROMATICITY_SLACK && (b - y).abs() <= CHROMATICITY_SLACK
        };
        if places.into_iter().zip(REC_709).all(|(found, known)| is_near(found, known)) {
            return Self::Rec709;
        }
        let [red, green, blue, white] = places.map(|[x, y]| Chromaticity { x, y });
        let xyz_from_source = ColorPrimaries { red, green, blue }.transform_to_xyz_d(white.to_xyyb());
        let xyz_from_709 = ColorPrimaries::BT_709.transform_to_xyz_d(WHITE_POINT_D65);
        let is_xyz = places.into_iter().zip(XYZ).all(|(found, known)| is_near(found, known));
        let (source, own) = if is_xyz {
            (DMat3::IDENTITY, matrix(&xyz_from_709))
        } else {
            let adapted = |from: Matrix3d, white: XyY| matrix(&adapt_to_d50_d(from, white));
            (adapted(xyz_from_source, white.to_xyyb()), adapted(xyz_from_709, WHITE_POINT_D65))
        };
        let found = own.inverse() * source;
        let is_sound = found.is_finite() && found.determinant().abs() > 1e-6;
        if is_sound { Self::Others(found) } else { Self::Absurd }
    }

    /// Converts linear colors of these primaries.
    pub(crate) fn convert(self, colors: &mut [Vec<f32>; 3]) {
        let Self::Others(matrix) = self else { return };
        let [red, green, blue] = colors;
        for ((red, green), blue) in red.iter_mut().zip(green).zip(blue) {
            let color = matrix * DVec3::new(f64::from(*red), f64::from(*green), f64::from(*blue));
            (*red, *green, *blue) = (color.x as f32, color.y as f32, color.z as f32);
        }
    }
}

/// A matrix of the library, whose rows are listed.
fn matrix(rows: &Matrix3d) -> DMat3 {
    DMat3::from_cols_array_2d(&rows.v).transpose()
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

    fn converted(places: [[f32; 2]; 4], color: [f32; 3]) -> [f32; 3] {
        let mut planes = color.map(|value| vec![value]);
        Primaries::of(places).convert(&mut planes);
        planes.map(|plane| plane[0])
    }

    #[test]
    fn published_matrices_come_out() {
        let p3 = [[0.68, 0.32], [0.265, 0.69], [0.15, 0.06], [0.3127, 0.329]];
        let red = converted(p3, [1.0, 0.0, 0.0]);
        for (found, expected) in red.into_iter().zip([1.2249, -0.0420, -0.0196]) {
            assert!((found - expected).abs() < 1e-3, "{red:?}");
        }
        let xyz = [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0], [1.0 / 3.0, 1.0 / 3.0]];
        for (found, expected) in converted(xyz, [0.9505, 1.0, 1.0891]).into_iter().zip([1.0; 3]) {
            assert!((found - expected).abs() < 2e-3, "the white of Rec.709: {found}");
        }
        let aces = [[0.713, 0.293], [0.165, 0.83], [0.128, 0.044], [0.32168, 0.33767]];
        for found in converted(aces, [0.5; 3]) {
            assert!((found - 0.5).abs() < 2e-3, "gray stays gray: {found}");
        }
    }

    #[test]
    fn rec_709_is_left_as_it_is_and_what_no_colors_have_is_known() {
        assert_eq!(Primaries::of(REC_709), Primaries::Rec709);
        assert_eq!(Primaries::of([[0.3, 0.3]; 4]), Primaries::Absurd);
        assert_eq!(Primaries::of([[f32::NAN; 2]; 4]), Primaries::Absurd);
    }
}
