//! What concerns the readings of a capture.

/// What concerns the readings of a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ReadingCommand {
    /// Open or close the comparison of two readings of the capture.
    Compare(bool),
    /// Copy the keys of the manifest that express the other reading.
    CopyKeys,
}
