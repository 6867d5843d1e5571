//! Masks: which pixels of a picture count.
//!
//! Programs write masks as 0 and 255, as 0 and 1, with the soft edges of mattes, through JPEG, or as the alpha of a picture.

use std::path::Path;

use super::format::{PictureFormat, format_of};
use super::raster::decode_any;
use super::tiff_samples::TiffSamples;
use crate::error::Result;

/// The columns and rows of a mask, and row by row whether a pixel counts.
pub(crate) fn mask(path: &Path, place: &str) -> Result<((usize, usize), Vec<bool>)> {
    let format = format_of(path, place)?;
    let is_lossy = format == PictureFormat::Jpeg;
    let (size, channels, values, most) = if format == PictureFormat::Tiff {
        let TiffSamples { size, channels, values, whole_up_to, .. } = TiffSamples::read(path, place)?;
        (size, channels, values, whole_up_to.unwrap_or(1.0))
    } else {
        let picture = decode_any(path, place)?.into_rgba16();
        let size = (picture.width() as usize, picture.height() as usize);
        (size, 4, picture.into_raw().into_iter().map(f32::from).collect(), f32::from(u16::MAX))
    };
    let colors = if channels < 3 { 1 } else { 3 };
    let brightest = |pixel: &[f32]| pixel[..colors].iter().copied().fold(0.0, f32::max);
    let gray: Vec<f32> = values.chunks_exact(channels).map(brightest).collect();
    let alpha: Option<Vec<f32>> = matches!(channels, 2 | 4)
        .then(|| values.chunks_exact(channels).map(|pixel| pixel[channels - 1]).collect());
    let alpha = alpha.map(|alpha| kept(&alpha, most, true));
    // An opacity that is the same everywhere says nothing, and neither does a color that is.
    let alpha = alpha.filter(|alpha| alpha.iter().any(|it| *it) && !alpha.iter().all(|it| *it));
    let is_flat = gray.windows(2).all(|pair| pair[0] == pair[1]);
    let counts = match alpha {
        Some(alpha) if is_flat => alpha,
        Some(alpha) => kept(&gray, most, is_lossy).into_iter().zip(alpha).map(|(a, b)| a && b).collect(),
        None => kept(&gray, most, is_lossy),
    };
    Ok((size, counts))
}

/// Which values are at least half of the most there can be. Where none is, they are numbers of things, or 0 and 1: all above 0 count then,
/// unless small ones are the rests of a lossy 0.
fn kept(values: &[f32], most: f32, is_share: bool) -> Vec<bool> {
    let half = 0.5 * most;
    let are_shares = is_share || values.iter().any(|value| *value >= half);
    values.iter().map(|value| if are_shares { *value >= half } else { *value > 0.0 }).collect()
}

#[cfg(test)]
mod tests {
    use image::{DynamicImage, GrayAlphaImage, GrayImage, Luma, LumaA};

    use super::*;

    fn counted(picture: &DynamicImage, name: &str) -> Vec<bool> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        picture.save(&path).unwrap();
        mask(&path, "a test").unwrap().1
    }

    #[test]
    fn below_half_is_out_and_small_whole_numbers_are_numbers() {
        let of = |values: [u8; 4], name: &str| {
            counted(&GrayImage::from_fn(4, 1, |x, _| Luma([values[x as usize]])).into(), name)
        };
        assert_eq!(of([0, 127, 128, 255], "a.png"), [false, false, true, true]);
        assert_eq!(of([0, 1, 2, 3], "a.png"), [false, true, true, true]);
        assert_eq!(of([0; 4], "a.png"), [false; 4]);
        assert_eq!(of([9; 4], "a.jpg"), [false; 4]);
    }

    #[test]
    fn alpha_counts_beside_colors_that_differ_and_alone_where_they_do_not() {
        let of = |values: [[u8; 2]; 4]| {
            counted(&GrayAlphaImage::from_fn(4, 1, |x, _| LumaA(values[x as usize])).into(), "a.png")
        };
        assert_eq!(of([[255, 0], [255, 100], [255, 200], [255, 255]]), [false, false, true, true]);
        assert_eq!(of([[0, 0], [0, 255], [0, 0], [0, 255]]), [false, true, false, true]);
        assert_eq!(of([[0, 255], [255, 255], [255, 0], [0, 0]]), [false, true, false, false]);
        assert_eq!(of([[0, 255], [255, 255], [0, 255], [255, 255]]), [false, true, false, true]);
    }
}
