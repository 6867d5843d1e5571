//! Levels: where on the way from the span of all frames to a single frame a sample lives.

/// Position on the way from the whole sequence to a single frame: 0 is the span of all frames, and every step down is a
/// shorter span inside the one before. A sample's level says when it is decided and what it is held against: samples of one
/// level are decided together, against each other and against those of the levels above, which are decided already.
pub type SpanLevel = u8;

/// The level of the span of all frames.
pub const ROOT: SpanLevel = 0;

/// In place of a level where there is no sample.
pub const NO_SAMPLE: SpanLevel = SpanLevel::MAX;
