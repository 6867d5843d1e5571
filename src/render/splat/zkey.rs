//! Z-buffer keys: which sample is nearest in a pixel, in one number that a maximum decides.
//!
//! ```text
//! key of a pixel = [ core: 1 bit | nearness: 31 bits | u32::MAX − slot: 32 bits ]     0: nothing there
//! ```
//! Nearness is the bits of the inverse depth plus one (positive floats order like integers); the larger key is the nearer
//! sample and, of two equally near ones, the one with the smaller slot: the earlier image's. As a maximum does not depend
//! on order, neither does the picture.

/// The bit of a key that marks a core sample: it wins over every fringe sample. Bits of positive floats leave it free.
pub(crate) const CORE: u32 = 1 << 31;

/// The upper half of a key.
#[inline(always)]
pub(crate) fn nearness(inverse_depth: f32, tier: u32) -> u32 {
    (inverse_depth.to_bits() + 1) | tier
}

/// A key from its upper half and the slot.
#[inline(always)]
pub(crate) fn key(nearness: u32, slot: u32) -> u64 {
    u64::from(nearness) << 32 | u64::from(!slot)
}

/// The inverse depth that a key stands for; negative for 0.
#[inline(always)]
pub(crate) fn inverse_depth_of(key: u64) -> f32 {
    match (key >> 32) as u32 & !CORE {
        0 => -1.0,
        nearness => f32::from_bits(nearness - 1),
    }
}

/// The slot that a key stands for.
#[inline(always)]
pub(crate) fn slot_of(key: u64) -> u32 {
    !(key as u32)
}
