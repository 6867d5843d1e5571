//! Which frames noise is measured on: pairs of successive ones from the beginning, the middle and the end.
//!
//! Pictures may be repeated, as where an animation is drawn on twos or its first and last pictures are held. Two frames that are
//! the same bit for bit show no noise. Where a pair is such a repeat, the picture's next change takes its place: from the
//! beginning and the middle onward, from the end backward. It is looked for ever farther away and then closer by halves, so that
//! a picture that is held for a thousand frames costs some twenty of them.

use std::collections::BTreeMap;
use std::sync::Arc;

use rayon::prelude::*;

use crate::capture::Frame;
use crate::error::Result;

/// The frames that are looked at before the pass over all of them.
pub(crate) struct NoiseFrames {
    /// Successive frames that differ, by their index.
    pairs: Vec<[usize; 2]>,
    /// These frames and those at the beginning, the middle and the end, by their index.
    pub(crate) held: BTreeMap<usize, Arc<Frame>>,
}

impl NoiseFrames {
    /// The frames of a camera with this number of frames.
    pub(crate) fn of(frames: usize, load: impl Fn(usize) -> Result<Arc<Frame>> + Sync) -> Result<Self> {
        let places = places(frames);
        let mut looked_at: Vec<usize> = places.iter().flatten().copied().chain(0..frames.min(1)).collect();
        looked_at.sort_unstable();
        looked_at.dedup();
        let loaded = looked_at.into_par_iter().map(|frame| Ok((frame, load(frame)?)));
        let mut held: BTreeMap<usize, Arc<Frame>> = loaded.collect::<Result<Vec<_>>>()?.into_iter().collect();
        let mut pairs = Vec::new();
        for [first, second] in places {
            let change = if !is_same_picture(&held[&first], &held[&second]) {
                Some([first, second].map(|frame| (frame, held[&frame].clone())))
            } else if second + 1 == frames {
                let change = next_change(&held[&second], second, |away| load(second - away))?;
                change.map(|[near, far]| [far, near].map(|(away, frame)| (second - away, frame)))
            } else {
                let change = next_change(&held[&first], frames - 1 - first, |away| load(first + away))?;
                change.map(|change| change.map(|(away, frame)| (first + away, frame)))
            };
            if let Some(change) = change {
                pairs.push(change.each_ref().map(|(frame, _)| *frame));
                held.extend(change);
            }
        }
        pairs.sort_unstable();
        pairs.dedup();
        Ok(Self { pairs, held })
    }

    /// Successive frames that differ; empty if all frames are repeats.
    pub(crate) fn pairs(&self) -> Vec<[&Frame; 2]> {
        self.pairs.iter().map(|pair| pair.map(|frame| &*self.held[&frame])).collect()
    }
}

/// Pairs of successive frames at the beginning, the middle and the end.
fn places(frames: usize) -> Vec<[usize; 2]> {
    let last = frames.saturating_sub(2);
    let mut firsts = vec![0, last / 2, last];
    firsts.dedup();
    firsts.into_iter().filter(|first| first + 1 < frames).map(|first| [first, first + 1]).collect()
}

/// Whether nothing but given normals may tell two frames apart.
fn is_same_picture(a: &Frame, b: &Frame) -> bool {
    fn bytes<T: bytemuck::NoUninit>(plane: &[T]) -> &[u8] {
        bytemuck::cast_slice(plane)
    }
    bytes(a.inverse_depth.as_slice()) == bytes(b.inverse_depth.as_slice())
        && bytes(a.color.as_slice()) == bytes(b.color.as_slice())
}

/// Two frames next to each other that differ, each with its index or how far it is away.
type FramePair = [(usize, Arc<Frame>); 2];

/// Two successive frames, each with its distance: the nearer is the same as `still`, the other is not. The frame at distance 1 is known
/// to be the same. `at` gives frames by distance, up to `farthest`. `None` if no frame that was compared differs.
fn next_change(
    still: &Arc<Frame>,
    farthest: usize,
    at: impl Fn(usize) -> Result<Arc<Frame>>,
) -> Result<Option<FramePair>> {
    let mut near = (1, still.clone());
    let mut far = None;
    while far.is_none() && near.0 < farthest {
        let away = (2 * near.0).min(farthest);
        let frame = at(away)?;
        if is_same_picture(still, &frame) {
            near = (away, frame);
        } else {
            far = Some((away, frame));
        }
    }
    let Some(mut far) = far else { return Ok(None) };
    while near.0 + 1 < far.0 {
        let away = near.0.midpoint(far.0);
        let frame = at(away)?;
        let end = if is_same_picture(still, &frame) { &mut near } else { &mut far };
        *end = (away, frame);
    }
    Ok(Some([near, far]))
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use half::f16;

    use super::*;
    use crate::grid::Grid;

    /// The pairs of frames that show these pictures, and how many frames were loaded.
    fn pairs(pictures: &[usize]) -> (Vec<[usize; 2]>, usize) {
        let asked = AtomicUsize::new(0);
        let load = |frame: usize| {
            asked.fetch_add(1, Ordering::Relaxed);
            Ok(Arc::new(Frame {
                color: Grid::filled(2, 1, [f16::ONE; 3]),
                inverse_depth: Grid::from_vec(2, 1, vec![1.0, pictures[frame] as f32]),
                normal_in_world: None,
                depth_step_relative: 0.0,
                values: crate::capture::Values::default(),
            }))
        };
        let found = NoiseFrames::of(pictures.len(), load).unwrap();
        assert!(found.pairs().iter().all(|[a, b]| a != b));
        (found.pairs, asked.into_inner())
    }

    #[test]
    fn where_every_picture_is_new_the_beginning_the_middle_and_the_end_are_looked_at() {
        let new: Vec<usize> = (0..40).collect();
        assert_eq!(pairs(&new), (vec![[0, 1], [19, 20], [38, 39]], 6));
        assert_eq!(pairs(&new[..2]), (vec![[0, 1]], 2));
        assert_eq!(pairs(&new[..1]), (Vec::new(), 1));
        assert_eq!(pairs(&[]), (Vec::new(), 0));
    }

    #[test]
    fn repeated_pictures_are_passed_over_for_the_next_change() {
        let on_twos: Vec<usize> = (0..62).map(|frame| frame / 2).collect();
        assert_eq!(pairs(&on_twos).0, [[1, 2], [31, 32], [59, 60]]);
        assert_eq!(pairs(&[0, 0, 1, 2, 3, 4, 5, 6, 7, 7]).0, [[1, 2], [4, 5], [7, 8]]);
        assert_eq!(pairs(&[0, 0, 0, 1]).0, [[2, 3]]);
        assert_eq!(pairs(&[0, 1, 1]).0, [[0, 1]]);
        let held: Vec<usize> = (0..3000_usize).map(|frame| frame.clamp(700, 2200)).collect();
        let (found, asked) = pairs(&held);
        assert_eq!(found, [[700, 701], [1499, 1500], [2199, 2200]]);
        assert!(asked < 50, "{asked} frames");
    }

    #[test]
    fn nothing_but_repeats_gives_no_pair_and_costs_a_few_frames() {
        let still: Vec<usize> = std::iter::repeat_n(5, 3000).collect();
        let (found, asked) = pairs(&still);
        assert!(found.is_empty() && asked < 50, "{asked} frames");
    }
}
