//! The verdicts on every view's samples while some of them wait for others: in memory up to a bound, beyond it in a temporary file.

use std::collections::BTreeMap;

use crate::error::Result;
use crate::preprocess::pruning::{LevelVerdicts, Verdict};
use crate::samples::{Record, RecordPlace, SpillFile, samples_in_memory};
use crate::settings::Settings;

/// The verdicts on one view's samples.
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

/// The verdicts on all views' samples.
pub(super) struct VerdictStore {
    places: BTreeMap<usize, RecordPlace<ViewVerdicts>>,
    spill: SpillFile,
}

impl VerdictStore {
    pub(super) fn new(settings: &Settings) -> Self {
        Self { places: BTreeMap::new(), spill: SpillFile::new(samples_in_memory(settings)) }
    }

    /// Takes the verdicts on a view's samples.
    ///
    /// # Errors
    /// `Io` where the temporary file cannot be written.
    pub(super) fn put(&mut self, camera: usize, decided: &LevelVerdicts) -> Result<()> {
        let place = self.spill.put(ViewVerdicts::of(decided))?;
        self.places.insert(camera, place);
        Ok(())
    }

    /// Takes other verdicts on the same samples.
    ///
    /// # Errors
    /// As [`VerdictStore::put`].
    pub(super) fn replace(&mut self, camera: usize, decided: &LevelVerdicts) -> Result<()> {
        let Some(place) = self.places.get_mut(&camera) else { return Ok(()) };
        self.spill.replace(place, ViewVerdicts::of(decided))
    }

    /// The verdicts on a view's samples.
    ///
    /// # Errors
    /// `Io` where the temporary file cannot be read.
    pub(super) fn get(&self, camera: usize) -> Result<LevelVerdicts> {
        let Some(place) = self.places.get(&camera) else { return Ok(LevelVerdicts::default()) };
        let stored = self.spill.get(place)?;
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
            let mut store = VerdictStore { places: BTreeMap::new(), spill: SpillFile::new(bound) };
            (0..3).for_each(|view| store.put(view, &decided(view as u32)).unwrap());
            (0..2).for_each(|view| store.replace(view, &decided(100 + view as u32)).unwrap());
            for (view, first) in [100, 101, 2].into_iter().enumerate() {
                let (found, put) = (store.get(view).unwrap(), decided(first));
                assert_eq!((found.pixels, found.verdicts), (put.pixels, put.verdicts));
            }
        }
    }
}
