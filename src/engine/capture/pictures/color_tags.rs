//! What a picture says of its own colors: an ICC profile, or the chunks of PNG (`cICP`, `cHRM`, `gAMA`).
//!
//! Source: ICC.1:2022 and PNG (third edition), read by `moxcms` and `png`. `cICP` counts before a profile, that before `sRGB`, and that
//! before `cHRM` and `gAMA`. Profiles of a curve for each channel and a matrix, as cameras and screens write them, are converted without
//! clipping; those of tables are converted to sRGB.

use std::path::Path;
use std::sync::Arc;

use glam::{DMat3, DVec3};
use moxcms::{
    CicpColorPrimaries, CicpProfile, ColorProfile, DataColorSpace, Layout, MatrixCoefficients, ToneReprCurve,
    TransferCharacteristics, TransformF32Executor, TransformOptions,
};

use crate::capture::exr::Primaries;
use crate::color::{linear_from_srgb, srgb_from_linear};
use crate::error::{Error, Result, one_line};
use crate::whole_file;

/// Curves and matrices of sRGB in profiles of all makers differ from each other by less, in shares of white.
const SRGB_SLACK: f64 = 4e-3;

/// The `gAMA` that stands for the sRGB curve, and how far others that mean it are off.
const SRGB_GAMMA: std::ops::RangeInclusive<f32> = 0.445..=0.465;

/// From the numbers of a picture to linear Rec.709.
pub(super) enum ColorTag {
    /// A curve for each channel, sampled at every number of 16 bits, and a matrix.
    Curves([Vec<f32>; 3], DMat3),
    /// To sRGB, by tables.
    Tables(Arc<TransformF32Executor>),
}

/// The error of a tag that cannot be applied.
fn refused(place: &str, why: &str) -> Error {
    let what = format!(
        "its color profile cannot be converted ({}); convert the pictures to sRGB, or write \"color_space\": \"srgb\" in the manifest to take their numbers as they are",
        one_line(why)
    );
    Error::unsupported(place, what)
}

impl ColorTag {
    /// Reads an ICC profile; `None` where it is sRGB.
    ///
    /// # Errors
    /// `Unsupported` for a profile that is damaged, or of other colors than gray and RGB.
    pub(super) fn of_profile(bytes: &[u8], place: &str) -> Result<Option<Self>> {
        let profile =
            ColorProfile::new_from_slice(bytes).map_err(|error| refused(place, &error.to_string()))?;
        let curves = match profile.color_space {
            DataColorSpace::Rgb => [&profile.red_trc, &profile.green_trc, &profile.blue_trc],
            DataColorSpace::Gray => [&profile.gray_trc; 3],
            _ => return Err(refused(place, "it is of neither gray nor RGB")),
        };
        let is_gray = profile.color_space == DataColorSpace::Gray;
        if let [Some(red), Some(green), Some(blue)] = curves {
            let srgb = ColorProfile::new_srgb();
            let own = if is_gray {
                DMat3::IDENTITY
            } else {
                DMat3::from_cols_array_2d(&profile.transform_matrix(&srgb).v).transpose()
            };
            return Self::of_curves([red, green, blue], own, place);
        }
        let options = TransformOptions::default();
        let transform =
            profile.create_transform_f32(Layout::Rgb, &ColorProfile::new_srgb(), Layout::Rgb, options);
        transform
            .map(|transform| Some(Self::Tables(transform)))
            .map_err(|error| refused(place, &error.to_string()))
    }

