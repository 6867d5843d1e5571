//! Colors of scalar values: colormaps that are perceptually uniform and safe for the color-blind, and how a range runs over them.

use std::sync::Arc;

use colorous::{Color, Gradient};
use half::f16;
use rayon::prelude::*;

use crate::color::linear_from_srgb;
use crate::samples::{SampleImage, SampleSet};
use crate::settings::{Colormap, ValueScale};

/// The color of a surface without a value, 8-bit sRGB: a gray that no colormap has.
pub const MISSING_COLOR: [u8; 3] = [128, 128, 128];

/// The color of what is infinitely far and has no value, 8-bit sRGB: another such gray, as light as paper nearly is.
pub const BACKGROUND_COLOR: [u8; 3] = [216, 216, 216];

/// How values become colors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValueColors {
    map: Colormap,
    scale: ValueScale,
    range: [f32; 2],
    /// Values outside are shown as missing ones.
    isolated: Option<[f32; 2]>,
    /// Whether pictures leave out what has no value.
    leaves_out_missing: bool,
}

impl ValueColors {
    /// Colors for a range of values.
    ///
    /// # Errors
    /// In words, where the range has no width or is not finite, and where a logarithmic one is not above 0.
    pub fn new(map: Colormap, scale: ValueScale, range: [f32; 2]) -> Result<Self, String> {
        let [low, high] = range;
        let range = if scale == ValueScale::Symmetric {
            [-low.abs().max(high.abs()), low.abs().max(high.abs())]
        } else {
            range
        };
        if !(range[0].is_finite() && range[1].is_finite() && range[0] < range[1]) {
            return Err(format!(
                "the range from {low} to {high} has no width; give one whose first number is below the second"
            ));
        }
        if scale == ValueScale::Log && range[0] <= 0.0 {
            return Err(format!("the range from {low} to {high} has no logarithm; give one above 0"));
        }
        Ok(Self { map, scale, range, isolated: None, leaves_out_missing: false })
    }

    /// These colors for values from one number to another: all others are shown as missing.
    #[must_use]
    pub fn isolating(self, isolated: [f32; 2]) -> Self {
        Self { isolated: Some(isolated), ..self }
    }

    /// These colors for pictures that are transparent where nothing has a value.
    #[must_use]
    pub fn leaving_out_missing(self) -> Self {
        Self { leaves_out_missing: true, ..self }
    }

    /// Whether pictures are transparent where nothing has a value.
    #[must_use]
    pub fn leaves_out_missing(&self) -> bool {
        self.leaves_out_missing
    }

    /// Whether a value is shown as a missing one.
    #[must_use]
    pub fn is_missing(&self, value: f32) -> bool {
        self.shown_share(value).is_none()
    }

    /// As [`ValueColors::share_of`], of values that are shown: without a logarithm no color would be true.
    fn shown_share(&self, value: f32) -> Option<f64> {
        let is_shown = self.isolated.is_none_or(|[low, high]| (low..=high).contains(&value));
        if value.is_nan() || !is_shown { None } else { self.share_of(value) }
    }

    /// Between which values colors run.
    #[must_use]
    pub fn range(&self) -> [f32; 2] {
        self.range
    }

    /// How the range runs over the colors.
    #[must_use]
    pub fn scale(&self) -> ValueScale {
        self.scale
    }

    /// The value at a share of the range, 0 to 1: what a color bar shows there.
    #[must_use]
    pub fn value_at(&self, share: f32) -> f32 {
        let [low, high] = self.range;
        match self.scale {
            ValueScale::Linear | ValueScale::Symmetric => low + (high - low) * share,
            ValueScale::Log => low * (high / low).powf(share),
        }
    }

    /// The share of the range at which a value lies, 0 to 1; that of the nearer end beyond it. `None` where the value has no logarithm
    /// and needs one.
    #[must_use]
    pub fn share_of(&self, value: f32) -> Option<f64> {
        let along = |at: fn(f64) -> f64| {
            let [low, high] = self.range.map(|end| at(f64::from(end)));
            ((at(f64::from(value)) - low) / (high - low)).clamp(0.0, 1.0)
        };
        match self.scale {
            ValueScale::Linear | ValueScale::Symmetric => Some(along(|value| value)),
            ValueScale::Log => (value > 0.0).then(|| along(f64::ln)),
        }
    }

    /// The color of what has a value, at an inverse depth, 8-bit sRGB: what lies at infinity, or nowhere, and has none is background.
    #[must_use]
    pub fn color_at(&self, value: f32, inverse_depth: f32) -> [u8; 3] {
        if value.is_nan() && inverse_depth <= 0.0 { BACKGROUND_COLOR } else { self.color(value) }
    }

    /// The same, linear Rec.709.
    #[must_use]
    pub fn linear_color_at(&self, value: f32, inverse_depth: f32) -> [f32; 3] {
        self.color_at(value, inverse_depth).map(|channel| linear_from_srgb(f32::from(channel) / 255.0))
    }

