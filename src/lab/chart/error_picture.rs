//! A true picture, the rendered one, and a map of their difference, beside each other.

use std::io::Cursor;

use image::{ImageFormat, Rgb, RgbImage};

use crate::metrics::{ClassMap, ErrorClass};
use overlook_engine::capture::Frame;
use overlook_engine::color::srgb8_from_linear;
use overlook_engine::error::{Error, Result};
use overlook_engine::render::Picture;

/// Color of a pixel that shows no surface, or whose class is not known.
const NO_CLASS: [u8; 3] = [220, 220, 220];

/// Error at which the map has its full color, 8-bit steps.
const FULL_STEPS: f32 = 64.0;

/// Pixels between the parts.
const GAP: u32 = 4;

/// The truth, the picture and the map of its error as one PNG: the largest difference of a channel, brightest at 64 8-bit steps,
/// colored by class.
///
/// # Errors
/// `Invalid` where the sizes differ or a PNG cannot hold them.
pub fn error_picture(picture: &Picture, truth: &Frame, classes: Option<&ClassMap>) -> Result<Vec<u8>> {
    let (width, height) = truth.size();
    if picture.color.size() != (width, height)
        || classes.is_some_and(|classes| classes.size() != (width, height))
    {
        return Err(Error::invalid("error map", "the picture and its truth differ in size"));
    }
    let (columns, rows) = (width as u32, height as u32);
    let mut sheet = RgbImage::from_pixel(3 * columns + 2 * GAP, rows, Rgb([255; 3]));
    for y in 0..height {
        for x in 0..width {
            let at = (x, y);
            let shown = picture.color[at].map(srgb8_from_linear);
            let known = truth.color[at].map(|linear| srgb8_from_linear(linear.to_f32()));
            let apart =
                (0..3).map(|channel| shown[channel].abs_diff(known[channel])).max().unwrap_or_default();
            let strength = (f32::from(apart) / FULL_STEPS).min(1.0).sqrt();
            let class = classes.and_then(|classes| classes[at]);
            let color = class.map_or(NO_CLASS, ErrorClass::color);
            let error = color.map(|value| (f32::from(value) * strength) as u8);
            for (part, color) in [known, shown, error].into_iter().enumerate() {
                sheet.put_pixel(part as u32 * (columns + GAP) + x as u32, y as u32, Rgb(color));
            }
        }
    }
    let mut bytes = Cursor::new(Vec::new());
    let written = sheet.write_to(&mut bytes, ImageFormat::Png);
    written.map_err(|error| Error::invalid("error map", error.to_string()))?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::grid::Grid;

    #[test]
    fn truth_picture_and_error_stand_beside_each_other_and_errors_have_the_color_of_their_class() {
        let picture = Picture { color: Grid::filled(2, 1, [1.0; 3]), ..Picture::empty(2, 1) };
        let truth = Frame {
            color: Grid::from_vec(2, 1, vec![[half::f16::ONE; 3], [half::f16::ZERO; 3]]),
            inverse_depth: Grid::filled(2, 1, 1.0),
            normal_in_world: None,
            depth_step_relative: 0.0,
            values: overlook_engine::capture::Values::default(),
        };
        let classes = Grid::from_vec(2, 1, vec![Some(ErrorClass::Inner), Some(ErrorClass::Edge)]);
        let png = error_picture(&picture, &truth, Some(&classes)).unwrap();
        let sheet = image::load_from_memory(&png).unwrap().to_rgb8();
        let colors = [0, 1, 6, 7, 12, 13].map(|x| sheet.get_pixel(x, 0).0);
        assert_eq!(colors, [[255; 3], [0; 3], [255; 3], [255; 3], [0; 3], [230, 159, 0]]);
        assert!(error_picture(&Picture::empty(1, 1), &truth, None).is_err());
    }
}
