//! Z-buffer keys: numbers whose maximum is the nearest sample of a pixel.
//!
//! ```text
//! key of a pixel = [ core: 1 bit | trusted: 1 bit | nearness: 30 bits | u32::MAX − slot: 32 bits ]     0: nothing there
//! ```
//! Nearness is the bits of the inverse depth less those of 2⁻⁶⁴, plus one (positive floats order like integers): what is farther than
//! 2⁶⁴ units is infinitely far. The larger key is the nearer
//! sample and, of two equally near ones, that of the smaller slot. A maximum does not depend on the order of its operands, so
//! neither does the picture.

/// The bit of a key that marks a core sample: it wins over every fringe sample.
pub(crate) const CORE: u32 = 1 << 31;

/// The bit of a key that marks a sample that is not doubtful: of two core samples, or two of a fringe, it wins over a doubtful one.
pub(crate) const TRUSTED: u32 = 1 << 30;

/// Both bits.
const TIERS: u32 = CORE | TRUSTED;

/// The bits of 2⁻⁶⁴: what is farther counts as infinitely far. From here on nearness has room for 128 octaves.
const FARTHEST: i32 = (127 - 64) << 23;

/// The nearest that a key can say, just below 2⁶⁴.
const NEAREST: i32 = FARTHEST + TRUSTED as i32 - 2;

/// The upper half of a key. Its bits are compared as a signed number, so that −0 is infinitely far too.
#[inline(always)]
pub(crate) fn nearness(inverse_depth: f32, tier: u32) -> u32 {
    let bits = (inverse_depth.to_bits() as i32).clamp(FARTHEST, NEAREST);
    (bits - (FARTHEST - 1)) as u32 | tier
}

/// A key from its upper half and the slot.
#[inline(always)]
pub(crate) fn key(nearness: u32, slot: u32) -> u64 {
    u64::from(nearness) << 32 | u64::from(!slot)
}

/// The inverse depth of a key; negative for 0.
#[inline(always)]
pub(crate) fn inverse_depth_of(key: u64) -> f32 {
    match (key >> 32) as u32 & !TIERS {
        0 => -1.0,
        1 => 0.0,
        nearness => f32::from_bits(nearness + (FARTHEST - 1) as u32),
    }
}

/// The slot of a key.
#[inline(always)]
pub(crate) fn slot_of(key: u64) -> u32 {
    !(key as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_gives_back_its_inverse_depth_bit_for_bit_in_every_tier() {
        for tier in [0, CORE, TRUSTED, TIERS] {
            for inverse_depth in [0.0, 1e-19, 1e-3, 0.7, 1.0, 2.0, 1.000_000_1, 3e9, 1.8e19] {
                let key = key(nearness(inverse_depth, tier), 77);
                assert_eq!((inverse_depth_of(key), slot_of(key)), (inverse_depth, 77), "{tier:x}");
            }
            for far in [1e-30, -0.0] {
                assert_eq!(inverse_depth_of(key(nearness(far, tier), 0)), 0.0, "farther than keys can say");
            }
            let nearest = inverse_depth_of(key(nearness(f32::MAX, tier), 0));
            assert!(nearest > 1.8e19 && nearest < 1.9e19, "{nearest}");
        }
        assert_eq!(inverse_depth_of(0), -1.0);
    }

    #[test]
    fn core_wins_over_fringe_then_trusted_over_doubtful_then_the_nearer() {
        let ascending =
            [(9.0, 0), (0.0, TRUSTED), (9.0, TRUSTED), (0.0, CORE), (9.0, CORE), (0.0, TIERS), (9.0, TIERS)];
        assert!(ascending.map(|(inverse_depth, tier)| key(nearness(inverse_depth, tier), 0)).is_sorted());
    }
}
