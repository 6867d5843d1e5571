//! How far the scalar values of pixels range over a span, and what they are in its first frame.
//!
//! A sample has the values of the first frame of its span, bit for bit: over its other frames they differ by no more than the tolerance.

use crate::capture::{Values, agree};

/// Smallest and largest values, and the first ones, pixel by pixel; empty where the capture has no values.
#[derive(Clone, Debug, Default)]
pub(crate) struct ValueRanges {
    /// A value that is missing in all frames is missing; for one that is missing in some, the range is −∞ to ∞.
    pub(crate) low: Values,
    pub(crate) high: Values,
    pub(crate) first: Values,
}

/// The range over both of two ranges.
fn joined([low, high]: [f32; 2], [other_low, other_high]: [f32; 2]) -> [f32; 2] {
    match (low.is_nan(), other_low.is_nan()) {
        (true, true) => [low, high],
        (false, false) => [low.min(other_low), high.max(other_high)],
        _ => [f32::NEG_INFINITY, f32::INFINITY],
    }
}

impl ValueRanges {
    /// Ranges of one frame.
    pub(super) fn of(values: Values) -> Self {
        Self { low: values.clone(), high: values.clone(), first: values }
    }

    /// Nothing is known of so many pixels.
    pub(super) fn missing(channels: usize, pixels: usize) -> Self {
        Self::of(Values::missing(channels, pixels))
    }

    /// Adds frames that follow.
    pub(super) fn merge(&mut self, later: &Self) {
        for pixel in 0..self.first.len() {
            self.add(pixel, later.low.of(pixel), later.high.of(pixel));
        }
    }

    /// Adds the pixels of the frame that follows.
    pub(super) fn add_frame<'a>(&mut self, values: impl Fn(usize) -> &'a [f32]) {
        for pixel in 0..self.first.len() {
            self.add(pixel, values(pixel), values(pixel));
        }
    }

    fn add(&mut self, pixel: usize, lows: &[f32], highs: &[f32]) {
        let channels = self.first.channels();
        let (own_lows, own_highs) = (self.low.of_mut(pixel), self.high.of_mut(pixel));
        for channel in 0..channels {
            let own = [own_lows[channel], own_highs[channel]];
            [own_lows[channel], own_highs[channel]] = joined(own, [lows[channel], highs[channel]]);
        }
    }

    /// Whether the values of a pixel stay within the tolerances of their channels.
    pub(super) fn is_static(&self, pixel: usize, tolerances: &[f32]) -> bool {
        self.is_static_with(self, pixel, tolerances)
    }

    /// Whether they do so over both spans together.
    pub(super) fn is_static_with(&self, later: &Self, pixel: usize, tolerances: &[f32]) -> bool {
        let of =
            |ranges: &Self, channel: usize| [ranges.low.of(pixel)[channel], ranges.high.of(pixel)[channel]];
        tolerances.iter().enumerate().all(|(channel, tolerance)| {
            let [low, high] = joined(of(self, channel), of(later, channel));
            agree(low, high, *tolerance)
        })
    }
}

/// Whether the values of a pixel over some frames, given frame by frame, stay within the tolerances of their channels.
pub(super) fn are_static<'a>(
    mut frames: impl Iterator<Item = &'a [f32]> + Clone,
    tolerances: &[f32],
) -> bool {
    let Some(first) = frames.next() else { return true };
    tolerances.iter().enumerate().all(|(channel, tolerance)| {
        let own = [first[channel]; 2];
        let range = frames.clone().fold(own, |range, values| joined(range, [values[channel]; 2]));
        agree(range[0], range[1], *tolerance)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::MISSING_VALUE;

    #[test]
    fn a_value_is_static_within_its_tolerance_and_where_it_is_always_missing() {
        let frames = [vec![1.0, MISSING_VALUE, 1.0, 0.0], vec![1.5, MISSING_VALUE, MISSING_VALUE, 2.0]];
        let [first, second] = frames.map(|plane| Values::from_planes(&[plane]));
        let mut ranges = ValueRanges::of(first.clone());
        let later = ValueRanges::of(second.clone());
        let together: Vec<bool> = (0..4).map(|pixel| ranges.is_static_with(&later, pixel, &[0.5])).collect();
        assert_eq!(together, [true, true, false, false]);
        let directly = |pixel| are_static([first.of(pixel), second.of(pixel)].into_iter(), &[0.5]);
        assert_eq!((0..4).map(directly).collect::<Vec<_>>(), together);
        ranges.merge(&later);
        assert_eq!((0..4).map(|pixel| ranges.is_static(pixel, &[0.5])).collect::<Vec<_>>(), together);
        assert_eq!(ranges.first, first);
    }
}
