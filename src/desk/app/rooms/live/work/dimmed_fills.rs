//! Dims what fills holes far from any sample, so that it reads as unknown and not as a part of the scene.
//!
//! Purpose: a fill beside a sample is a good guess, one in the middle of a large hole is none. The farther a filled pixel is from what
//! cameras saw, the more it shows of a blurred, gray and darker copy of the fills around it. Pixels that a sample reached, and the sky, stay
//! as they are. Sources: distances after G. Borgefors, 1986 (the 3-4 chamfer); the blur is a box of running sums (M. J. `McDonnell`, 1981). What
//! differs: only filled pixels are averaged, so that nothing of the picture bleeds into what is unknown.

use egui::Color32;
use rayon::prelude::*;

use crate::app::colormap::{dimmed, mix};
use overlook_engine::grid::Grid;
use overlook_engine::render::{NO_IMAGE, Picture};

/// Distances from the nearest pixel that is known, as shares of the picture's larger side: up to the first a fill stays as it is, from the
/// second on it is unknown.
const FAR: [f32; 2] = [0.004, 0.03];

/// Half of the side of the blur, as a share of the picture's larger side.
const BLUR: f32 = 0.012;

/// Brightness of what is unknown, and how gray it is.
const BRIGHTNESS: f32 = 0.45;
const GRAY: f32 = 0.75;

/// Steps of the chamfer to a neighbor beside a pixel and to one at its corner; the first is the length of a pixel.
const STEPS: [u32; 2] = [3, 4];

/// Changes the colors of a picture as it is displayed.
pub(super) fn dim_fills(picture: &Picture, colors: &mut Grid<Color32>) {
    let (width, height) = colors.size();
    let is_fill: Vec<bool> = (picture.image.as_slice().iter().zip(picture.inverse_depth.as_slice()))
        .map(|(image, inverse_depth)| *image == NO_IMAGE && *inverse_depth > 0.0)
        .collect();
    if !is_fill.contains(&true) {
        return;
    }
    let side = width.max(height) as f32;
    let distances = distances(&is_fill, width, height);
    let radius = (BLUR * side).ceil() as usize;
    // Sums over each pixel's neighbors in its row, of fills alone: red, green, blue and their count.
    let mut rows = vec![[0_u32; 4]; width * height];
    rows.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        let at = |x: usize| channels(colors.as_slice()[y * width + x], is_fill[y * width + x]);
        let mut sum = [0; 4];
        (0..radius.min(width)).for_each(|x| add(&mut sum, at(x)));
        for (x, place) in row.iter_mut().enumerate() {
            if x + radius < width {
                add(&mut sum, at(x + radius));
            }
            if let Some(gone) = x.checked_sub(radius + 1) {
                subtract(&mut sum, at(gone));
            }
            *place = sum;
        }
    });
    let mut sums = vec![[0_u32; 4]; width];
    let row = |y: usize| &rows[y * width..(y + 1) * width];
    let add_row = |sums: &mut [[u32; 4]], y: usize| {
        sums.iter_mut().zip(row(y)).for_each(|(sum, more)| add(sum, *more));
    };
    (0..radius.min(height)).for_each(|y| add_row(&mut sums, y));
    for y in 0..height {
        if y + radius < height {
            add_row(&mut sums, y + radius);
        }
        if let Some(gone) = y.checked_sub(radius + 1) {
            sums.iter_mut().zip(row(gone)).for_each(|(sum, less)| subtract(sum, *less));
        }
        for (x, [red, green, blue, count]) in sums.iter().enumerate() {
            let place = y * width + x;
            let unknown = unknown(distances[place], side);
            if unknown > 0.0 {
                let mean = [red, green, blue].map(|channel| ((channel + count / 2) / count.max(&1)) as u8);
                let mean = Color32::from_rgb(mean[0], mean[1], mean[2]);
                let gray = mix(mean, dimmed(mean, BRIGHTNESS), GRAY);
                colors[(x, y)] = mix(colors[(x, y)], gray, unknown);
            }
        }
    }
}

fn channels(color: Color32, is_fill: bool) -> [u32; 4] {
    if is_fill { [color.r().into(), color.g().into(), color.b().into(), 1] } else { [0; 4] }
}

