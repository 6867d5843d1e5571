//! Runs hot loops with the widest vector instructions that the processor has.
//!
//! Work is plain Rust that the compiler vectorizes; it is compiled once per level, and the level is chosen at run time. As
//! no level contracts or reorders sums, all give the same bits: a test compares them.
#![expect(
    unsafe_code,
    reason = "a function compiled for more instructions may only be called where they exist; so may one instruction"
)]

/// A loop that profits from wide vectors. `run` must be `#[inline(always)]`, and so must what it calls.
pub(crate) trait Work {
    /// What it gives.
    type Output;

    /// Does the work.
    fn run(self) -> Self::Output;
}

/// A set of instructions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Level {
    /// What every processor of the target has.
    Portable,
    /// AVX2 and what comes with it.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// AVX-512 with byte, word, doubleword and shorter vectors.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Level {
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
}

/// Does the work at the best level.
pub(crate) fn run<W: Work>(work: W) -> W::Output {
    #[cfg(test)]
    if PORTABLE.load(std::sync::atomic::Ordering::Relaxed) {
        return run_at(Level::Portable, work);
    }
    run_at(Level::best(), work)
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
fn run_at<W: Work>(level: Level, work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    match level.min(Level::best()) {
        Level::Portable => {}
        // SAFETY: `Level::best` has just found every feature that `avx2` is compiled for.
        Level::Avx2 => return unsafe { avx2(work) },
        // SAFETY: `Level::best` has just found every feature that `avx512` is compiled for.
        Level::Avx512 => return unsafe { avx512(work) },
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = level;
    work.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
fn avx2<W: Work>(work: W) -> W::Output {
    work.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512bw,avx512dq,avx512vl")]
fn avx512<W: Work>(work: W) -> W::Output {
    work.run()
}

/// Whether every loop runs at the lowest level. Other tests may see it: they give the same either way.
#[cfg(test)]
static PORTABLE: std::sync::atomic::AtomicBool = std::sync::atomic::AtomicBool::new(false);

/// What `work` gives at the best level and at the lowest, for tests that compare them.
#[cfg(test)]
pub(crate) fn at_best_and_portable<T>(mut work: impl FnMut() -> T) -> [T; 2] {
    static ONE_AT_A_TIME: std::sync::Mutex<()> = std::sync::Mutex::new(());
    let _guard = ONE_AT_A_TIME.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let best = work();
    PORTABLE.store(true, std::sync::atomic::Ordering::Relaxed);
    let portable = work();
    PORTABLE.store(false, std::sync::atomic::Ordering::Relaxed);
    [best, portable]
}
