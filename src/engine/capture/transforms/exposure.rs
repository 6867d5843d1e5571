//! Colors that are far brighter than white: found, and scaled by one key, so that every output shows them.

use half::f16;

use super::cameras::CameraFiles;
use super::load::{self, NeededPlanes};
use super::placed_entry::PlacedEntry;
use crate::capture::pictures::{PictureFormat, format_of};
use crate::error::{Error, Result};

/// Most stops that a manifest may ask for: half floats hold no more.
const MOST_STOPS: f64 = 24.0;

/// A picture whose median pixel is brighter than this, linear, is white nearly everywhere in 8 bits.
const FAR_OVER_WHITE: f32 = 16.0;

/// The brightness that the median pixel is to have.
const MIDDLE: f32 = 0.35;

/// What colors are multiplied by, for the manifest's key in stops.
///
/// # Errors
/// `Invalid` for stops beyond ±24, and what is no number.
pub(super) fn factor(stops: Option<f64>, place: &str) -> Result<f32> {
    let stops = stops.unwrap_or(0.0);
    if !(stops.abs() <= MOST_STOPS) {
        return Err(Error::invalid(place, format!("exposure is {stops}; give stops from -24 to 24")));
    }
    Ok(stops.exp2() as f32)
}

/// A warning where the first picture is far brighter than white, with the key that scales all of them. Formats of whole numbers end at
/// white. What cannot be read is told where it is needed.
pub(super) fn warning(recording: &CameraFiles) -> Option<String> {
    let (camera, PlacedEntry { files, place, .. }) =
        recording.cameras.first().zip(recording.entries.first().and_then(|entries| entries.first()))?;
    if !matches!(format_of(&files.color, place), Ok(PictureFormat::Exr | PictureFormat::Tiff)) {
        return None;
    }
    let frame = load::frame(files, camera, place, NeededPlanes::ColorOnly).ok()?;
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
            camera.name
        )
    })
}
