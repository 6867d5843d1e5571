//! The spans that samples may live in: a tree over the frames.
//!
//! ```text
//! tree, 12 frames   [0 ─────────────────────────── 12)      paper   [0 ─────────────── 12)
//!                   [0 ─────────────── 8)   [8 ──── 12)             [0][1][2][3] … [11]
//!                   [0 ─── 4)   [4 ─── 8)   [8 10)(10 12)
//!                   [0 2)[2 4)  [4 6)[6 8)  [8][9][10][11]
//!                   [0][1][2][3][4][5][6][7]
//! ```
//!
//! Source: the paper (§3.2) knows two lengths, all frames and one. What differs: a binary tree between them. Where the
//! number of frames is no power of two, the left half of a span is as long as the largest power of two below its length: so
//! all spans but those that end with the last frame are whole powers of two long and begin at a multiple of their length,
//! whatever the number of frames, and a stream of frames completes them like the digits of a binary counter.

use crate::samples::Span;
use crate::settings::SpanLevels;

/// The spans over some frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SpanTree {
    frames: usize,
    levels: SpanLevels,
}

impl SpanTree {
    /// The spans that `levels` allows over `frames` frames, at least one.
    #[must_use]
    pub fn new(frames: usize, levels: SpanLevels) -> Self {
        Self { frames, levels }
    }

    /// All frames.
    #[must_use]
    pub fn root(&self) -> Span {
        all_frames(self.frames)
    }

    /// The spans that `span` is made of, in their order; none for a single frame.
    #[must_use]
    pub fn children(&self, span: Span) -> Vec<Span> {
        if self.levels == SpanLevels::Tree {
            halves(span).map_or_else(Vec::new, |halves| halves.to_vec())
        } else if span == self.root() {
            (0..self.frames).map(one_frame).collect()
        } else {
            Vec::new()
        }
    }

    /// The spans that contain `frame`, longest first: one of each level.
    #[must_use]
    pub fn path(&self, frame: usize) -> Vec<Span> {
        if self.levels != SpanLevels::Tree {
            return vec![self.root(), one_frame(frame)];
        }
        let mut path = vec![self.root()];
        while let Some(halves) = path.last().and_then(|span| halves(*span)) {
            path.push(halves[usize::from(halves[1].contains(frame))]);
        }
        path
    }

    /// The span that `span`, a span of the binary tree, is a half of; `None` for all frames.
    #[must_use]
    pub fn parent(&self, span: Span) -> Option<Span> {
        let path = self.path(span.start as usize);
        path.into_iter().rev().find(|longer| longer.len() > span.len())
    }
}

/// The halves of a span, the left one a power of two long and no shorter than the right; `None` for a single frame.
pub(super) fn halves(span: Span) -> Option<[Span; 2]> {
    let length = span.end - span.start;
    let middle = span.start + 1_u32.checked_shl(length.checked_sub(1)?.checked_ilog2()?)?;
    Some([Span { start: span.start, end: middle }, Span { start: middle, end: span.end }])
}

/// The span of all of `frames` frames.
#[must_use]
pub fn all_frames(frames: usize) -> Span {
    Span { start: 0, end: frames as u32 }
}

/// The span of one frame.
pub(super) fn one_frame(frame: usize) -> Span {
    Span { start: frame as u32, end: frame as u32 + 1 }
}

/// Position on the way from the whole sequence to a single frame: 0 is the span of all frames, and every step down is a
/// shorter span inside the one before. A sample's level determines when it is decided and what it is compared with: samples of one
/// level are decided together, against each other and against those of the levels above, which are decided already.
pub type SpanLevel = u8;

/// The level of the span of all frames.
pub const ROOT: SpanLevel = 0;

/// In place of a level where there is no sample.
pub const NO_SAMPLE: SpanLevel = SpanLevel::MAX;

/// What a pixel is over time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum PixelClass {
    /// No depth: takes part in nothing.
    Invalid,
    /// The same over all frames.
    Background,
    /// A sample of this frame alone.
    Foreground,
    /// The same over some frames, but not over all.
    Lasting,
}

impl PixelClass {
    /// The class of a pixel whose sample has this level, the last of `levels` being that of a single frame.
    pub(crate) fn of(level: SpanLevel, levels: usize) -> Self {
        match level {
            NO_SAMPLE => Self::Invalid,
            ROOT => Self::Background,
            level if usize::from(level) + 1 == levels => Self::Foreground,
            _ => Self::Lasting,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_frame_has_one_path_of_nested_spans_whatever_the_number_of_frames() {
        for frames in 1..=130 {
            let tree = SpanTree::new(frames, SpanLevels::Tree);
            for frame in 0..frames {
                let path = tree.path(frame);
                assert_eq!((path[0], path[path.len() - 1]), (all_frames(frames), one_frame(frame)));
                assert!(path.iter().all(|span| span.contains(frame)));
                for pair in path.windows(2) {
                    assert!(tree.children(pair[0]).contains(&pair[1]));
                    assert_eq!(tree.parent(pair[1]), Some(pair[0]));
                }
                assert!(path.len() <= 1 + frames.next_power_of_two().ilog2() as usize);
            }
        }
    }

    #[test]
    fn spans_that_do_not_end_with_the_last_frame_are_aligned_powers_of_two() {
        let tree = SpanTree::new(60, SpanLevels::Tree);
        for span in (0..60).flat_map(|frame| tree.path(frame)).filter(|span| span.end != 60) {
            assert!(span.len().is_power_of_two() && (span.start as usize).is_multiple_of(span.len()));
        }
    }

    #[test]
    fn the_papers_tree_knows_all_frames_and_one() {
        for levels in [SpanLevels::Paper, SpanLevels::Off] {
            let tree = SpanTree::new(5, levels);
            assert_eq!(tree.path(3), [all_frames(5), one_frame(3)]);
            assert_eq!(tree.children(tree.root()).len(), 5);
            assert_eq!(tree.children(one_frame(2)), []);
        }
    }
}
