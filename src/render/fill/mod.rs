//! Hole filling: colors and inverse depths for pixels that no sample reached, taken from the surface behind.
//!
//! Sources: Gortler, Grzeszczuk, Szeliski and Cohen, *The Lumigraph*, 1996, §3.4 (pull: average to coarser levels; push:
//! fill what is missing from them); Grossman and Dally, *Point Sample Rendering*, 1998 (the same for point samples); Solh
//! and `AlRegib`, *Hierarchical Hole-Filling for Depth-Based View Synthesis*, 2012 (depth: a hole beside a near object is
//! background that the object used to hide, so the near side must stay out of it).
//!
//! What differs: a pyramid in which the farther side always wins grows the near side wherever a coarse cell holds nothing
//! else, and lets a sliver of sky win over a whole wall elsewhere. So the surface is chosen first, for every hole pixel by
//! itself, among the painted pixels that it sees across its own hole ([`rays`]); the pyramid ([`pyramid`]) then blends
//! colors of that surface alone.
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

use rayon::prelude::*;

use super::vantage::{NO_IMAGE, Picture};
use crate::capture::Camera;
use crate::settings::{Fill, RenderSettings};
use pyramid::{Pyramid, WeightedMean};
use rays::{HoleNeighbors, HoleRays};

/// Widths up to this many times the narrowest one have a say in which surface is behind: in a corner of a near object the
/// narrowest runs from near to near, and only a longer one gets out.
const WIDTHS: f32 = 4.0;

/// Tells surfaces apart by their inverse depths.
#[derive(Clone, Copy, Debug)]
struct Tolerance {
    footprints: f32,
    focal_px: f32,
}

impl Tolerance {
    fn new(target: &Camera, settings: &RenderSettings) -> Self {
        let focal_px = (target.intrinsics.fx * target.intrinsics.fy).sqrt() as f32;
        Self { footprints: settings.depth_tolerance, focal_px }
    }

    /// By which factor inverse depths of one surface may differ over `distance_px`: what the renderer blends within a pixel,
    /// and one footprint more per pixel, which is what a surface at 45° to the line of sight does.
    fn factor(self, distance_px: f32) -> f32 {
        1.0 + (self.footprints + distance_px) / self.focal_px
    }
}

/// The surface that a hole pixel is filled from.
struct Surface {
    /// Smallest and largest inverse depth of it that the pixel sees.
    range: [f32; 2],
    /// The mean of what the pixel sees of it, nearby pixels counting more.
    mean: WeightedMean,
    /// Distance to the remotest painted pixel that it sees of it.
    reach_px: f32,
}

/// What a hole pixel of some row is filled with.
struct Filled {
    x: u32,
    color: [f32; 3],
    inverse_depth: f32,
}

/// Fills the holes of `picture` as the settings say. Color and inverse depth of filled pixels are set and the latter is no
/// longer negative, but [`Picture::image`] still says that no sample reached them. A picture without any sample stays as it is.
/// The result does not depend on the number of threads.
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
    let tolerance = Tolerance::new(target, settings);
    let (pyramid, rays) =
        rayon::join(|| Pyramid::pull(picture, tolerance), || HoleRays::cast(image, (width, height)));
    let filled: Vec<Vec<Filled>> = (0..height)
        .into_par_iter()
        .map(|y| {
            let row = &image[y * width..][..width];
            let mut filled = Vec::with_capacity(row.iter().filter(|image| is_hole(image)).count());
            for x in (0..width).filter(|x| is_hole(&row[*x])) {
                let surface = surface_behind(picture, &rays, (x, y), tolerance);
                if let Some(cell) = pyramid.push((x, y), surface.as_ref(), tolerance) {
                    filled.push(Filled { x: x as u32, color: cell.color, inverse_depth: cell.inverse_depth });
                }
            }
            filled
        })
        .collect();
    let rows = picture.color.as_mut_slice().par_chunks_mut(width);
    let rows = rows.zip(picture.inverse_depth.as_mut_slice().par_chunks_mut(width));
    rows.zip(filled).for_each(|((colors, inverse_depths), filled)| {
        for Filled { x, color, inverse_depth } in filled {
            colors[x as usize] = color;
            inverse_depths[x as usize] = inverse_depth;
        }
    });
}

/// The farthest surface that lies across the hole where it is narrow; `None` where the pixel sees nothing painted.
fn surface_behind(
    picture: &Picture,
    rays: &HoleRays,
    pixel: (usize, usize),
    tolerance: Tolerance,
) -> Option<Surface> {
    let HoleNeighbors { pixel, distance_px } = rays.sight(pixel);
    let inverse_depth = pixel.map(|pixel| picture.inverse_depth.as_slice()[pixel]);
    let pairs = [0, 1, 2, 3].map(|direction| (distance_px[direction], distance_px[direction + 4]));
    let narrowest_px = pairs.iter().map(|(a, b)| a + b).fold(f32::INFINITY, f32::min);
    // A ray that leaves the picture leaves the width open: it counts as if the hole went on as far on that side.
    let width_px = pairs.map(|(a, b)| if (a + b).is_finite() { a + b } else { 2.0 * a.min(b) });
    let mut behind: Option<(f32, f32)> = None;
    for direction in 0..8 {
        let (far, distance_px) = (inverse_depth[direction], distance_px[direction]);
        let counts = distance_px.is_finite() && width_px[direction % 4] <= WIDTHS * narrowest_px;
        if counts && behind.is_none_or(|behind| (far, distance_px) < behind) {
            behind = Some((far, distance_px));
        }
    }
    let (far, far_px) = behind?;
    let mut surface = Surface { range: [far; 2], mean: WeightedMean::EMPTY, reach_px: 0.0 };
    for direction in 0..8 {
        let (near, near_px) = (inverse_depth[direction], distance_px[direction]);
        if near_px.is_finite() && near.max(far) <= near.min(far) * tolerance.factor(near_px + far_px) {
            surface.range = [surface.range[0].min(near), surface.range[1].max(near)];
            surface.reach_px = surface.reach_px.max(near_px);
            let color = picture.color.as_slice()[pixel[direction]];
            surface.mean.add(1.0 / (near_px * near_px), color, near);
        }
    }
    surface.mean = surface.mean.normalized();
    Some(surface)
}
