//! Colors that are far brighter than white are said, with the key that scales them.

use half::f16;

use super::source::FileSource;
use crate::capture::parts::Capture;
use crate::capture::pictures::{PictureFormat, format_of};

/// A picture whose median pixel is brighter than this, linear, is white nearly everywhere in 8 bits.
const FAR_OVER_WHITE: f32 = 16.0;

/// The brightness that the median pixel is to have.
const MIDDLE: f32 = 0.35;

/// A warning where the first picture is far brighter than white, with the key that scales all of them. Formats of whole numbers end at
/// white. The picture is one that was decoded for its depth before. What cannot be read is told where it is needed.
pub(super) fn warning(capture: &Capture, source: &FileSource) -> Option<String> {
    let entry = source.first_entry()?;
    if !matches!(format_of(&entry.files.color, &entry.place), Ok(PictureFormat::Exr | PictureFormat::Tiff)) {
        return None;
    }
    let frame = capture.frame(0, 0).ok()?;
    let brightest = |color: &[f16; 3]| color.iter().map(|channel| channel.to_f32()).fold(0.0, f32::max);
    let mut seen: Vec<f32> = frame.color.as_slice().iter().map(brightest).collect();
    let middle = seen.len() / 2;
    let (_, median, _) = seen.select_nth_unstable_by(middle, f32::total_cmp);
    let median = *median;
    (median > FAR_OVER_WHITE).then(|| {
        let stops = (MIDDLE / median).log2().round();
        format!(
            "half of the pixels of camera '{}' are more than {median:.0} times as bright as white: pictures of 8 bits, films and pages show \
             them white, and their colors count as equal; write \"exposure\": {stops} in the manifest to scale all colors by so many stops",
            capture.cameras[0].name
        )
    })
}
