//! The samples that one set has and another lacks, as a camera sees them.

use std::collections::HashMap;

use egui::{Color32, ColorImage};
use glam::{DVec2, DVec3};

use overlook_engine::capture::Camera;
use overlook_engine::capture::sighting::tolerances::MARKED_SURFACE;
use overlook_engine::capture::sighting::{Sighting, look};
use overlook_engine::render::Picture;
use overlook_engine::samples::{SampleSet, TILE};

/// Widest sample, pixels.
const WIDEST: f64 = 12.0;

/// The samples that only the first of two sets has, and those that only the second has, as a camera sees them, in the `color` of a camera;
/// and how many are in view. A picture that is `seen` from a camera hides what lies behind what it shows.
pub(crate) fn differing(
    [before, after]: [&SampleSet; 2],
    camera: &Camera,
    seen: Option<(&Picture, &Camera)>,
    color: fn(usize) -> Color32,
) -> [(ColorImage, u64); 2] {
    let lens = &camera.intrinsics;
    let size = [lens.width as usize, lens.height as usize];
    [(before, after), (after, before)].map(|(of, other)| {
        let pixels = vec![Color32::TRANSPARENT; size[0] * size[1]];
        let splats = Splats { camera, seen, color, size, pixels, count: 0 }.with_all(of, other);
        (ColorImage::new(size, splats.pixels), splats.count)
    })
}

/// Samples as squares of their width.
struct Splats<'a> {
    camera: &'a Camera,
    seen: Option<(&'a Picture, &'a Camera)>,
    color: fn(usize) -> Color32,
    size: [usize; 2],
    pixels: Vec<Color32>,
    count: u64,
}

impl Splats<'_> {
    /// Adds every sample that `other` has not, save those at infinity.
    fn with_all(mut self, of: &SampleSet, other: &SampleSet) -> Self {
        let mut known: HashMap<_, [u16; TILE]> = HashMap::new();
        for image in &other.images {
            for tile in &image.tiles {
                let rows = known.entry((image.camera, tile.tile_x, tile.tile_y)).or_default();
                rows.iter_mut().zip(tile.rows).for_each(|(all, row)| *all |= row);
            }
        }
        for image in &of.images {
            let camera = &of.cameras[image.camera as usize];
            for (index, tile) in image.tiles.iter().enumerate() {
                let known = known.get(&(image.camera, tile.tile_x, tile.tile_y)).copied().unwrap_or_default();
                if tile.rows.iter().zip(known).all(|(row, known)| row & !known == 0) {
                    continue;
                }
                let depths = image.depth.tile(index, tile.first, tile.count());
                for sample in tile.samples() {
                    let inverse_depth = depths.get(sample.index - tile.first as usize);
                    if known[sample.y % TILE] >> (sample.x % TILE) & 1 == 0 && inverse_depth > 0.0 {
                        let center = DVec2::new(sample.x as f64 + 0.5, sample.y as f64 + 0.5);
                        let depth = f64::from(inverse_depth).recip();
                        let width = camera.intrinsics.spread_at(depth) / camera.intrinsics.fx;
                        self.add(camera.unproject(center, depth), width, image.camera as usize);
                    }
                }
            }
        }
        self
    }

    /// Adds a sample of a camera by its place and its width, world units.
    fn add(&mut self, point_in_world: DVec3, width: f64, camera: usize) {
        let to = self.camera;
        let Some((at, depth)) = to.project(point_in_world) else { return };
        let width = width * to.intrinsics.fx / to.intrinsics.spread_at(depth);
        let half = width.clamp(1.0, WIDEST) / 2.0;
        let range = |middle: f64, side: usize| {
            let [first, end] = [middle - half, middle + half].map(|edge| edge.round().max(0.0) as usize);
            first.min(side)..end.min(side)
        };
        let (columns, rows) = (range(at.x, self.size[0]), range(at.y, self.size[1]));
        if columns.is_empty() || rows.is_empty() || self.is_hidden(point_in_world) {
            return;
        }
        self.count += 1;
        let color = (self.color)(camera);
        for y in rows {
            self.pixels[y * self.size[0]..][columns.clone()].fill(color);
        }
    }

    /// Whether the live picture shows something before a point.
    fn is_hidden(&self, point_in_world: DVec3) -> bool {
        self.seen.is_some_and(|(picture, camera)| {
            look(camera, &picture.inverse_depth, point_in_world, MARKED_SURFACE) == Sighting::Nearer
        })
    }
}
