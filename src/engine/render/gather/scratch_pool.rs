//! Scratch memory of the gather stage, reused from block to block, picture to picture, by one thread at a time.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::block::GatherScratch;

/// Scratch memory that no thread uses.
#[derive(Debug, Default)]
pub(crate) struct ScratchPool(Mutex<Vec<GatherScratch>>);

/// Scratch memory that returns to its pool when it is dropped.
pub(crate) struct PooledScratch<'a> {
    scratch: Option<GatherScratch>,
    pool: &'a ScratchPool,
}

impl ScratchPool {
    /// Empties the tile caches, for another frame or vantage.
    pub(crate) fn forget(&self) {
        self.idle().iter_mut().for_each(GatherScratch::forget);
    }

    /// The nanoseconds that threads have spent on silhouettes and on look-ups since the last call.
    pub(crate) fn take_spent(&self) -> [u64; 2] {
        let mut all = [0, 0];
        for scratch in self.idle().iter_mut() {
            let spent = std::mem::take(&mut scratch.spent_ns);
            (0..2).for_each(|nth| all[nth] += spent[nth]);
        }
        all
    }

    /// Scratch memory for this many cameras.
    pub(crate) fn borrow(&self, cameras: usize) -> PooledScratch<'_> {
        let scratch = self.idle().pop().filter(|scratch| scratch.camera_count() == cameras);
        PooledScratch { scratch, pool: self }
    }

    fn idle(&self) -> MutexGuard<'_, Vec<GatherScratch>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl PooledScratch<'_> {
    /// The scratch memory; allocated on the first call if the pool had none.
    pub(crate) fn get(&mut self, cameras: usize) -> &mut GatherScratch {
        self.scratch.get_or_insert_with(|| GatherScratch::new(cameras))
    }
}

impl Drop for PooledScratch<'_> {
    fn drop(&mut self) {
        self.pool.idle().extend(self.scratch.take());
    }
}
