//! The values of kept samples in their order: what a range of colors is chosen by.

use rayon::prelude::*;

use crate::samples::SampleSet;

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