fn add(sum: &mut [u32; 4], more: [u32; 4]) {
    sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
}

fn subtract(sum: &mut [u32; 4], less: [u32; 4]) {
    sum.iter_mut().zip(less).for_each(|(sum, less)| *sum -= less);
}

/// How unknown a pixel at this distance is, from 0 to 1, smoothly.
fn unknown(distance: u32, side: f32) -> f32 {
    let share = distance as f32 / STEPS[0] as f32 / side;
    let along = ((share - FAR[0]) / (FAR[1] - FAR[0])).clamp(0.0, 1.0);
    along * along * (3.0 - 2.0 * along)
}

/// The distance of each pixel from the nearest one that is no fill, in thirds of a pixel.
fn distances(is_fill: &[bool], width: usize, height: usize) -> Vec<u32> {
    let farthest = STEPS[1] * (width + height) as u32;
    let mut distances: Vec<u32> = is_fill.iter().map(|is_fill| if *is_fill { farthest } else { 0 }).collect();
    let [beside, corner] = STEPS;
    let mut relax = |x: usize, y: usize, is_forward: bool| {
        let step: i64 = if is_forward { -1 } else { 1 };
        let mut nearest = distances[y * width + x];
        for (dx, dy, length) in [(step, 0, beside), (0, step, beside), (-1, step, corner), (1, step, corner)]
        {
            let (x, y) = (x as i64 + dx, y as i64 + dy);
            if (0..width as i64).contains(&x) && (0..height as i64).contains(&y) {
                nearest = nearest.min(distances[y as usize * width + x as usize] + length);
            }
        }
        distances[y * width + x] = nearest;
    };
    for y in 0..height {
        (0..width).for_each(|x| relax(x, y, true));
    }
    for y in (0..height).rev() {
        (0..width).rev().for_each(|x| relax(x, y, false));
    }
    distances
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture of a sample at its left and right sides and a fill in between, checkered in red.
    fn picture(width: usize) -> (Picture, Grid<Color32>) {
        let mut picture = Picture::empty(width, 8);
        picture.inverse_depth = Grid::filled(width, 8, 0.5);
        let is_sample = |x: usize| x < width / 8 || x >= width - width / 8;
        picture.image = Grid::from_fn(width, 8, |x, _| if is_sample(x) { 0 } else { NO_IMAGE });
        let colors =
            Grid::from_fn(width, 8, |x, y| Color32::from_rgb(100 + 100 * ((x + y) % 2) as u8, 40, 40));
        (picture, colors)
    }

    #[test]
    fn only_fills_far_from_samples_are_dimmed_and_blurred() {
        let (picture, own) = picture(400);
        let mut colors = own.clone();
        dim_fills(&picture, &mut colors);
        let same = |x: usize| (0..8).all(|y| colors[(x, y)] == own[(x, y)]);
        assert!((0..51).chain(349..400).all(same), "samples, and fills beside them");
        let [one, next] = [200, 201].map(|x| colors[(x, 4)]);
        assert!(one.r() < 90 && one.r().abs_diff(next.r()) < 12, "{one:?} {next:?}");
        let saturation = |color: Color32| color.r() - color.g();
        assert!(saturation(one) < saturation(own[(200, 4)]) && saturation(one) > 0, "{one:?}");
    }

    #[test]
    fn the_sky_and_pictures_without_samples_have_distances_too() {
        let (mut picture, own) = picture(400);
        picture.inverse_depth = Grid::filled(400, 8, 0.0);
        let mut colors = own.clone();
        dim_fills(&picture, &mut colors);
        assert!(colors.as_slice() == own.as_slice(), "the sky stays as it is");
        picture.inverse_depth = Grid::filled(400, 8, 0.5);
        picture.image = Grid::filled(400, 8, NO_IMAGE);
        dim_fills(&picture, &mut colors);
        assert!(colors.as_slice().iter().all(|color| color.r() < 90), "all is unknown");
        let is_fill = [false, true, true, true, true, true, true, true, true];
        assert_eq!(distances(&is_fill, 3, 3), [0, 3, 6, 3, 4, 7, 6, 7, 8]);
    }
}
