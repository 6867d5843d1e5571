//! Scalar values of pixels and samples beside their color: a pressure, a temperature, a number of a grain.
//!
//! They are never averaged nor corrected: what a sample has is what some picture has at its pixel, bit for bit.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};

/// Channels of values that a capture has at most.
pub const MAX_VALUE_CHANNELS: usize = 4;

/// The one number that stands for a value that is missing, whatever NaN a file has.
pub const MISSING_VALUE: f32 = f32::NAN;

/// The share of a channel's range within which two values count as the same, where the manifest does not say.
pub(crate) const DEFAULT_TOLERANCE: f32 = 1.0 / 256.0;

/// What the numbers of one channel mean.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ValueChannel {
    /// Unlike the names of the other channels; not empty.
    pub name: String,
    /// For people; empty where there is none.
    pub unit: String,
    /// Between which values colors run, the first not above the second. Finite. Values may lie outside.
    pub range: [f32; 2],
    /// Values that differ by no more are the same to pruning; at least 0. Finite.
    pub tolerance: f32,
    /// Whether stores keep its values bit for bit; else within half the tolerance.
    pub is_exact: bool,
}

impl ValueChannel {
    /// The number of the channel of a name; `place` is where it was asked for.
    ///
    /// # Errors
    /// `Invalid` with the names there are.
    pub fn named(channels: &[Self], name: &str, place: &str) -> Result<usize> {
        let found = channels.iter().position(|channel| channel.name == name);
        found.ok_or_else(|| {
            let names: Vec<&str> = channels.iter().map(|channel| channel.name.as_str()).collect();
            let what = if names.is_empty() {
                format!("there is no value '{name}': the capture gave none; list them as \"values\" in its manifest")
            } else {
                format!("there is no value '{name}'; there are {}", names.join(", "))
            };
            Error::invalid(place, what)
        })
    }
}

/// Values of pixels or samples, those of one after those of the other. Without channels there are none.
#[derive(Clone, Debug, Default)]
pub struct Values {
    channels: usize,
    values: Vec<f32>,
}

impl PartialEq for Values {
    /// Bit for bit: a missing value equals a missing value.
    fn eq(&self, other: &Self) -> bool {
        self.channels == other.channels
            && bytemuck::cast_slice::<f32, u32>(&self.values)
                == bytemuck::cast_slice::<f32, u32>(&other.values)
    }
}

/// No values, for what has none.
#[cfg(test)]
pub(crate) static NO_VALUES: Values = Values { channels: 0, values: Vec::new() };

impl Values {
    /// Values of `count` pixels, all missing.
    #[must_use]
    pub fn missing(channels: usize, count: usize) -> Self {
        Self { channels, values: vec![MISSING_VALUE; channels * count] }
    }

    /// From one plane a channel, all as long as the first. Whatever is NaN is missing.
    #[must_use]
    pub fn from_planes(planes: &[Vec<f32>]) -> Self {
        let count = planes.first().map_or(0, Vec::len);
        let mut values = Self::missing(planes.len(), count);
        for (channel, plane) in planes.iter().enumerate() {
            let of_channel = values.values.iter_mut().skip(channel).step_by(planes.len());
            for (value, &given) in of_channel.zip(plane) {
                *value = if given.is_nan() { MISSING_VALUE } else { given };
            }
        }
        values
    }

    /// Channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Pixels or samples that have values; 0 without channels.
    #[must_use]
    pub fn len(&self) -> usize {
        self.values.len().checked_div(self.channels).unwrap_or(0)
    }

    /// Whether nothing has values.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Those of one pixel or sample, one a channel; none without channels.
    #[must_use]
    #[inline(always)]
    pub fn of(&self, index: usize) -> &[f32] {
        &self.values[index * self.channels..(index + 1) * self.channels]
    }

    /// The same, to be changed.
    #[inline(always)]
    pub(crate) fn of_mut(&mut self, index: usize) -> &mut [f32] {
        &mut self.values[index * self.channels..(index + 1) * self.channels]
    }

