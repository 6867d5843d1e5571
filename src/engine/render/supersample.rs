//! Antialiasing: a picture that is coarser than what the cameras recorded is rendered at a higher resolution and averaged.
//!
//! Purpose: a pixel that covers many samples shows their mean, on all their surfaces. The gather stage by itself averages over
//! sub-pixels of one surface at one depth, and gives a pixel at most two surfaces, those at its center.
//!
//! Source: supersampling on a regular grid with a box filter (Crow, *The Aliasing Problem in Computer-Generated Shaded Images*, CACM
//! 1977). What differs: the grid is as fine as the picture was recorded. In a picture that is no coarser, only edges are supersampled,
//! where that is asked for.

use rayon::prelude::*;

use super::recorded_rates::RecordedRates;
use super::vantage::{NO_IMAGE, Picture, Vantage};
use crate::capture::{Camera, Intrinsics};
use crate::grid::Grid;
use crate::samples::SampleSet;
use crate::settings::{Antialias, Kernel, RenderSettings};

/// From this many recorded pixels along a pixel on the picture is supersampled. Below, interpolation suffices.
const MIN_RATE: f32 = 1.75;

/// Recorded pixels along a pixel of the finer picture, unless [`MAX_FACTOR`] limits it.
const TARGET_RATE: f32 = 1.5;

/// Most columns and rows of the finer picture to a pixel. Gathering averages over the rest.
const MAX_FACTOR: usize = 4;

/// Columns and rows of the finer picture to a pixel where only edges are supersampled.
pub(super) const EDGE_FACTOR: usize = 2;

/// Neighboring pixels show different surfaces if their inverse depths differ by a larger share.
const EDGE_RELATIVE: f32 = 0.02;

/// From this many recorded pixels along a pixel on, silhouettes are found on a z-buffer twice as fine as the picture, and edges can be
/// supersampled.
const LEAST_REFINED_RATE: f32 = 0.65;

/// Most pixels of the finer picture: a picture of 1280×720 at three times its size.
const MAX_FINER_PIXELS: usize = 1 << 23;

/// Whether pictures coarser than the recording are averaged or rendered from coarser samples under these settings. Kernels that are
/// simple on purpose stay so.
pub(crate) fn filters(settings: &RenderSettings) -> bool {
    settings.antialias != Antialias::Off && settings.kernel.interpolates()
}

/// The factor by which the picture's width and height should be multiplied: 1 if it is no coarser than the recording, and for kernels
/// that are simple on purpose.
pub(super) fn supersampling_factor(
    rates: &RecordedRates,
    vantage: &Vantage,
    settings: &RenderSettings,
) -> usize {
    let pixels = vantage.camera.intrinsics.pixel_count();
    if !filters(settings) || pixels == 0 || pixels > MAX_FINER_PIXELS / 4 {
        return 1;
    }
    let rate = rates.of_share(0.5);
    if rate < MIN_RATE {
        return 1;
    }
    let affordable = (MAX_FINER_PIXELS as f64 / pixels as f64).sqrt() as usize;
    ((rate / TARGET_RATE).ceil() as usize).clamp(1, MAX_FACTOR.min(affordable))
}

/// Whether the edges of a picture that is as fine as the recording are supersampled.
pub(super) fn supersamples_edges(
    rates: &RecordedRates,
    vantage: &Vantage,
    settings: &RenderSettings,
) -> bool {
    settings.antialias == Antialias::Supersampled
        && filters(settings)
        && vantage.camera.intrinsics.pixel_count() <= MAX_FINER_PIXELS / (EDGE_FACTOR * EDGE_FACTOR)
        && rates.of_share(0.5) >= LEAST_REFINED_RATE
}

/// A picture with the colors of another one of its size, which was averaged, where neighboring pixels show different surfaces. All else
/// stays as it is: averaging would blur textures that are as fine as the picture.
pub(super) fn with_averaged_edges(picture: &Picture, averaged: &Picture) -> Picture {
    let (width, height) = picture.color.size();
    let is_same = |a: (usize, usize), b: (usize, usize)| {
        let [here, there] = [a, b].map(|at| picture.inverse_depth[at]);
        let is_alike = (picture.image[a] == NO_IMAGE) == (picture.image[b] == NO_IMAGE);
        is_alike && (here - there).abs() <= EDGE_RELATIVE * here.abs().max(there.abs())
    };
    let is_edge = |x: usize, y: usize| {
        let rows = y.saturating_sub(1)..(y + 2).min(height);
        let columns = || x.saturating_sub(1)..(x + 2).min(width);
        rows.flat_map(|row| columns().map(move |column| (column, row))).any(|at| !is_same((x, y), at))
    };
    let mut smooth = picture.clone();
    let rows = smooth.color.as_mut_slice().par_chunks_mut(width.max(1)).enumerate();
    rows.for_each(|(y, row)| {
        for (x, color) in row.iter_mut().enumerate() {
            if picture.shows((x, y)) && averaged.shows((x, y)) && is_edge(x, y) {
                *color = averaged.color[(x, y)];
            }
        }
    });
    smooth
}

/// Pixels of the z-buffer along each side of a pixel of the picture: 2 for the gather kernel, unless the picture is much finer
/// than the recording, where silhouettes are interpolated anyway, or so large that it takes too long.
pub(crate) fn subpixels(samples: &SampleSet, vantage: &Vantage, settings: &RenderSettings) -> usize {
    let pixels = vantage.camera.intrinsics.pixel_count();
    let refines = settings.antialias != Antialias::Off
        && settings.kernel == Kernel::Gather
        && pixels <= MAX_FINER_PIXELS / 4;
    if refines && RecordedRates::of(samples, vantage).of_share(0.5) >= LEAST_REFINED_RATE { 2 } else { 1 }
}

