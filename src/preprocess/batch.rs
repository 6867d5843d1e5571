//! The frames of a camera that are split together.

use std::sync::Arc;

use super::samples::Span;
use super::static_test::StaticTest;
use crate::capture::Frame;

/// Frames that are looked at together, at most: a power of two, so that a batch is a span of the tree.
pub const BATCH: usize = 16;

/// Frames that follow one another, and what becomes of their spans.
pub(super) struct Batch<'a> {
    pub(super) frames: &'a [Arc<Frame>],
    pub(super) span: Span,
    pub(super) test: &'a StaticTest,
    pub(super) carry: &'a [[Span; 2]],
    pub(super) is_last: bool,
}
