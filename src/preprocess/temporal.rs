//! Temporal redundancy.

/// Threshold-independent facts about every pixel over all frames.
#[derive(Debug)]
pub struct TemporalScan {}
