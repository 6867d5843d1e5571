//! Composition: the foreground of a frame over the background, by depth, and from sums to a picture.
//!
//! Painting foreground over a cached background gives the very picture that painting both anew would give, because both
//! do this: each layer is splatted for itself, then the nearer surface wins, and layers that show one surface are blended.

use rayon::prelude::*;

use super::splat::{Layer, Sum, inverse_depth_of, mean_color, ordinal_of, surface_limit};
use super::vantage::{NO_IMAGE, Picture};
use crate::capture::Camera;
use crate::grid::Grid;
use crate::settings::RenderSettings;

/// Finds a sample's image and own color by its ordinal.
pub(super) trait Palette: Sync {
    /// Index in `SampleSet::images`, and linear color.
    fn look_up(&self, ordinal: u32) -> (u32, [f32; 3]);
}

/// Puts layers together and resolves them to a picture of `target`'s size.
pub(super) fn compose(
    layers: [&Layer; 2],
    target: &Camera,
    settings: &RenderSettings,
    palette: &impl Palette,
) -> Picture {
    let (width, height) = target.intrinsics.size();
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
            let (found, own_color) = palette.look_up(ordinal_of(key));
            images[x] = found;
            let limit = surface_limit(nearest, target, settings);
            let mut sum: Sum = [0; 4];
            for layer in layers {
                if inverse_depth_of(layer.keys[pixel]) >= limit
                    && let Some(part) = layer.sums.get(pixel)
                {
                    (0..4).for_each(|channel| sum[channel] += part[channel]);
                }
            }
            colors[x] = mean_color(sum).unwrap_or(own_color);
        }
    });
    Picture {
        color: Grid::from_vec(width, height, color),
        inverse_depth: Grid::from_vec(width, height, inverse_depth),
        image: Grid::from_vec(width, height, image),
    }
}
