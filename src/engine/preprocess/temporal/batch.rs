//! The frames of a camera that are split together.

use std::sync::Arc;

use super::staticness::StaticTest;
use crate::capture::Frame;
use crate::samples::Span;

/// Frames that are looked at together, at most: a power of two, so that a batch is a span of the tree.
pub const BATCH: usize = 16;

/// Frames that follow one another, and what becomes of their spans.
pub(crate) struct Batch<'a> {
    pub(crate) frames: &'a [Arc<Frame>],
    pub(crate) span: Span,
    pub(crate) test: &'a StaticTest,
    pub(crate) carry: &'a [[Span; 2]],
    pub(crate) is_last: bool,
}
