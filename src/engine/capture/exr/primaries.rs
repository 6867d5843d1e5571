//! From colors of any primaries to those of Rec.709.

use exr::meta::attribute::Chromaticities;
use glam::{DMat3, DVec3};
use moxcms::{Chromaticity, ColorPrimaries, Matrix3d, WHITE_POINT_D65, XyY, adapt_to_d50_d};

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
