//! How the values of kept samples are spread: what a range of colors is chosen by.

use rayon::prelude::*;

use crate::samples::SampleSet;

/// How many samples have which values.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ValueHistogram {
    /// Samples in bins of equal width, from the low end of the range to the high one; both ends included.
    pub counts: Vec<u64>,
    /// Samples with a value below the range, and above it.
    pub outside: [u64; 2],
    /// Samples whose value is missing.
    pub missing: u64,
}

impl ValueHistogram {
    /// The values of one channel of the samples that hold at a frame, in `bins` bins of a range, whose first number is below the second.
    /// The same for any number of threads. All are outside or missing where `bins` is 0.
    #[must_use]
    pub fn of(samples: &SampleSet, frame: usize, channel: usize, [low, high]: [f32; 2], bins: usize) -> Self {
        let empty = || Self { counts: vec![0; bins], ..Self::default() };
        let per_value = bins as f64 / (f64::from(high) - f64::from(low));
        let images: Vec<_> = samples.images_at(frame).collect();
        let of_image = |mut found: Self, values: &crate::capture::Values| {
            for value in values.channel(channel) {
                if value.is_nan() {
                    found.missing += 1;
                } else if bins > 0 && (low..=high).contains(&value) {
                    let bin = (f64::from(value) - f64::from(low)) * per_value;
                    found.counts[(bin as usize).min(bins - 1)] += 1;
                } else {
                    found.outside[usize::from(value > high)] += 1;
                }
            }
            found
        };
        let of_images = images.par_iter().map(|image| of_image(empty(), &image.values));
        of_images.reduce(empty, |sum, image| sum.plus(&image))
    }

    fn plus(mut self, other: &Self) -> Self {
        let sum =
            |own: &mut [u64], other: &[u64]| own.iter_mut().zip(other).for_each(|(own, other)| *own += other);
        sum(&mut self.counts, &other.counts);
        sum(&mut self.outside, &other.outside);
        self.missing += other.missing;
        self
    }
}

/// The value below which a share (0 to 1) of some lies, which ascend: one of them. `None` without any.
#[must_use]
pub fn ranked_value(ascending: &[f32], share: f32) -> Option<f32> {
    let last = ascending.len().checked_sub(1)?;
    ascending.get((share * last as f32).round() as usize).copied()
}

/// The values of one channel of the samples that hold, without missing and infinite ones.
#[must_use]
pub fn kept_values(samples: &SampleSet, frame: usize, channel: usize) -> Vec<f32> {
    let of_images = samples.images_at(frame).flat_map(|image| image.values.channel(channel));
    let mut values: Vec<f32> = of_images.filter(|value| value.is_finite()).collect();
    values.par_sort_unstable_by(f32::total_cmp);
    values
}
