//! Hold-out evaluation: preprocessing leaves cameras out, and their own frames are the truth.

use std::sync::Arc;

use overlook_engine::capture::transforms::picture_name;
use overlook_engine::capture::{Capture, TruthView};
use overlook_engine::error::{Error, Result};

/// Most frames of a held-out camera that are scored, evenly spaced over the capture.
const MAX_FRAMES: usize = 5;

/// The capture without the named cameras, and views with truth at their poses.
///
/// # Errors
///
/// `Invalid` if a camera does not exist or none is left.
pub fn split(capture: &Capture, held_out: &[String]) -> Result<(Capture, Vec<TruthView>)> {
    let is_held_out = |name: &str| held_out.iter().any(|held_out| held_out == name);
    if let Some(unknown) =
        held_out.iter().find(|name| !capture.cameras.iter().any(|camera| camera.name == **name))
    {
        let names: Vec<_> = capture.cameras.iter().map(|camera| camera.name.as_str()).collect();
        return Err(Error::invalid(
            format!("hold-out '{unknown}'"),
            format!("there is no such camera; there are {}", names.join(", ")),
        ));
    }
    let rest = capture.with_cameras(|_, camera| !is_held_out(&camera.name));
    if rest.cameras.is_empty() {
        return Err(Error::invalid(&capture.name, "every camera is held out; leave at least one"));
    }
    let mut views = Vec::new();
    for (index, camera) in capture.cameras.iter().enumerate() {
        if !is_held_out(&camera.name) {
            continue;
        }
        for frame in evenly_spaced(capture.frame_count(), MAX_FRAMES) {
            let truth = capture.clone();
            let number = capture.frame_numbers[frame];
            let load = Arc::new(move || truth.frame(index, frame).map(|frame| (*frame).clone()));
            let view = TruthView::new(picture_name(camera, number), camera.clone(), number, Some(load));
            views.push(TruthView { picture: capture.picture_stem(index, frame), ..view });
        }
    }
    Ok((rest, views))
}

/// At most `count` of `total` indices, evenly spaced, the first among them.
pub(crate) fn evenly_spaced(total: usize, count: usize) -> impl Iterator<Item = usize> {
    let count = count.min(total);
    (0..count).map(move |step| step * total / count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_frames_are_all_scored_and_many_are_spread() {
        assert_eq!(evenly_spaced(0, MAX_FRAMES).count(), 0);
        assert_eq!(evenly_spaced(3, MAX_FRAMES).collect::<Vec<_>>(), [0, 1, 2]);
        assert_eq!(evenly_spaced(60, MAX_FRAMES).collect::<Vec<_>>(), [0, 12, 24, 36, 48]);
    }
}
