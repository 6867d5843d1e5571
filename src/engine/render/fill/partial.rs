//! Pixels that are shown in part: what fills the hole beside or behind them shows in the rest of them.
//!
//! ```text
//!      near  near | n h | hole  hole        h: the share that no sample covers. It shows what fills the holes beside
//!                   ▲                          the pixel, or the pixel itself if that counts as a hole.
//! ```
//!
//! Source: Porter and Duff, *Compositing Digital Images*, SIGGRAPH 1984 (coverage as alpha; `over`). What differs: what lies below is
//! found by filling.

use rayon::prelude::*;

use crate::render::vantage::{NO_IMAGE, Picture, pixels_around};

/// From this share on a pixel is shown as a whole.
const WHOLE: f32 = 0.999;

/// A pixel that is shown in part.
struct PartialPixel {
    pixel: usize,
    /// Share that is shown, above 0 and below 1.
    share: f32,
    /// Color of this share.
    color: [f32; 3],
}

/// The pixels of a picture that are shown in part.
pub(super) struct PartialPixels(Vec<PartialPixel>);

impl PartialPixels {
    /// Takes the coverage of a picture.
    pub(super) fn take(picture: &mut Picture) -> Self {
        let coverage = std::mem::take(&mut picture.coverage);
        let color = picture.color.as_slice();
        let width = picture.image.width();
        let rows = coverage.par_chunks(width).enumerate();
        let is_partial = |share: f32| share > 0.0 && share < WHOLE;
        let rows = rows.filter(|(_, row)| row.iter().fold(false, |any, share| any | is_partial(*share)));
        let partial = rows.flat_map_iter(|(y, row)| {
            let partial = row.iter().enumerate().filter(|(_, share)| is_partial(**share));
            partial.map(move |(x, share)| {
                let pixel = y * width + x;
                PartialPixel { pixel, share: *share, color: color[pixel] }
            })
        });
        Self(partial.collect())
    }

    /// Puts the shown parts over the filled picture. Pixels without a hole beside them stay as they are.
    pub(super) fn put_over(self, picture: &mut Picture) {
        let composed = |partial: &PartialPixel| {
            let below = filling_at(picture, partial.pixel)?;
            let mix =
                |channel: usize| below[channel] + partial.share * (partial.color[channel] - below[channel]);
            Some((partial.pixel, [0, 1, 2].map(mix)))
        };
        let composed: Vec<_> = self.0.par_iter().filter_map(composed).collect();
        for (pixel, color) in composed {
            picture.color.as_mut_slice()[pixel] = color;
        }
    }
}

/// What fills a pixel that is a hole, else the mean of what fills the holes beside it; `None` without any.
fn filling_at(picture: &Picture, pixel: usize) -> Option<[f32; 3]> {
    let is_filled = |pixel: usize| {
        picture.image.as_slice()[pixel] == NO_IMAGE && picture.inverse_depth.as_slice()[pixel] >= 0.0
    };
    let colors = picture.color.as_slice();
    if picture.image.as_slice()[pixel] == NO_IMAGE {
        return is_filled(pixel).then(|| colors[pixel]);
    }
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for there in pixels_around(pixel, picture.image.size()).filter(|there| is_filled(*there)) {
        (0..3).for_each(|channel| sum[channel] += colors[there][channel]);
        count += 1.0;
    }
    (count > 0.0).then(|| sum.map(|sum| sum / count))
}
