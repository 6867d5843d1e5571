//! Hole filling: colors and inverse depths for pixels that no sample reached, taken from the surface behind.
//!
//! Sources: Gortler, Grzeszczuk, Szeliski and Cohen, *The Lumigraph*, 1996, §3.4 (pull: average to coarser levels; push:
//! fill what is missing from them); Grossman and Dally, *Point Sample Rendering*, 1998 (the same for point samples); Solh
//! and `AlRegib`, *Hierarchical Hole-Filling for Depth-Based View Synthesis*, 2012 (depth: a hole beside a near object is
//! background that the object used to hide, so the near side must stay out of it).
//!
//! What differs: a pyramid in which the farther side always wins grows the near side wherever a coarse cell holds nothing
//! else, and lets a sliver of sky win over a whole wall elsewhere. So the surface is chosen first (`surface`), for every hole
//! pixel by itself, among the painted pixels that it sees across its own hole (`rays`); the pyramid (`pyramid`) then
//! blends colors of that surface alone.
//!
//! ```text
//!      near  near  near |  hole  hole  hole  hole | far  far      across the hole two surfaces face each other: the farther
//!                  ◀──────── p ──────────────────▶                one is what was hidden
//!
//!      near  near | hole | near  near                             one surface on both sides: a gap in it
//! ```
//!
//! The mask is kept: [`Picture::image`] stays [`NO_IMAGE`] in filled pixels, and painted pixels are not touched.

mod pyramid;
mod rays;
mod surface;

use rayon::prelude::*;

use super::vantage::{NO_IMAGE, Picture};
use crate::capture::Camera;
use crate::settings::{Fill, RenderSettings};
use pyramid::Pyramid;
use rays::HoleRays;
use surface::{SurfaceTolerance, WeightedMean, surface_behind};

/// Fills the holes of `picture` as the settings demand. Sets color and inverse depth, which is then 0 or more; [`Picture::image`]
/// stays [`NO_IMAGE`]. A picture without any sample is left as it is.
pub fn fill(picture: &mut Picture, target: &Camera, settings: &RenderSettings) {
    let (width, height) = picture.image.size();
    let image = picture.image.as_slice();
    let is_hole = |image: &u32| *image == NO_IMAGE;
    let nothing_to_do = settings.fill == Fill::None
        || !image.par_iter().with_min_len(4096).any(is_hole)
        || image.par_iter().with_min_len(4096).all(is_hole);
    if nothing_to_do {
        return;
    }
    let tolerance = SurfaceTolerance::new(target, settings);
    let (pyramid, rays) =
        rayon::join(|| Pyramid::pull(picture, tolerance), || HoleRays::cast(image, (width, height)));
    let fill_row = |(y, row): (usize, &[u32])| -> Vec<(usize, WeightedMean)> {
        let fill_pixel = |x| {
            let surface = surface_behind(picture, &rays, (x, y), tolerance);
            Some((x, pyramid.push((x, y), surface.as_ref(), tolerance)?))
        };
        (0..width).filter(|x| is_hole(&row[*x])).filter_map(fill_pixel).collect()
    };
    let filled: Vec<_> = image.par_chunks(width).enumerate().map(fill_row).collect();
    let rows = picture.color.as_mut_slice().par_chunks_mut(width);
    let rows = rows.zip(picture.inverse_depth.as_mut_slice().par_chunks_mut(width));
    rows.zip(filled).for_each(|((colors, inverse_depths), filled)| {
        for (x, filling) in filled {
            (colors[x], inverse_depths[x]) = (filling.color, filling.inverse_depth);
        }
    });
}
