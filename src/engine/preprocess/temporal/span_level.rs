//! Levels: where on the way from the span of all frames to a single frame a sample lives.

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