    /// Those of one channel.
    #[must_use]
    pub fn channel(&self, channel: usize) -> impl ExactSizeIterator<Item = f32> + '_ {
        self.values.iter().skip(channel).step_by(self.channels.max(1)).copied()
    }

    /// All of them from one pixel on.
    #[inline(always)]
    pub(crate) fn starting_at(&self, first: usize) -> &[f32] {
        &self.values[first * self.channels..]
    }

    /// Appends those of one more sample. The first ones say how many channels there are.
    #[inline(always)]
    pub(crate) fn push(&mut self, values: &[f32]) {
        self.channels = values.len();
        self.values.extend_from_slice(values);
    }

    /// Appends those of other samples.
    pub(crate) fn extend(&mut self, later: &Self) {
        self.channels = self.channels.max(later.channels);
        self.values.extend_from_slice(&later.values);
    }

    /// Sets those of one pixel; nothing without channels.
    #[inline(always)]
    pub(crate) fn put(&mut self, index: usize, values: &[f32]) {
        if self.channels > 0 && values.len() == self.channels {
            self.values[index * self.channels..(index + 1) * self.channels].copy_from_slice(values);
        }
    }

    /// Those at some places, in their order.
    pub(crate) fn at_places(&self, places: &[u32]) -> Self {
        let values = places.iter().flat_map(|place| self.of(*place as usize)).copied().collect();
        Self { channels: self.channels, values }
    }

    /// Those of some pixels that follow one another, as values of their own.
    pub(crate) fn part_of(&self, pixels: std::ops::Range<usize>) -> Self {
        Self { channels: self.channels, values: self.part(pixels).to_vec() }
    }

    /// Those of some samples that follow one another.
    pub(crate) fn part(&self, samples: std::ops::Range<usize>) -> &[f32] {
        &self.values[samples.start * self.channels..samples.end * self.channels]
    }

    /// Appends values as [`Values::part`] of others with `channels` channels gives them.
    pub(crate) fn extend_part(&mut self, channels: usize, values: &[f32]) {
        self.channels = self.channels.max(channels);
        self.values.extend_from_slice(values);
    }

    /// As bytes of this machine, for temporary files.
    pub(crate) fn as_bytes(&self) -> &[u8] {
        bytemuck::cast_slice(&self.values)
    }

    /// The same, to be filled.
    pub(crate) fn as_bytes_mut(&mut self) -> &mut [u8] {
        bytemuck::cast_slice_mut(&mut self.values)
    }

    /// Bytes in memory.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(self.values.as_slice())
    }
}

/// Whether two values are the same up to a tolerance; one that is missing is the same as one that is missing alone.
#[inline(always)]
pub(crate) fn agree(a: f32, b: f32, tolerance: f32) -> bool {
    a.to_bits() == b.to_bits() || (a - b).abs() <= tolerance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_become_values_of_pixels_and_every_nan_is_the_same_missing_value() {
        let odd = f32::from_bits(0xffc0_1234);
        let values = Values::from_planes(&[vec![1.0, odd, 3.0], vec![4.0, 5.0, f32::INFINITY]]);
        assert_eq!((values.channels(), values.len(), values.of(0)), (2, 3, &[1.0, 4.0][..]));
        assert_eq!(values.of(1)[0].to_bits(), MISSING_VALUE.to_bits());
        assert!(values.channel(1).eq([4.0, 5.0, f32::INFINITY]));
        assert_eq!(values, values.clone());
        assert_eq!(values.at_places(&[2, 0]).of(0), [3.0, f32::INFINITY]);
    }

    #[test]
    fn a_missing_value_agrees_with_a_missing_one_alone_and_others_within_the_tolerance() {
        assert!(agree(MISSING_VALUE, MISSING_VALUE, 0.0));
        assert!(!agree(MISSING_VALUE, 1.0, f32::MAX) && !agree(1.0, MISSING_VALUE, f32::MAX));
        assert!(agree(1.0, 1.5, 0.5) && !agree(1.0, 1.5, 0.25) && agree(2.0, 2.0, 0.0));
        assert!(agree(f32::INFINITY, f32::INFINITY, 0.0) && !agree(f32::INFINITY, 1.0, 1.0));
    }
}
