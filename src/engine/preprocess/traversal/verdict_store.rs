//! The verdicts on every camera's samples while some of them wait for others: in memory up to a bound, beyond it in a temporary file.

use std::collections::BTreeMap;

use crate::error::Result;
use crate::preprocess::pruning::{LevelVerdicts, Verdict};
use crate::samples::{Record, RecordPlace, SpillFile};

/// The verdicts on one camera's samples.
#[derive(Debug)]
struct ViewVerdicts {
    pixels: Vec<u32>,
    /// See [`Verdict::to_bits`].
    verdicts: Vec<u64>,
}

impl ViewVerdicts {
    fn of(decided: &LevelVerdicts) -> Self {
        let verdicts = decided.verdicts.iter().map(|verdict| verdict.to_bits());
        Self { pixels: decided.pixels.clone(), verdicts: verdicts.collect() }
    }
}

impl Record for ViewVerdicts {
    /// Samples.
    type RecordShape = usize;

    fn bytes(&self) -> usize {
        self.pixels.len() * (size_of::<u32>() + size_of::<u64>())
    }

    fn shape(&self) -> usize {
        self.pixels.len()
    }

    fn planes(&self) -> Vec<&[u8]> {
        vec![bytemuck::cast_slice(&self.verdicts), bytemuck::cast_slice(&self.pixels)]
    }

    fn read(&samples: &usize, fill: impl FnOnce(&mut [&mut [u8]]) -> Result<()>) -> Result<Self> {
        let mut read = Self { pixels: vec![0; samples], verdicts: vec![0; samples] };
        fill(&mut [
            bytemuck::cast_slice_mut(&mut read.verdicts),
            bytemuck::cast_slice_mut(&mut read.pixels),
        ])?;
        Ok(read)
    }
}

/// Bytes of a verdict and its pixel.
const VERDICT_BYTES: usize = size_of::<Verdict>() + size_of::<u32>();

/// The verdicts on all cameras' samples of one span.
pub(super) struct VerdictStore {
    in_memory: BTreeMap<usize, LevelVerdicts>,
    in_file: BTreeMap<usize, RecordPlace<ViewVerdicts>>,
    /// Bytes that are held in memory, and how many may be.
    held: usize,
    bound: usize,
    file: SpillFile,
}

impl VerdictStore {
    /// No verdicts yet, and at most `bound` bytes of them in memory.
    pub(super) fn new(bound: usize) -> Self {
        let (in_memory, in_file) = (BTreeMap::new(), BTreeMap::new());
        Self { in_memory, in_file, held: 0, bound, file: SpillFile::new(0) }
    }

    /// Takes the verdicts on a camera's samples, in the place of those that were taken out.
    ///
    /// # Errors
    /// `Io` where the temporary file cannot be written.
    pub(super) fn put(&mut self, camera: usize, decided: LevelVerdicts) -> Result<()> {
        let held = self.held.saturating_add(decided.pixels.len() * VERDICT_BYTES);
        if held <= self.bound {
            self.held = held;
            self.in_memory.insert(camera, decided);
            self.in_file.remove(&camera);
            return Ok(());
        }
        let verdicts = ViewVerdicts::of(&decided);
        if let Some(place) = self.in_file.get_mut(&camera) {
            return self.file.replace(place, verdicts);
        }
        self.in_file.insert(camera, self.file.put(verdicts)?);
        Ok(())
    }

    /// Puts verdicts back that were taken out and did not change.
    pub(super) fn put_back(&mut self, camera: usize, decided: LevelVerdicts) {
        if !self.in_file.contains_key(&camera) || decided.pixels.is_empty() {
            self.held += decided.pixels.len() * VERDICT_BYTES;
            self.in_memory.insert(camera, decided);
        }
    }

    /// Takes the verdicts on a camera's samples out, to be put back.
    ///
    /// # Errors
    /// `Io` where the temporary file cannot be read.
    pub(super) fn take(&mut self, camera: usize) -> Result<LevelVerdicts> {
        if let Some(decided) = self.in_memory.remove(&camera) {
            self.held -= decided.pixels.len() * VERDICT_BYTES;
            return Ok(decided);
        }
        let Some(place) = self.in_file.get(&camera) else { return Ok(LevelVerdicts::default()) };
        let stored = self.file.get(place)?;
        Ok(LevelVerdicts {
            pixels: stored.pixels.clone(),
            verdicts: stored.verdicts.iter().map(|bits| Verdict::from_bits(*bits)).collect(),
            ..LevelVerdicts::default()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::preprocess::pruning::Rule;

    #[test]
    fn verdicts_come_back_and_are_replaced_in_memory_and_in_the_file() {
        let verdict = |nth: u32| Verdict {
            rule: Rule::ALL[nth as usize % Rule::ALL.len()],
            witness_level: (nth * 7) as u8,
            witness_camera: (nth * 9001) as u16,
            witness_pixel: nth.wrapping_mul(0x9e37_79b9),
        };
        let decided = |first: u32| LevelVerdicts {
            pixels: (0..50).map(|pixel| pixel * 3).collect(),
            verdicts: (first..first + 50).map(verdict).collect(),
            ..LevelVerdicts::default()
        };
        for bound in [0, 700, usize::MAX] {
            let mut store = VerdictStore::new(bound);
            (0..3).for_each(|camera| store.put(camera, decided(camera as u32)).unwrap());
            for camera in 0..2 {
                store.take(camera).unwrap();
                store.put(camera, decided(100 + camera as u32)).unwrap();
            }
            for (camera, first) in [100, 101, 2].into_iter().enumerate() {
                let (found, put) = (store.take(camera).unwrap(), decided(first));
                assert_eq!((found.pixels, found.verdicts), (put.pixels, put.verdicts));
            }
        }
    }
}