    /// From curves and a matrix; `None` where both are those of sRGB.
    fn of_curves(curves: [&ToneReprCurve; 3], matrix: DMat3, place: &str) -> Result<Option<Self>> {
        let mut sampled = [const { Vec::new() }; 3];
        for (sampled, curve) in sampled.iter_mut().zip(curves) {
            let curve = curve.make_linear_evaluator().map_err(|error| refused(place, &error.to_string()))?;
            *sampled = (0..=u16::MAX).map(|value| curve.evaluate_value(share(value))).collect();
        }
        if !matrix.is_finite() || sampled.iter().flatten().any(|value| !value.is_finite()) {
            return Err(refused(place, "it holds numbers that are not finite"));
        }
        let is_near = |a: f32, b: f32| f64::from((a - b).abs()) <= SRGB_SLACK;
        let is_srgb = |curve: &Vec<f32>| {
            let mut steps = (0..=u16::MAX).step_by(257);
            steps.all(|value| is_near(srgb_from_linear(curve[usize::from(value)]), share(value)))
        };
        let is_own = matrix.abs_diff_eq(DMat3::IDENTITY, SRGB_SLACK) && sampled.iter().all(is_srgb);
        Ok((!is_own).then_some(Self::Curves(sampled, matrix)))
    }

    /// Reads the chunks of a PNG; `None` where they say that it is sRGB, or nothing.
    ///
    /// # Errors
    /// `Unsupported` for transfer curves of high dynamic range, and for a profile that cannot be converted.
    pub(super) fn of_png(path: &Path, place: &str) -> Result<Option<Self>> {
        let decoder = png::Decoder::new(std::io::BufReader::new(whole_file::open(path)?));
        // What is damaged is told by the decoder of pixels.
        let Ok(reader) = decoder.read_info() else { return Ok(None) };
        let info = reader.info();
        if let Some(points) = info.coding_independent_code_points {
            return Self::of_code_points(points.color_primaries, points.transfer_function, place);
        }
        if let Some(profile) = &info.icc_profile {
            return Self::of_profile(profile, place);
        }
        if info.srgb.is_some() {
            return Ok(None);
        }
        let primaries = info.chromaticities().map_or(Primaries::Rec709, |known| {
            let places = [known.red, known.green, known.blue, known.white];
            Primaries::of(places.map(|(x, y)| [x.into_value(), y.into_value()]))
        });
        let gamma = info.gamma().map(png::ScaledFloat::into_value);
        let gamma = gamma.filter(|gamma| !SRGB_GAMMA.contains(gamma) && (0.05..=20.0).contains(gamma));
        let curve = gamma.map(|gamma| ToneReprCurve::Parametric(vec![1.0 / gamma]));
        let own = ColorProfile::new_srgb().red_trc;
        match (primaries, curve.or(own)) {
            (Primaries::Absurd, _) => Err(refused(place, "its chromaticities are of no colors")),
            (Primaries::Rec709, Some(curve)) => Self::of_curves([&curve; 3], DMat3::IDENTITY, place),
            (Primaries::Others(matrix), Some(curve)) => Self::of_curves([&curve; 3], matrix, place),
            (_, None) => Ok(None),
        }
    }

    /// From H.273's numbers for primaries and transfer curve.
    fn of_code_points(primaries: u8, transfer: u8, place: &str) -> Result<Option<Self>> {
        let unknown = |_| refused(place, &format!("cICP {primaries}, {transfer} is not known"));
        let color_primaries = CicpColorPrimaries::try_from(primaries).map_err(unknown)?;
        let transfer_characteristics = TransferCharacteristics::try_from(transfer).map_err(unknown)?;
        if matches!(
            transfer_characteristics,
            TransferCharacteristics::Smpte2084 | TransferCharacteristics::Hlg
        ) {
            let what = "the picture is of high dynamic range (PQ or HLG), which is not read from PNG; save it as OpenEXR";
            return Err(Error::unsupported(place, what));
        }
        let profile = ColorProfile::new_from_cicp(CicpProfile {
            color_primaries,
            transfer_characteristics,
            matrix_coefficients: MatrixCoefficients::Identity,
            full_range: true,
        });
        let [Some(red), Some(green), Some(blue)] = [&profile.red_trc, &profile.green_trc, &profile.blue_trc]
        else {
            return Err(refused(place, &format!("cICP {primaries}, {transfer} has no curve")));
        };
        let matrix =
            DMat3::from_cols_array_2d(&profile.transform_matrix(&ColorProfile::new_srgb()).v).transpose();
        Self::of_curves([red, green, blue], matrix, place)
    }