    /// The color of a value, 8-bit sRGB. Beyond the range it is that of its end.
    #[must_use]
    pub fn color(&self, value: f32) -> [u8; 3] {
        let Some(share) = self.shown_share(value) else { return MISSING_COLOR };
        let Color { r, g, b } = match gradient(self.map) {
            Some(gradient) => gradient.eval_continuous(share),
            None => category(value),
        };
        [r, g, b]
    }
}

/// The same samples in the colors of one channel of their values.
#[must_use]
pub fn colored_samples(samples: &SampleSet, channel: usize, colors: &ValueColors) -> SampleSet {
    let colored = |image: &Arc<SampleImage>| {
        let of_sample = |(value, w)| colors.linear_color_at(value, w).map(f16::from_f32);
        let depths = image.inverse_depths();
        let color = image.values.channel(channel).zip(depths).map(of_sample).collect();
        Arc::new(SampleImage { color, ..SampleImage::clone(image) })
    };
    SampleSet { images: samples.images.par_iter().map(colored).collect(), ..samples.clone() }
}

/// The colormap of continuous values; `None` for categories.
fn gradient(map: Colormap) -> Option<Gradient> {
    Some(match map {
        Colormap::Viridis => colorous::VIRIDIS,
        Colormap::Cividis => colorous::CIVIDIS,
        Colormap::Magma => colorous::MAGMA,
        Colormap::Inferno => colorous::INFERNO,
        Colormap::Diverging => colorous::PURPLE_ORANGE,
        Colormap::Categories => return None,
    })
}

/// The color of the whole number nearest to a value.
fn category(value: f32) -> Color {
    let colors = colorous::DARK2;
    let count = colors.len() as f64;
    colors[f64::from(value).round().rem_euclid(count) as usize % colors.len()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::MISSING_VALUE;

    fn linear(range: [f32; 2]) -> ValueColors {
        ValueColors::new(Colormap::Viridis, ValueScale::Linear, range).unwrap()
    }

    #[test]
    fn a_range_runs_over_the_colormap_and_what_is_missing_or_left_out_is_gray() {
        let colors = linear([10.0, 20.0]);
        assert_eq!([0.0, 10.0].map(|value| colors.color(value)), [colors.color(f32::NEG_INFINITY); 2]);
        assert_eq!(colors.color(20.0), colors.color(f32::INFINITY));
        assert!(colors.color(10.0) != colors.color(15.0) && colors.color(15.0) != colors.color(20.0));
        assert_eq!(colors.color(MISSING_VALUE), MISSING_COLOR);
        let beside = [(MISSING_VALUE, 0.5), (MISSING_VALUE, 0.0), (12.0, 0.0)]
            .map(|(value, w)| colors.color_at(value, w));
        assert_eq!(beside, [MISSING_COLOR, BACKGROUND_COLOR, colors.color(12.0)]);
        assert!(colors.is_missing(MISSING_VALUE) && !colors.is_missing(25.0));
        let isolated = colors.isolating([12.0, 13.0]);
        assert_eq!([11.9, 13.1].map(|value| isolated.color(value)), [MISSING_COLOR; 2]);
        assert_eq!(isolated.color(12.5), colors.color(12.5));
    }

    #[test]
    fn logarithms_run_evenly_symmetric_ranges_have_their_middle_at_zero_and_categories_are_told_apart() {
        let log = ValueColors::new(Colormap::Viridis, ValueScale::Log, [1.0, 100.0]).unwrap();
        assert_eq!((log.color(10.0), log.color(-1.0)), (linear([0.0, 2.0]).color(1.0), MISSING_COLOR));
        let symmetric = ValueColors::new(Colormap::Diverging, ValueScale::Symmetric, [-1.0, 4.0]).unwrap();
        assert_eq!(symmetric.range(), [-4.0, 4.0]);
        let parts = ValueColors::new(Colormap::Categories, ValueScale::Linear, [0.0, 7.0]).unwrap();
        assert!(parts.color(1.0) != parts.color(2.0) && parts.color(1.0) == parts.color(1.2));
        assert_eq!(parts.color(-1.0), parts.color(7.0));
    }

    #[test]
    fn a_range_that_colors_cannot_run_over_is_refused_in_one_line() {
        for (scale, range) in [
            (ValueScale::Linear, [2.0, 2.0]),
            (ValueScale::Linear, [3.0, 2.0]),
            (ValueScale::Linear, [f32::NAN, 2.0]),
            (ValueScale::Symmetric, [0.0, 0.0]),
            (ValueScale::Log, [0.0, 2.0]),
        ] {
            let error = ValueColors::new(Colormap::Viridis, scale, range).unwrap_err();
            assert!(!error.contains('\n') && error.contains("give one"), "{error}");
        }
    }
}
