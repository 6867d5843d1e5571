//! Reads all images of a store, in parallel as far as they are not predicted from one another.

use rayon::prelude::*;

use super::header::chain;
use super::reader::Store;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::samples::SampleSet;
use crate::store::image::Decoded;

impl Store {
    /// Reads every image. Tiles that are damaged are missing: see [`Store::damage`].
    ///
    /// # Errors
    /// `Io` and `Cancelled`.
    pub fn read_all(&self, job: &Job) -> Result<SampleSet> {
        let count = self.info().images.len();
        job.start("Reading the store", count);
        let depths: Vec<usize> = (0..count)
            .map(|index| chain(&self.info().images, index).map_or(0, |chain| chain.len() - 1))
            .collect();
        let mut decoded: Vec<Option<Decoded>> = vec![None; count];
        // First images that need no other, then images that need one of these, and so on.
        for depth in 0..=depths.iter().copied().max().unwrap_or(0) {
            let ready: Vec<usize> = (0..count).filter(|index| depths[*index] == depth).collect();
            let read = ready.par_iter().map(|&index| {
                job.check()?;
                let before =
                    self.info().images[index].reference.and_then(|before| decoded[before as usize].as_ref());
                let image = self.decode(index, None, before, None)?;
                job.advance(1);
                Ok(image)
            });
            let read: Result<Vec<Decoded>> = read.collect();
            for (index, image) in ready.into_iter().zip(read?) {
                decoded[index] = Some(image);
            }
        }
        let mut samples = self.outline();
        let images = decoded.into_iter().flatten().map(|decoded| decoded.image);
        samples.images = images.filter(|image| !image.is_empty()).collect();
        Ok(samples)
    }

    /// As [`Store::read_all`], where nothing may be damaged.
    ///
    /// # Errors
    /// `Io`, `Invalid` naming what is damaged, `Cancelled`.
    pub fn read_undamaged(&self, job: &Job) -> Result<SampleSet> {
        let read = self.read_all(job)?;
        match self.damage().first() {
            None => Ok(read),
            Some(damage) => Err(Error::invalid(self.path().display(), damage)),
        }
    }
}