    /// Linear Rec.709 of numbers from 0 to 1.
    pub(super) fn linear(&self, mut encoded: [Vec<f32>; 3], place: &str) -> Result<[Vec<f32>; 3]> {
        match self {
            Self::Curves(curves, matrix) => {
                let at = |value: f32| (value.clamp(0.0, 1.0) * f32::from(u16::MAX) + 0.5) as usize;
                for (plane, curve) in encoded.iter_mut().zip(curves) {
                    for value in plane {
                        *value = curve[at(*value)];
                    }
                }
                let [red, green, blue] = &mut encoded;
                for ((red, green), blue) in red.iter_mut().zip(green).zip(blue) {
                    let color = *matrix * DVec3::new(f64::from(*red), f64::from(*green), f64::from(*blue));
                    (*red, *green, *blue) = (color.x as f32, color.y as f32, color.z as f32);
                }
            }
            Self::Tables(transform) => {
                let [red, green, blue] = &encoded;
                let pixels: Vec<f32> = red
                    .iter()
                    .zip(green)
                    .zip(blue)
                    .flat_map(|((red, green), blue)| [*red, *green, *blue])
                    .collect();
                let mut converted = vec![0.0; pixels.len()];
                transform
                    .transform(&pixels, &mut converted)
                    .map_err(|error| refused(place, &error.to_string()))?;
                for (channel, plane) in encoded.iter_mut().enumerate() {
                    let values = converted.iter().skip(channel).step_by(3);
                    plane.iter_mut().zip(values).for_each(|(value, found)| *value = linear_from_srgb(*found));
                }
            }
        }
        Ok(encoded)
    }
}

fn share(value: u16) -> f32 {
    f32::from(value) / f32::from(u16::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn linear(tag: &ColorTag, color: [f32; 3]) -> [f32; 3] {
        tag.linear(color.map(|value| vec![value]), "test").unwrap().map(|plane| plane[0])
    }

    #[test]
    fn a_profile_of_srgb_changes_nothing_and_one_of_a_wider_space_does() {
        let encoded = |profile: ColorProfile| profile.encode().unwrap();
        assert!(ColorTag::of_profile(&encoded(ColorProfile::new_srgb()), "test").unwrap().is_none());
        let tag = ColorTag::of_profile(&encoded(ColorProfile::new_display_p3()), "test").unwrap().unwrap();
        // Published: a third of full red of Display P3 is beyond that of sRGB.
        let [red, green, blue] = linear(&tag, [1.0, 0.0, 0.0]);
        assert!((red - 1.2249).abs() < 2e-3 && (green + 0.0420).abs() < 2e-3 && (blue + 0.0196).abs() < 2e-3);
        let gray = linear(&tag, [0.5; 3]);
        assert!(gray.iter().all(|value| (value - linear_from_srgb(0.5)).abs() < 1e-3), "{gray:?}");
        let refused = ColorTag::of_profile(b"no profile", "a.jpg").err().unwrap().to_string();
        assert!(refused.starts_with("a.jpg: ") && refused.contains("color_space"), "{refused}");
    }

    #[test]
    fn code_points_name_the_colors_of_a_png() {
        assert!(ColorTag::of_code_points(1, 13, "test").unwrap().is_none(), "sRGB");
        let p3 = ColorTag::of_code_points(12, 13, "test").unwrap().unwrap();
        assert!((linear(&p3, [1.0, 0.0, 0.0])[0] - 1.2249).abs() < 2e-3);
        let linear_light = ColorTag::of_code_points(1, 8, "test").unwrap().unwrap();
        assert!((linear(&linear_light, [0.25; 3])[1] - 0.25).abs() < 1e-3);
        let refused = ColorTag::of_code_points(9, 16, "a.png").err().unwrap().to_string();
        assert!(refused.contains("high dynamic range"), "{refused}");
    }
}
