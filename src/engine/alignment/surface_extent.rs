//! How far the surface of each pixel reaches around it in the picture, as resolutions that show nothing else there.
//!
//! Purpose: where a surface ends, a coarse pixel mixes its color with that of what lies behind, and so does an antialiased one. What
//! lies behind moves with the viewpoint: it tells neither a pose nor a lens nor an exposure. Source: the chessboard distance transform
//! (A. Rosenfeld and J. L. Pfaltz, *Distance Functions on Digital Pictures*, 1968).

use crate::grid::Grid;
use crate::median::median_f32;

/// A surface ends where inverse depth differs from a neighbor's by more, relative, or by this many times the median difference: noise.
const EDGE_RELATIVE: f32 = 0.03;
const EDGE_MEDIANS: f32 = 8.0;
/// Pixels without depth between pixels of one surface, in a row or column, are a hole of the sensor up to this number.
const MOST_HOLE: usize = 3;
/// Neighbors that are looked at for the median difference.
const PROBES: usize = 4096;

/// For each pixel the number of resolutions, the finest first, that show nothing but its surface around it; 0 without depth. From the
/// least distances on, in pixels, between a pixel and the end of its surface each of them does.
pub(super) fn pure_levels(inverse_depth: &Grid<f32>, least_distances: &[u8]) -> Grid<u8> {
    levels(inverse_depth, least_distances, edge_limit(inverse_depth))
}

/// The number of resolutions that show nothing but surfaces with depth, be it several.
pub(super) fn measured_levels(inverse_depth: &Grid<f32>, least_distances: &[u8]) -> Grid<u8> {
    levels(inverse_depth, least_distances, f32::INFINITY)
}

fn levels(inverse_depth: &Grid<f32>, least_distances: &[u8], limit: f32) -> Grid<u8> {
    let distances = distances(&ends(inverse_depth, limit));
    let of_distance = |distance: u8| least_distances.iter().take_while(|least| distance >= **least).count();
    let pixels = distances.as_slice().iter().zip(inverse_depth.as_slice());
    let levels = pixels.map(|(distance, depth)| if *depth > 0.0 { of_distance(*distance) as u8 } else { 0 });
    Grid::from_vec(inverse_depth.width(), inverse_depth.height(), levels.collect())
}

/// The relative difference from which on neighbors are of two surfaces.
fn edge_limit(inverse_depth: &Grid<f32>) -> f32 {
    let values = inverse_depth.as_slice();
    let step = (values.len() / PROBES).max(1);
    let pairs = values.windows(2).step_by(step).filter(|pair| pair[0] > 0.0 && pair[1] > 0.0);
    let mut differences: Vec<f32> = pairs.map(|pair| difference(pair[0], pair[1])).collect();
    EDGE_RELATIVE.max(EDGE_MEDIANS * median_f32(&mut differences).unwrap_or_default())
}

fn difference(a: f32, b: f32) -> f32 {
    (a - b).abs() / a.max(b)
}

/// The pixels at which a surface ends: beside another surface, and without depth unless in a hole.
fn ends(inverse_depth: &Grid<f32>, limit: f32) -> Grid<bool> {
    let (width, height) = inverse_depth.size();
    let rows = (0..height).map(|y| Line { start: y * width, step: 1, count: width });
    let columns = (0..width).map(|x| Line { start: x, step: width, count: height });
    let lines: Vec<Line> = rows.chain(columns).collect();
    let mut values = inverse_depth.as_slice().to_vec();
    // Rows first: what is filled there serves the columns, so that depth of a coarser lattice leaves no holes.
    for line in &lines {
        line.fill_holes(&mut values, limit);
    }
    let mut ends: Vec<bool> = values.iter().map(|value| *value <= 0.0).collect();
    for Line { start, step, count } in lines {
        for nth in 1..count {
            let [before, here] = [start + (nth - 1) * step, start + nth * step];
            let are_both = values[before] > 0.0 && values[here] > 0.0;
            if are_both && difference(values[before], values[here]) > limit {
                (ends[before], ends[here]) = (true, true);
            }
        }
    }
    Grid::from_vec(width, height, ends)
}

/// Pixels of one row or column.
struct Line {
    start: usize,
    step: usize,
    count: usize,
}

impl Line {
    /// Gives holes between pixels of one surface its inverse depth.
    fn fill_holes(&self, values: &mut [f32], limit: f32) {
        // The last pixel with depth, as a number along the line.
        let mut last: Option<usize> = None;
        for nth in 0..self.count {
            let here = values[self.start + nth * self.step];
            if here == 0.0 {
                last = None;
            }
            if here <= 0.0 {
                continue;
            }
            let hole = last.filter(|last| (1..=MOST_HOLE).contains(&(nth - last - 1)));
            if let Some(last) = hole
                && difference(values[self.start + last * self.step], here) <= limit
            {
                (last + 1..nth).for_each(|inside| values[self.start + inside * self.step] = here);
            }
            last = Some(nth);
        }
    }
}

/// The distance of each pixel from the nearest marked one along rows, columns and diagonals, at most 255.
fn distances(marked: &Grid<bool>) -> Grid<u8> {
    let (width, height) = marked.size();
    let mut distances = Grid::from_fn(width, height, |x, y| if marked[(x, y)] { 0 } else { u8::MAX });
    for y in 0..height {
        for x in 0..width {
            let mut least = distances[(x, y)];
            if x > 0 {
                least = least.min(distances[(x - 1, y)].saturating_add(1));
            }
            for beside in x.saturating_sub(1)..(x + 2).min(width) {
                if y > 0 {
                    least = least.min(distances[(beside, y - 1)].saturating_add(1));
                }
            }
            distances[(x, y)] = least;
        }
    }
    for y in (0..height).rev() {
        for x in (0..width).rev() {
            let mut least = distances[(x, y)];
            if x + 1 < width {
                least = least.min(distances[(x + 1, y)].saturating_add(1));
            }
            for beside in x.saturating_sub(1)..(x + 2).min(width) {
                if y + 1 < height {
                    least = least.min(distances[(beside, y + 1)].saturating_add(1));
                }
            }
            distances[(x, y)] = least;
        }
    }
    distances
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::INVALID_INVERSE_DEPTH;

    /// A surface on the left half of a picture, with a hole of the sensor in its middle.
    fn half(beside: f32) -> Grid<f32> {
        Grid::from_fn(64, 32, |x, y| match (x, y) {
            (12..14, 8..10) => INVALID_INVERSE_DEPTH,
            (0..32, _) => 0.5,
            _ => beside,
        })
    }

    #[test]
    fn coarse_pictures_show_a_surface_alone_only_far_from_its_end_and_holes_are_no_end() {
        for beside in [INVALID_INVERSE_DEPTH, 0.0, 0.3] {
            let levels = pure_levels(&half(beside), &[3, 5, 8, 14]);
            assert_eq!(levels[(10, 16)], 4, "beside {beside}");
            assert_eq!([levels[(13, 8)], levels[(14, 8)]], [0, 4], "beside {beside}");
            let seen = [31, 28, 26, 23, 17].map(|x| levels[(x, 16)]);
            assert_eq!(seen, [0, 1, 2, 3, 4], "beside {beside}");
        }
    }
}
