//! Z-buffer keys: numbers whose maximum is the nearest sample of a pixel.
//!
//! ```text
//! key of a pixel = [ core: 1 bit | nearness: 31 bits | u32::MAX − slot: 32 bits ]     0: nothing there
//! ```
//! Nearness is the bits of the inverse depth plus one (positive floats order like integers). The larger key is the nearer
//! sample and, of two equally near ones, that of the smaller slot. A maximum does not depend on the order of its operands, so
//! neither does the picture.

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

/// The inverse depth of a key; negative for 0.
#[inline(always)]
pub(crate) fn inverse_depth_of(key: u64) -> f32 {
    match (key >> 32) as u32 & !CORE {
        0 => -1.0,
        nearness => f32::from_bits(nearness - 1),
    }
}

/// The slot of a key.
#[inline(always)]
pub(crate) fn slot_of(key: u64) -> u32 {
    !(key as u32)
}
