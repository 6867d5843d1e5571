//! What is known of a sample while pruning goes on.

use std::sync::atomic::AtomicU8;

use crate::preprocess::layers::CameraLayer;

/// No sample at the pixel that could be a witness.
pub(super) const ABSENT: u8 = 0;
/// PendingSample for better samples to be decided.
pub(crate) const UNDECIDED: u8 = 1;
/// Stays.
pub(crate) const KEPT: u8 = 2;
/// Was dropped.
pub(crate) const DROPPED: u8 = 3;

/// Whether each pixel of each camera holds a kept sample: [`ABSENT`], [`KEPT`] or [`DROPPED`].
pub(crate) type Statuses = Vec<Vec<AtomicU8>>;

/// Statuses in which nothing is decided yet.
pub(crate) fn no_statuses(layers: &[CameraLayer]) -> Statuses {
    layers.iter().map(|layer| layer.level.iter().map(|_| AtomicU8::new(ABSENT)).collect()).collect()
}
