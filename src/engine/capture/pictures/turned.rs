//! Pictures that a tag says to turn before they are shown.

use image::metadata::Orientation;
use serde::{Deserialize, Serialize};

use crate::capture::camera::wrong_size;
use crate::error::{Error, Result};

/// Which rows of a picture poses and depth are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum PictureRows {
    /// Those of the file.
    AsStored,
    /// Those that are seen once the picture is turned as its tag says.
    AsShown,
}

/// Whether a tag exchanges rows and columns.
fn swaps_sides(tag: Orientation) -> bool {
    matches!(
        tag,
        Orientation::Rotate90
            | Orientation::Rotate270
            | Orientation::Rotate90FlipH
            | Orientation::Rotate270FlipH
    )
}

/// Columns and rows of a picture as it is shown.
pub(super) fn shown_size(stored: (usize, usize), tag: Orientation) -> (usize, usize) {
    if swaps_sides(tag) { (stored.1, stored.0) } else { stored }
}

/// How a picture of a stored size is turned for a camera of the `expected` size.
///
/// # Errors
/// `Invalid` where the sizes do not fit, and where they fit both ways and `rows` says nothing.
pub(super) fn turn(
    stored: (usize, usize),
    tag: Orientation,
    expected: (usize, usize),
    rows: Option<PictureRows>,
    place: &str,
) -> Result<Orientation> {
    let shown = shown_size(stored, tag);
    let as_stored = tag == Orientation::NoTransforms || rows == Some(PictureRows::AsStored);
    let as_shown = !as_stored && rows == Some(PictureRows::AsShown);
    match (stored == expected && !as_shown, shown == expected && !as_stored) {
        (true, true) => Err(open(tag, place)),
        (true, false) => Ok(Orientation::NoTransforms),
        (false, true) => Ok(tag),
        (false, false) => Err(wrong_size(place, if as_shown { shown } else { stored }, expected)),
    }
}

/// The error of a picture that may be meant in both ways.
pub(super) fn open(tag: Orientation, place: &str) -> Error {
    let turned = match tag {
        Orientation::Rotate180 => "turned by half",
        Orientation::FlipHorizontal | Orientation::FlipVertical => "mirrored",
        _ => "turned by a quarter",
    };
    let what = format!(
        "an orientation tag says that the picture is shown {turned}, and nothing tells whether poses and depth are of it as shown; write \"picture_orientation\": \"as_shown\" or \"as_stored\" in the manifest, or save the pictures turned and without the tag"
    );
    Error::invalid(place, what)
}

/// Whether a picture of this size is meant as stored or as shown, given the size of what belongs to it pixel by pixel or in proportion;
/// `None` where that fits both ways, or neither.
pub(super) fn rows_by_size(
    stored: (usize, usize),
    tag: Orientation,
    beside: (usize, usize),
) -> Option<PictureRows> {
    let is_of = |size: (usize, usize)| size.0 * beside.1 == size.1 * beside.0;
    match (is_of(stored), is_of(shown_size(stored, tag))) {
        (true, false) => Some(PictureRows::AsStored),
        (false, true) => Some(PictureRows::AsShown),
        _ => None,
    }
}

/// A plane of the stored size as it is seen after turning.
pub(super) fn turned(plane: Vec<f32>, size: (usize, usize), tag: Orientation) -> Vec<f32> {
    if tag == Orientation::NoTransforms {
        return plane;
    }
    let (columns, rows) = shown_size(size, tag);
    let stored = |x: usize, y: usize| match tag {
        Orientation::NoTransforms => (x, y),
        Orientation::FlipHorizontal => (columns - 1 - x, y),
        Orientation::FlipVertical => (x, rows - 1 - y),
        Orientation::Rotate180 => (columns - 1 - x, rows - 1 - y),
        Orientation::Rotate90 => (y, columns - 1 - x),
        Orientation::Rotate270 => (rows - 1 - y, x),
        Orientation::Rotate90FlipH => (y, x),
        Orientation::Rotate270FlipH => (rows - 1 - y, columns - 1 - x),
    };
    let at = |index: usize| {
        let (x, y) = stored(index % columns, index / columns);
        plane[y * size.0 + x]
    };
    (0..plane.len()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{DynamicImage, GrayImage};

    #[test]
    fn planes_are_turned_as_the_library_turns_pictures() {
        let pixels: Vec<u8> = (0..6).collect();
        for tag in (1..=8).filter_map(Orientation::from_exif) {
            let mut picture = DynamicImage::ImageLuma8(GrayImage::from_raw(3, 2, pixels.clone()).unwrap());
            picture.apply_orientation(tag);
            let ours = turned(pixels.iter().map(|value| f32::from(*value)).collect(), (3, 2), tag);
            let expected: Vec<f32> =
                picture.to_luma8().as_raw().iter().map(|value| f32::from(*value)).collect();
            assert_eq!(ours, expected, "{tag:?}");
            assert_eq!(shown_size((3, 2), tag), (picture.width() as usize, picture.height() as usize));
        }
    }

    #[test]
    fn sizes_decide_where_they_fit_one_way_and_else_the_manifest_has_to() {
        let quarter = Orientation::Rotate90;
        let turn = |tag, expected, rows| turn((3, 2), tag, expected, rows, "a.jpg");
        assert_eq!(turn(quarter, (3, 2), None).unwrap(), Orientation::NoTransforms);
        assert_eq!(turn(quarter, (2, 3), None).unwrap(), quarter);
        assert!(turn(quarter, (4, 4), None).unwrap_err().to_string().contains("4×4"));
        let half = Orientation::Rotate180;
        let refused = turn(half, (3, 2), None).unwrap_err().to_string();
        assert!(refused.contains("orientation tag") && refused.contains("picture_orientation"), "{refused}");
        assert_eq!(turn(half, (3, 2), Some(PictureRows::AsShown)).unwrap(), half);
        assert_eq!(turn(half, (3, 2), Some(PictureRows::AsStored)).unwrap(), Orientation::NoTransforms);
        assert_eq!(rows_by_size((3, 2), quarter, (4, 6)), Some(PictureRows::AsShown));
        assert_eq!(rows_by_size((3, 2), half, (6, 4)), None);
    }
}
