//! What is transparent is no sample.
//!
//! Purpose: where a background was cut out of a picture, its depth is often still there, behind pixels without a color of their own.
//!
//! A pixel that is less than half opaque shows mostly what was cut away. A more opaque one at the edge is mixed: its color is freed of
//! what it was mixed with. Where nothing was hit, there is no sky behind a film that is not opaque.

use half::f16;

use crate::capture::frame::INVALID_INVERSE_DEPTH;

/// From here on a pixel is opaque: film filters and rounding to 8 bits leave that much off 1.
const OPAQUE: f32 = 0.99;
/// Less than this is no sample.
const LEAST: f32 = 0.5;

/// How opaque each pixel is, row-major.
#[derive(Clone, Debug)]
pub(crate) struct AlphaPlane {
    /// From 0, transparent, to 1, opaque.
    pub(crate) values: Vec<f32>,
    /// Whether colors are multiplied with it, as in `OpenEXR`.
    pub(crate) is_associated: bool,
}

impl AlphaPlane {
    /// The number of pixels that are no sample because of it; `None` where it says nothing.
    ///
    /// Game engines write 0 everywhere. That is no cut-out if the picture is there all the same: if colors differ under it.
    pub(crate) fn transparent_pixels<C: PartialEq>(&self, colors: &[C]) -> Option<usize> {
        let transparent = self.values.iter().filter(|alpha| !is_sample(**alpha)).count();
        let is_picture = || colors.windows(2).any(|pair| pair[0] != pair[1]);
        (transparent < self.values.len() || !is_picture()).then_some(transparent)
    }

    /// Takes the inverse depth of what is transparent, and frees the colors of what is mixed.
    pub(super) fn cut_out(&self, colors: &mut [[f16; 3]], inverse_depth: &mut [f32]) {
        if self.transparent_pixels(colors).is_none() {
            return;
        }
        for ((alpha, color), inverse) in self.values.iter().zip(colors).zip(inverse_depth) {
            if *alpha >= OPAQUE {
                continue;
            }
            if !is_sample(*alpha) || *inverse == 0.0 {
                *inverse = INVALID_INVERSE_DEPTH;
            } else if self.is_associated {
                let own = |channel: f16| (channel.to_f32() / alpha).min(f16::MAX.to_f32());
                *color = color.map(|channel| f16::from_f32(own(channel)));
            }
        }
    }
}

/// Whether a pixel as opaque as this shows its surface.
fn is_sample(alpha: f32) -> bool {
    alpha >= LEAST
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(value: f32) -> [f16; 3] {
        [f16::from_f32(value); 3]
    }

    /// Colors and inverse depths after cutting out; colors are 0.25, and 0.5 at the last pixel.
    fn cut(values: &[f32], is_associated: bool) -> (Vec<f32>, Vec<f32>) {
        let mut colors = vec![gray(0.25); values.len()];
        colors[values.len() - 1] = gray(0.5);
        let mut inverse_depth = vec![0.5; values.len()];
        inverse_depth[0] = 0.0;
        AlphaPlane { values: values.to_vec(), is_associated }.cut_out(&mut colors, &mut inverse_depth);
        (colors.iter().map(|color| color[0].to_f32()).collect(), inverse_depth)
    }

    #[test]
    fn what_is_transparent_is_no_sample_and_what_is_mixed_has_its_own_color() {
        let alpha = [0.75, 0.0, 0.25, 0.5, 1.0, f32::NAN, 1.0];
        let (colors, inverse_depth) = cut(&alpha, true);
        assert_eq!(inverse_depth, [-1.0, -1.0, -1.0, 0.5, 0.5, -1.0, 0.5]);
        assert_eq!(colors[3..5], [0.5, 0.25]);
        let (colors, _) = cut(&alpha, false);
        assert_eq!(colors[3], 0.25, "PNG keeps colors apart from alpha");
    }
}