/// The same camera at `factor` times the width and height.
pub(crate) fn finer(camera: &Camera, factor: usize) -> Camera {
    let mut finer = camera.clone();
    let Intrinsics { width, height, fx, fy, cx, cy, .. } = &mut finer.intrinsics;
    for side in [width, height] {
        *side *= factor as u32;
    }
    for length in [fx, fy, cx, cy] {
        *length *= factor as f64;
    }
    finer
}

/// Columns and rows of the pixels in a square of `factor` pixels, the nearest to its center first.
pub(super) fn nearest_to_center(factor: usize) -> Vec<(usize, usize)> {
    let mut order: Vec<(usize, usize)> =
        (0..factor * factor).map(|nth| (nth % factor, nth / factor)).collect();
    let off_center = |at: usize| (2 * at + 1).abs_diff(factor);
    order.sort_by_key(|&(x, y)| off_center(x).pow(2) + off_center(y).pow(2));
    order
}

/// A picture averaged over squares of `factor` pixels. A pixel shows a sample, or the filling of a hole, if half of its square does;
/// depth and image are those nearest its center.
pub(crate) fn averaged(finer: &Picture, factor: usize) -> Picture {
    let (width, height) = (finer.color.width() / factor, finer.color.height() / factor);
    let order = nearest_to_center(factor);
    let pixel = |index: usize| {
        let (left, top) = (index % width * factor, index / width * factor);
        let parts = || order.iter().map(|(x, y)| (left + x, top + y));
        let is_sampled = |at: &(usize, usize)| finer.image[*at] != NO_IMAGE;
        let shown = || parts().filter(|at| finer.shows(*at));
        let (sampled, shows) = (parts().filter(is_sampled).count(), shown().count());
        let middle = match (2 * sampled >= order.len(), 2 * shows >= order.len()) {
            (true, _) => parts().find(is_sampled),
            (false, true) => shown().find(|at| !is_sampled(at)),
            (false, false) => None,
        };
        let Some(at) = middle else { return ([0.0; 3], -1.0, NO_IMAGE) };
        let mut sum = [0.0; 3];
        for part in shown() {
            (0..3).for_each(|channel| sum[channel] += finer.color[part][channel]);
        }
        (sum.map(|sum| sum / shows as f32), finer.inverse_depth[at], finer.image[at])
    };
    let pixels: Vec<([f32; 3], f32, u32)> = (0..width * height).into_par_iter().map(pixel).collect();
    Picture {
        color: Grid::from_vec(width, height, pixels.iter().map(|pixel| pixel.0).collect()),
        inverse_depth: Grid::from_vec(width, height, pixels.iter().map(|pixel| pixel.1).collect()),
        image: Grid::from_vec(width, height, pixels.iter().map(|pixel| pixel.2).collect()),
        ..Picture::empty(0, 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_is_the_mean_of_what_shows_there_and_a_hole_where_less_than_half_does() {
        let mut fine = Picture::empty(6, 2);
        let mut put = |at, red, inverse_depth, image| {
            fine.color[at] = [red, 0.0, 0.0];
            fine.inverse_depth[at] = inverse_depth;
            fine.image[at] = image;
        };
        // Two of four are sampled; of the next all are, of the last one.
        put((1, 0), 0.2, 1.0, 7);
        put((1, 1), 0.6, 2.0, 8);
        for (nth, at) in [(2, 0), (3, 0), (2, 1), (3, 1)].into_iter().enumerate() {
            put(at, nth as f32, 0.5, 3);
        }
        put((4, 0), 1.0, 1.0, 9);
        let small = averaged(&fine, 2);
        assert_eq!(small.color.as_slice(), [[0.4, 0.0, 0.0], [1.5, 0.0, 0.0], [0.0; 3]]);
        assert_eq!(small.inverse_depth.as_slice(), [1.0, 0.5, -1.0]);
        assert_eq!(small.image.as_slice(), [7, 3, NO_IMAGE]);
    }

    #[test]
    fn only_pixels_beside_another_surface_or_a_hole_take_the_color_of_the_averaged_picture() {
        let mut picture = Picture::empty(6, 1);
        let mut averaged = Picture::empty(6, 1);
        for (x, (inverse_depth, image)) in
            [(1.0, 2), (1.0, 2), (1.01, 2), (0.5, 2), (0.5, NO_IMAGE), (0.5, NO_IMAGE)]
                .into_iter()
                .enumerate()
        {
            for (of, red) in [(&mut picture, 0.0), (&mut averaged, 1.0)] {
                of.inverse_depth[(x, 0)] = inverse_depth;
                of.image[(x, 0)] = image;
                of.color[(x, 0)] = [red; 3];
            }
        }
        let smooth = with_averaged_edges(&picture, &averaged);
        let red: Vec<f32> = smooth.color.as_slice().iter().map(|color| color[0]).collect();
        assert_eq!(red, [0.0, 0.0, 1.0, 1.0, 1.0, 0.0]);
        assert_eq!((smooth.inverse_depth, smooth.image), (picture.inverse_depth, picture.image));
    }

    #[test]
    fn what_fills_holes_is_averaged_too_and_stays_a_hole() {
        let mut fine = Picture::empty(3, 3);
        for y in 0..3 {
            fine.inverse_depth[(0, y)] = 0.25;
            fine.inverse_depth[(1, y)] = 0.5;
            fine.color[(1, y)] = [0.0, 3.0, 0.0];
        }
        fine.image[(1, 1)] = 4;
        let small = averaged(&fine, 3);
        assert_eq!((small.image[(0, 0)], small.color[(0, 0)]), (NO_IMAGE, [0.0, 1.5, 0.0]));
        assert_eq!((small.inverse_depth[(0, 0)], small.holes()), (0.5, 1));
    }
}
