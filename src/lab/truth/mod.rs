//! What pictures are compared with.

mod error_classes;
mod folds;
mod hold_out;
mod view_corrections;

pub(crate) use error_classes::is_surface_at;
pub use error_classes::{class_map, class_maps, seen_at};
pub(crate) use folds::masked_one_by_one;
pub use folds::{Fold, Recorded, Truth, TruthEdit};
pub(crate) use hold_out::evenly_spaced;
pub use hold_out::split;
use overlook_engine::capture::{Capture, TruthView, with_reindexed_frames};
use overlook_engine::error::{Error, Result};
pub use view_corrections::{CorrectedViews, ViewCorrections, views_as_taken};

/// Bytes of frames kept in a derived capture: little, the original keeps its own.
pub(crate) const DERIVED_CACHE_BYTES: usize = 256 << 20;

/// The capture with `count` of its frames alone, and the truth at those: spread evenly, those with truth first.
///
/// # Errors
///
/// `Invalid` if `count` is 0.
pub fn frames(capture: &Capture, truth: Truth, count: usize) -> Result<(Capture, Truth)> {
    let chosen = choose(capture, &truth, count)?;
    Ok((only(capture, &chosen), truth_at(capture, truth, &chosen)))
}

/// `count` frames of a capture, spread evenly: frames with truth first, thinned if there are more than `count`.
pub(crate) fn choose(capture: &Capture, truth: &Truth, count: usize) -> Result<Vec<usize>> {
    if count == 0 {
        return Err(Error::invalid("frames", "there must be at least one"));
    }
    let total = capture.frame_count();
    if count >= total {
        return Ok((0..total).collect());
    }
    let mut with_truth: Vec<usize> = match truth {
        Truth::Views(views) => {
            views.iter().filter_map(|view| capture.frame_index(view.frame_number)).collect()
        }
        Truth::HoldOut => Vec::new(),
    };
    with_truth.sort_unstable();
    with_truth.dedup();
    let mut frames: Vec<usize> =
        evenly_spaced(with_truth.len(), count).map(|index| with_truth[index]).collect();
    // What is left of the count goes where the widest gaps are.
    while frames.len() < count {
        let farthest =
            |frame: usize| frames.iter().map(|chosen| chosen.abs_diff(frame)).min().unwrap_or(total - frame);
        let open = (0..total).filter(|frame| !frames.contains(frame));
        let Some(next) = open.max_by_key(|&frame| (farthest(frame), total - frame)) else { break };
        frames.push(next);
    }
    frames.sort_unstable();
    Ok(frames)
}

/// The capture with some of its frames alone, given by ascending index.
pub(crate) fn only(capture: &Capture, frames: &[usize]) -> Capture {
    if frames.len() == capture.frame_count() {
        return capture.clone();
    }
    let frame_numbers = frames.iter().map(|&frame| capture.frame_numbers[frame]).collect();
    let frames = frames.to_vec();
    let few = with_reindexed_frames(capture, DERIVED_CACHE_BYTES, move |_, frame| frames[frame]);
    few.with_frame_numbers(frame_numbers)
}

/// The truth at some frames of the capture alone, given by ascending index.
pub(crate) fn truth_at(capture: &Capture, truth: Truth, frames: &[usize]) -> Truth {
    let is_chosen = |view: &TruthView| {
        capture.frame_index(view.frame_number).is_some_and(|frame| frames.binary_search(&frame).is_ok())
    };
    match truth {
        Truth::Views(views) => Truth::Views(views.into_iter().filter(is_chosen).collect()),
        Truth::HoldOut => Truth::HoldOut,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use overlook_engine::demo::{Demo, DemoSpec};
    use overlook_engine::settings::CaptureSettings;

    #[test]
    fn frames_with_truth_come_first_and_the_others_fill_the_widest_gaps() {
        let spec = DemoSpec::new("orrery").cameras(2).frames(20).size((16, 12));
        let demo = Demo::new(&spec).unwrap();
        let capture = demo.capture(&CaptureSettings::default());
        let truth = Truth::Views(demo.truth_views());
        assert_eq!(choose(&capture, &truth, 5).unwrap(), [0, 4, 8, 12, 16]);
        assert_eq!(choose(&capture, &truth, 2).unwrap(), [0, 8]);
        assert_eq!(choose(&capture, &Truth::HoldOut, 1).unwrap(), [0]);
        assert_eq!(choose(&capture, &Truth::HoldOut, 99).unwrap().len(), 20);
        assert!(choose(&capture, &truth, 0).is_err());
        let (few, truth) = frames(&capture, truth, 6).unwrap();
        assert_eq!(few.frame_numbers, [0, 4, 8, 12, 16, 19]);
        assert_eq!(*few.frame(1, 2).unwrap(), *capture.frame(1, 8).unwrap());
        let Truth::Views(views) = truth else { panic!("views stay views") };
        assert_eq!(views.len(), 15);
    }
}
