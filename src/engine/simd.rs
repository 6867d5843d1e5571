//! Runs hot loops with the widest vector instructions that the processor has.
//!
//! Work is plain Rust that the compiler vectorizes. It is compiled once per level of instructions; the level is chosen at run
//! time. No level contracts or reorders sums, so all give the same bits: a test compares them.
#![expect(
    unsafe_code,
    reason = "a function compiled for more instructions may only be called where they exist; so may one instruction"
)]

use std::sync::atomic::{AtomicUsize, Ordering};

/// Values that a hot loop works on at once: as many as a row of a tile has, and as many `f32` as the widest vector holds.
pub(crate) const LANES: usize = 16;

/// A loop that profits from wide vectors. `run` and what it calls must be `#[inline(always)]`.
pub(crate) trait VectorLoop {
    /// Its result.
    type Output;

    /// Does the work.
    fn run(self) -> Self::Output;
}

/// The level that hot loops may use at most: 0 is what every processor of the target has, 1 is AVX2, 2 is AVX-512. Tests lower it; a loop
/// that is running while it changes gives the same either way.
static LIMIT: AtomicUsize = AtomicUsize::new(2);

/// The widest level that this processor has.
fn best_level() -> usize {
    #[cfg(target_arch = "x86_64")]
    {
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
        usize::from(has_avx2) + usize::from(has_avx512)
    }
    #[cfg(not(target_arch = "x86_64"))]
    0
}

/// The widest instructions that this processor has, by name.
#[must_use]
pub fn widest() -> &'static str {
    ["portable", "avx2", "avx512"][best_level()]
}

/// The level that hot loops use.
fn level() -> usize {
    LIMIT.load(Ordering::Relaxed).min(best_level())
}

/// Does the work with the widest instructions that may be used.
#[inline]
pub(crate) fn run<W: VectorLoop>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    match level() {
        // SAFETY: `level` is no higher than `best_level`, which has just found every feature that `avx512` is compiled for.
        2 => return unsafe { avx512(work) },
        // SAFETY: the same of `avx2`.
        1 => return unsafe { avx2(work) },
        _ => {}
    }
    work.run()
}

/// The union of masks.
#[inline(always)]
pub(crate) fn joined<const N: usize>(bits: &[u32; N]) -> u32 {
    let mut all = 0;
    for i in 0..N {
        all |= bits[i];
    }
    all
}

/// A mask of the indices below [`LANES`] for which `holds`.
#[inline(always)]
pub(crate) fn mask(holds: impl Fn(usize) -> bool) -> u32 {
    let mut bits = [0; LANES];
    for i in 0..LANES {
        bits[i] = u32::from(holds(i)) << i;
    }
    joined(&bits)
}

/// Converts a whole number from 0 to 2²³ − 1. (A cast would compile to sixteen scalar instructions, each with checks.)
#[inline(always)]
pub(crate) fn whole(number: f32) -> u32 {
    (number + 8_388_608.0).to_bits() & 0x7f_ffff
}

/// √(a² + b²), worked out in double precision and rounded once. The C library's `hypotf` would be a call in the middle of a loop.
#[inline(always)]
pub(crate) fn root_of_squares(a: f32, b: f32) -> f32 {
    let (a, b) = (f64::from(a), f64::from(b));
    (a * a + b * b).sqrt() as f32
}

/// Prefetches an element into the cache. Changes no result; does nothing beyond the end or without such an instruction.
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

/// The results of `work` with each set of instructions that the processor has, for tests that compare them. Callers wait for each other.
#[cfg(test)]
pub(crate) fn at_every_level<T>(mut work: impl FnMut() -> T) -> Vec<T> {
    static ONE_AT_A_TIME: std::sync::Mutex<()> = std::sync::Mutex::new(());
    let _guard = ONE_AT_A_TIME.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    // The last is the widest, which is what hot loops use afterwards.
    let with_level = |level| {
        LIMIT.store(level, Ordering::Relaxed);
        work()
    };
    let given: Vec<T> = (0..=best_level()).map(with_level).collect();
    if given.len() == 1 {
        skip::skip(None, "no instruction sets were compared: this processor has one only");
    }
    given
}

/// Shared with the tests that are crates of their own.
#[cfg(test)]
#[path = "../../tests/common/skip.rs"]
pub(crate) mod skip;
