//! Culling: which tiles of samples can touch which rows of the vantage.
//!
//! A tile and the bounds of its depths make a box, `(column, row, inverse depth)`, whose projection lies between those of its
//! eight corners as long as all of them are in front of the vantage. The picture is cut into bands of rows; a band's list
//! holds the tiles that may touch it, in the order of the samples. Each band is painted by one thread into rows of its own: no
//! two threads write to one cache line, no buffer is merged, and sums run in the order of the samples whatever the number of
//! threads.

use std::ops::Range;

use rayon::prelude::*;

use super::frame_samples::{FrameSamples, FrameTile};
use super::project::Projector;
use crate::capture::Camera;
use crate::preprocess::TILE;

/// Pixels `[left, right) × [top, bottom)` of the target that a tile may touch, cut to the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Bounds {
    pub(super) left: u32,
    pub(super) right: u32,
    pub(super) top: u32,
    pub(super) bottom: u32,
}

impl Bounds {
    /// Whether there is no pixel in it.
    pub(super) fn is_empty(self) -> bool {
        self.left >= self.right || self.top >= self.bottom
    }
}

/// Rows of the picture and the tiles that may touch them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Band {
    pub(super) rows: Range<usize>,
    /// Numbers of tiles in [`FrameSamples`], ascending.
    pub(super) tiles: Vec<u32>,
}

/// How far from the projected pixel of a sample its footprint reaches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    /// In target pixels, at least.
    pub(super) pixels: f32,
    /// In projected source pixels.
    pub(super) source_pixels: f32,
}

/// Where a tile may touch the target; empty where it cannot.
fn bounds_of(tile: &FrameTile<'_>, projector: &Projector, target: &Camera, reach: Reach) -> Bounds {
    let (width, height) = (target.intrinsics.width, target.intrinsics.height);
    let (far, near) = tile.depths.bounds();
    let (x, y) = (tile.origin.0 as f32 - 0.5, tile.origin.1 as f32 - 0.5);
    let (mut min, mut max) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
    let (mut nearest_z, mut behind) = (f32::INFINITY, 0);
    for corner in 0..8 {
        let (along, down) = ((corner & 1) as f32 * TILE as f32, (corner >> 1 & 1) as f32 * TILE as f32);
        let w = if corner & 4 == 0 { far } else { near };
        let point = projector.ray(x + along, y + down) + projector.origin * w;
        nearest_z = nearest_z.min(point.z);
        behind += usize::from(point.z <= 0.0);
        for (axis, value) in [point.x / point.z, point.y / point.z].into_iter().enumerate() {
            min[axis] = min[axis].min(value);
            max[axis] = max[axis].max(value);
        }
    }
    if behind == 8 {
        return Bounds::default();
    }
    // A box that reaches behind the vantage may touch everything. So may one whose corners are no numbers.
    let sound = behind == 0 && min.iter().chain(&max).all(|value| value.is_finite());
    if !sound {
        return Bounds { left: 0, right: width, top: 0, bottom: height };
    }
    let grow = reach.pixels + reach.source_pixels * projector.focal_ratio / nearest_z;
    let low = |value: f32, size: u32| (value - grow).floor().clamp(0.0, size as f32) as u32;
    let high = |value: f32, size: u32| (value + grow + 1.0).ceil().clamp(0.0, size as f32) as u32;
    Bounds {
        left: low(min[0], width),
        right: high(max[0], width),
        top: low(min[1], height),
        bottom: high(max[1], height),
    }
}

/// Where each of some tiles may touch the target, in their order.
pub(super) fn bounds(
    frame: &FrameSamples<'_>,
    tiles: Range<usize>,
    projectors: &[Projector],
    target: &Camera,
    reach: Reach,
) -> Vec<Bounds> {
    frame.tiles[tiles]
        .par_iter()
        .with_min_len(512)
        .map(|tile| bounds_of(tile, &projectors[tile.camera as usize], target, reach))
        .collect()
}

/// Cuts the picture into at most `count` bands with about as many tiles each.
pub(super) fn bands(bounds: &[Bounds], first_tile: usize, height: usize, count: usize) -> Vec<Band> {
    let mut middles = vec![0_usize; height];
    for place in bounds.iter().filter(|place| !place.is_empty()) {
        middles[(place.top + place.bottom) as usize / 2] += 1;
    }
    let total: usize = middles.iter().sum();
    let mut bands: Vec<Band> = Vec::new();
    let (mut start, mut found) = (0, 0);
    for (row, middle) in middles.iter().enumerate() {
        found += middle;
        let full = found * count >= total * (bands.len() + 1) && bands.len() + 1 < count;
        if full || row + 1 == height {
            bands.push(Band { rows: start..row + 1, tiles: Vec::new() });
            start = row + 1;
        }
    }
    bands.par_iter_mut().for_each(|band| {
        let touches = |place: &Bounds| {
            !place.is_empty()
                && (place.top as usize) < band.rows.end
                && place.bottom as usize > band.rows.start
        };
        let numbers = bounds.iter().enumerate().filter(|(_, place)| touches(place));
        band.tiles = numbers.map(|(index, _)| (first_tile + index) as u32).collect();
    });
    bands
}
