//! Runs hot loops with the widest vector instructions that the processor has.
//!
//! Work is plain Rust that the compiler vectorizes; it is compiled once per level, and the level is chosen at run time. As
//! no level contracts or reorders sums, all give the same bits: a test compares them.
#![expect(
    unsafe_code,
    reason = "a function compiled for more instructions may only be called where they exist; so may one instruction"
)]

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::error::{Error, Result};
use crate::settings::Instructions;

/// A loop that profits from wide vectors. `run` must be `#[inline(always)]`, and so must what it calls.
pub(crate) trait VectorLoop {
    /// What it gives.
    type Output;

    /// Does the work.
    fn run(self) -> Self::Output;
}

/// A set of instructions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum InstructionSet {
    Portable,
    Avx2,
    Avx512,
}

impl InstructionSet {
    const ALL: [Self; 3] = [Self::Portable, Self::Avx2, Self::Avx512];

    /// The widest that this processor has.
    #[cfg(target_arch = "x86_64")]
    fn best() -> Self {
        let has_avx2 = is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt");
        let has_avx512 = has_avx2
            && is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512dq")
            && is_x86_feature_detected!("avx512vl");
        if has_avx512 {
            Self::Avx512
        } else if has_avx2 {
            Self::Avx2
        } else {
            Self::Portable
        }
    }

    /// The widest that this processor has.
    #[cfg(not(target_arch = "x86_64"))]
    fn best() -> Self {
        Self::Portable
    }

    /// The widest that may be used.
    fn allowed() -> Self {
        Self::ALL[LIMIT.load(Ordering::Relaxed).min(2)].min(Self::best())
    }
}

/// The widest level that may be used, as an index of [`InstructionSet::ALL`]. Loops that are at work while it changes give the same
/// either way.
static LIMIT: AtomicUsize = AtomicUsize::new(2);

/// Does `work` while hot loops use no wider instructions than these. One caller at a time has its way.
///
/// # Errors
/// `Unsupported` where the processor lacks them.
pub(crate) fn limited<T>(instructions: Instructions, work: impl FnOnce() -> Result<T>) -> Result<T> {
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    struct Reset;
    impl Drop for Reset {
        fn drop(&mut self) {
            LIMIT.store(2, Ordering::Relaxed);
        }
    }
    let level = match instructions {
        Instructions::Auto => InstructionSet::best(),
        Instructions::Avx512 => InstructionSet::Avx512,
        Instructions::Avx2 => InstructionSet::Avx2,
        Instructions::Portable => InstructionSet::Portable,
    };
    if level > InstructionSet::best() {
        return Err(Error::unsupported(
            format!("instructions '{instructions}'"),
            format!("this processor goes up to '{}'", widest()),
        ));
    }
    let _guard = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    LIMIT.store(level as usize, Ordering::Relaxed);
    let _reset = Reset;
    work()
}

/// The instructions that hot loops use now; never `Auto`.
pub(crate) fn widest() -> Instructions {
    match InstructionSet::allowed() {
        InstructionSet::Portable => Instructions::Portable,
        InstructionSet::Avx2 => Instructions::Avx2,
        InstructionSet::Avx512 => Instructions::Avx512,
    }
}

/// Does the work with the widest instructions that may be used.
pub(crate) fn run<W: VectorLoop>(work: W) -> W::Output {
    run_at(InstructionSet::allowed(), work)
}

/// All bits together.
#[inline(always)]
pub(crate) fn joined<const N: usize>(bits: &[u32; N]) -> u32 {
    let mut all = 0;
    for i in 0..N {
        all |= bits[i];
    }
    all
}

/// A mask of those of sixteen for which `holds`.
#[inline(always)]
pub(crate) fn mask(holds: impl Fn(usize) -> bool) -> u32 {
    let mut bits = [0; 16];
    for i in 0..16 {
        bits[i] = u32::from(holds(i)) << i;
    }
    joined(&bits)
}

/// A whole number from 0 to 2²³ − 1. (A cast would be turned into sixteen scalar instructions, each with checks.)
#[inline(always)]
pub(crate) fn whole(number: f32) -> u32 {
    (number + 8_388_608.0).to_bits() & 0x7f_ffff
}

/// Asks for an element to be fetched into the cache while other work goes on. Changes no result; nothing happens where there
/// is no such element or no such instruction.
#[inline(always)]
pub(crate) fn prefetch<T>(plane: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    if let Some(element) = plane.get(index) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: every x86-64 processor has the instruction, it reads nothing that the program can see, and the address is
        // that of a live reference.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(element).cast()) };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (plane, index);
}

/// Does the work at a level, or at the best there is where that is less.
#[inline]
fn run_at<W: VectorLoop>(level: InstructionSet, work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    match level.min(InstructionSet::best()) {
        InstructionSet::Portable => {}
        // SAFETY: `InstructionSet::best` has just found every feature that `avx2` is compiled for.
        InstructionSet::Avx2 => return unsafe { avx2(work) },
        // SAFETY: `InstructionSet::best` has just found every feature that `avx512` is compiled for.
        InstructionSet::Avx512 => return unsafe { avx512(work) },
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = level;
    work.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn avx2<W: VectorLoop>(work: W) -> W::Output {
    work.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512dq,avx512vl")]
fn avx512<W: VectorLoop>(work: W) -> W::Output {
    work.run()
}

/// What `work` gives with each set of instructions that the processor has, for tests that compare them.
#[cfg(test)]
pub(crate) fn at_every_level<T>(mut work: impl FnMut() -> T) -> Vec<T> {
    let levels = [Instructions::Portable, Instructions::Avx2, Instructions::Avx512];
    let given: Vec<T> = levels.into_iter().filter_map(|level| limited(level, || Ok(work())).ok()).collect();
    if given.len() == 1 {
        skip::skip(None, "no instruction sets were compared: this processor has one only");
    }
    given
}

/// Shared with the tests that are crates of their own.
#[cfg(test)]
#[path = "../tests/common/skip.rs"]
pub(crate) mod skip;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loops_use_no_wider_instructions_than_asked_for_and_the_widest_again_afterwards() {
        let best = InstructionSet::best();
        for instructions in [Instructions::Portable, Instructions::Avx2, Instructions::Avx512] {
            match limited(instructions, || Ok(widest())) {
                Ok(used) => assert_eq!(used, instructions),
                Err(Error::Unsupported { .. }) => assert_ne!(best, InstructionSet::Avx512),
                Err(error) => panic!("{error}"),
            }
        }
    }
}
