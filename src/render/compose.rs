//! Composition: the foreground of a frame over the background, by depth, and from sums to a picture.
//!
//! Painting foreground over a cached background gives the very picture that painting both anew would give, because both
//! do this: each layer is painted for itself, then the nearer surface wins, and layers that show one surface are blended.

use rayon::prelude::*;

use super::blend::Sum;
use super::frame_samples::FrameSamples;
use super::keys::{inverse_depth_of, slot_of};
use super::vantage::{NO_IMAGE, Picture};
use crate::grid::Grid;

/// What was painted of some images.
#[derive(Clone, Debug, Default)]
pub(super) struct Layer {
    /// See [`super::keys`]; row-major.
    pub(super) keys: Vec<u64>,
    /// Blended colors; empty for kernels that do not blend.
    pub(super) sums: Vec<Sum>,
    /// Samples that were projected.
    pub(super) samples: u64,
}

/// Puts layers together and resolves them to a picture of `width` columns.
pub(super) fn compose(
    layers: [&Layer; 2],
    width: usize,
    surface_ratio: f32,
    frame: &FrameSamples<'_>,
) -> Picture {
    let height = layers[0].keys.len() / width;
    let mut color = vec![[0.0; 3]; width * height];
    let mut inverse_depth = vec![0.0; width * height];
    let mut image = vec![NO_IMAGE; width * height];
    let rows =
        color.par_chunks_mut(width).zip(inverse_depth.par_chunks_mut(width)).zip(image.par_chunks_mut(width));
    rows.enumerate().for_each(|(y, ((colors, depths), images))| {
        for x in 0..width {
            let pixel = y * width + x;
            let key = layers[0].keys[pixel].max(layers[1].keys[pixel]);
            let nearest = inverse_depth_of(key);
            depths[x] = nearest;
            if key == 0 {
                continue;
            }
            images[x] = frame.image_of(slot_of(key));
            let limit = nearest * surface_ratio;
            let mut sum: Sum = [0.0; 4];
            for layer in layers {
                if inverse_depth_of(layer.keys[pixel]) >= limit
                    && let Some(part) = layer.sums.get(pixel)
                {
                    (0..4).for_each(|channel| sum[channel] += part[channel]);
                }
            }
            colors[x] = if sum[3] > 0.0 {
                [sum[0] / sum[3], sum[1] / sum[3], sum[2] / sum[3]]
            } else {
                frame.color_of(slot_of(key))
            };
        }
    });
    Picture {
        color: Grid::from_vec(width, height, color),
        inverse_depth: Grid::from_vec(width, height, inverse_depth),
        image: Grid::from_vec(width, height, image),
    }
}
