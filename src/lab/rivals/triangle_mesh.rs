//! A triangle mesh for each camera, rasterized at the viewpoint and blended.
//!
//! Source: S. Fachada, D. Bonatto, A. Schenkel and G. Lafruit, *Depth Image Based View Synthesis with Multiple Reference Views for
//! Virtual Reality*, 3DTV-CON 2018, as in MPEG's Reference View Synthesizer (RVS). Pixel centers are corners of triangles, two for each
//! four pixels, even across a step in depth. The quality of a triangle falls with its longest edge at the viewpoint, and a triangle
//! that faces away is left out. Where triangles of one camera overlap, the cube of depth over quality decides. Cameras are blended by
//! quality over depth, to the fifth power. Everything is rasterized twice as fine in both directions and averaged (RVS's precision 2).
//!
//! What differs: a pixel at infinity is put a thousand times as far away as the farthest surface of its picture, since RVS has no infinity;
//! one without depth belongs to no triangle. Colors are blended sRGB-encoded, as RVS blends the values of a video.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::model::{RecordedView, RivalModel};
use overlook_engine::capture::Camera;
use overlook_engine::color::{linear_from_srgb, srgb_from_linear};
use overlook_engine::grid::Grid;
use overlook_engine::render::{NO_IMAGE, Picture};

/// Columns and rows of the raster to a pixel.
const PRECISION: usize = 2;

/// Quality of a triangle of no extent, and its loss for each pixel of the longest edge; the least quality is 1.
const BEST_QUALITY: f32 = 10_000.0;
const LOST_PER_PIXEL: f32 = 1_000.0;

/// Power of quality over depth by which cameras are blended.
const BLENDING_EXPONENT: i32 = 5;

/// Distance of pixels at infinity, in depths of the farthest surface.
const INFINITY_FACTOR: f64 = 1_000.0;

/// Cameras that are rasterized at a time.
const AT_A_TIME: usize = 4;

/// All views; their meshes are implied by their depth.
pub(super) struct TriangleMeshes(Vec<RecordedView>);

/// A corner: where it appears, its depth there, and its encoded color.
#[derive(Clone, Copy)]
struct Corner {
    at: DVec2,
    depth: f32,
    color: [f32; 3],
}

/// One camera's mesh at the viewpoint; quality is 0 outside of it.
struct Raster {
    color: Grid<[f32; 3]>,
    depth: Grid<f32>,
    quality: Grid<f32>,
}

impl TriangleMeshes {
    pub(super) fn new(views: &[RecordedView]) -> Self {
        Self(views.to_vec())
    }
}

impl RivalModel for TriangleMeshes {
    fn render(&self, target: &Camera) -> Picture {
        let (width, height) = target.intrinsics.size();
        let size = (width * PRECISION, height * PRECISION);
        // Sums of weighted encoded color, of weights, and of weighted inverse depth.
        let mut sums = Grid::filled(size.0, size.1, [0.0_f64; 5]);
        for views in self.0.chunks(AT_A_TIME) {
            let rasters: Vec<Raster> = views.par_iter().map(|view| rasterized(view, target, size)).collect();
            for raster in &rasters {
                blend(&mut sums, raster);
            }
        }
        averaged(&sums, (width, height))
    }

    fn bytes(&self) -> Option<u64> {
        None
    }
}

/// Adds a camera's raster by its weights.
fn blend(sums: &mut Grid<[f64; 5]>, raster: &Raster) {
    let planes =
        raster.color.as_slice().par_iter().zip(raster.depth.as_slice()).zip(raster.quality.as_slice());
    sums.as_mut_slice().par_iter_mut().zip(planes).for_each(|(sum, ((color, depth), quality))| {
        if *quality > 0.0 {
            let weight = f64::from(quality / depth).powi(BLENDING_EXPONENT);
            for channel in 0..3 {
                sum[channel] += weight * f64::from(color[channel]);
            }
            sum[3] += weight;
            sum[4] += weight / f64::from(*depth);
        }
    });
}

/// Means over the raster's pixels; a pixel shows something if at least half of its raster does.
fn averaged(sums: &Grid<[f64; 5]>, (width, height): (usize, usize)) -> Picture {
    let mut picture = Picture::empty(width, height);
    for y in 0..height {
        for x in 0..width {
            let (mut mean, mut count) = ([0.0; 4], 0_usize);
            for part in 0..PRECISION * PRECISION {
                let sum = sums[(x * PRECISION + part % PRECISION, y * PRECISION + part / PRECISION)];
                if sum[3] > 0.0 {
                    count += 1;
                    for (mean, value) in mean.iter_mut().zip([sum[0], sum[1], sum[2], sum[4]]) {
                        *mean += value / sum[3];
                    }
                }
            }
            if 2 * count >= PRECISION * PRECISION {
                let [r, g, b, inverse_depth] = mean.map(|sum| (sum / count as f64) as f32);
                picture.color[(x, y)] = [r, g, b].map(linear_from_srgb);
                picture.inverse_depth[(x, y)] = inverse_depth;
                picture.image[(x, y)] = 0;
            }
        }
    }
    debug_assert!(picture.image.as_slice().iter().all(|image| [0, NO_IMAGE].contains(image)));
    picture
}

/// The mesh of one view at the viewpoint.
fn rasterized(view: &RecordedView, target: &Camera, (width, height): (usize, usize)) -> Raster {
    let mut raster = Raster {
        color: Grid::filled(width, height, [0.0; 3]),
        depth: Grid::filled(width, height, f32::INFINITY),
        quality: Grid::filled(width, height, 0.0),
    };
    let corners = corners(view, target);
    let (columns, rows) = corners.size();
    for y in 0..rows.saturating_sub(1) {
        for x in 0..columns.saturating_sub(1) {
            let [top_left, top_right, bottom_left, bottom_right] =
                [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)].map(|at| corners[at]);
            let (Some(top_right), Some(bottom_left)) = (top_right, bottom_left) else { continue };
            if let Some(top_left) = top_left {
                raster.add([top_left, top_right, bottom_left]);
            }
            if let Some(bottom_right) = bottom_right {
                raster.add([bottom_right, bottom_left, top_right]);
            }
        }
    }
    raster
}

/// Where every pixel center of a view appears; `None` for pixels without depth and those behind the viewpoint.
fn corners(view: &RecordedView, target: &Camera) -> Grid<Option<Corner>> {
    let depths = &view.frame.inverse_depth;
    let least = depths.as_slice().iter().copied().filter(|inverse_depth| *inverse_depth > 0.0);
    let farthest =
        least.fold(None, |least: Option<f32>, value| Some(least.map_or(value, |least| least.min(value))));
    let infinity = INFINITY_FACTOR / farthest.map_or(1.0, f64::from);
    let target_from_source = target.camera_from_world() * view.camera.world_from_camera;
    let (width, height) = depths.size();
    Grid::from_fn(width, height, |x, y| {
        let inverse_depth = f64::from(depths[(x, y)]);
        if inverse_depth < 0.0 {
            return None;
        }
        let depth = if inverse_depth > 0.0 { 1.0 / inverse_depth } else { infinity };
        let ray = view.camera.intrinsics.ray_in_camera(DVec2::new(x as f64 + 0.5, y as f64 + 0.5));
        let point: DVec3 = target_from_source.transform_point3(ray * depth);
        let at = target.intrinsics.project(point)? * PRECISION as f64;
        let color = view.frame.color[(x, y)].map(|linear| srgb_from_linear(linear.to_f32()));
        Some(Corner { at, depth: point.z as f32, color })
    })
}

impl Raster {
    /// Draws a triangle whose corners are in the order of one that faces the viewpoint.
    fn add(&mut self, [a, b, c]: [Corner; 3]) {
        let doubled_area = (b.at.y - c.at.y) * (a.at.x - c.at.x) + (c.at.x - b.at.x) * (a.at.y - c.at.y);
        if doubled_area <= 0.0 {
            return;
        }
        let longest = a.at.distance(b.at).max(a.at.distance(c.at)).max(b.at.distance(c.at)) as f32;
        let quality = (BEST_QUALITY - LOST_PER_PIXEL * longest / PRECISION as f32).clamp(1.0, BEST_QUALITY);
        let (width, height) = self.color.size();
        let range = |values: [f64; 3], end: usize| {
            let low = values.into_iter().fold(f64::INFINITY, f64::min).floor();
            let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max).ceil() + 1.0;
            (low.clamp(0.0, end as f64) as usize)..(high.clamp(0.0, end as f64) as usize)
        };
        for row in range([a.at.y, b.at.y, c.at.y], height) {
            for column in range([a.at.x, b.at.x, c.at.x], width) {
                let at = DVec2::new(column as f64 + 0.5, row as f64 + 0.5) - c.at;
                let of_a = ((b.at.y - c.at.y) * at.x + (c.at.x - b.at.x) * at.y) / doubled_area;
                let of_b = ((c.at.y - a.at.y) * at.x + (a.at.x - c.at.x) * at.y) / doubled_area;
                let shares = [of_a, of_b, 1.0 - of_a - of_b].map(|share| share as f32);
                if shares.iter().all(|share| *share >= -1e-6) {
                    self.show((column, row), quality, [a, b, c], shares);
                }
            }
        }
    }

    fn show(&mut self, at: (usize, usize), quality: f32, corners: [Corner; 3], shares: [f32; 3]) {
        let mean = |value: &dyn Fn(&Corner) -> f32| -> f32 {
            corners.iter().zip(shares).map(|(corner, share)| share * value(corner)).sum()
        };
        let depth = mean(&|corner| corner.depth);
        let ratio = depth / self.depth[at];
        if depth > 0.0 && ratio * ratio * ratio * self.quality[at] < quality {
            self.color[at] = std::array::from_fn(|channel| mean(&|corner| corner.color[channel]));
            self.depth[at] = depth;
            self.quality[at] = quality;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::slope;
    use super::*;

    #[test]
    fn meshes_of_a_slope_show_it_as_it_is_from_between_and_beside_the_cameras() {
        let meshes = TriangleMeshes::new(&[slope(-0.3), slope(0.3)]);
        for x in [0.0, 0.15, 0.4] {
            let (truth, picture) = (slope(x), meshes.render(&slope(x).camera));
            let mut known = 0;
            for y in 4..28 {
                for x in 8..40 {
                    let at = (x, y);
                    assert_eq!(picture.image[at], 0, "{at:?}");
                    let apart = picture.inverse_depth[at] / truth.frame.inverse_depth[at] - 1.0;
                    assert!(apart.abs() < 2e-3, "{at:?} {apart}");
                    let [painted, true_color] = [picture.color[at][0], truth.frame.color[at][0].to_f32()];
                    assert!((painted - true_color).abs() < 0.01, "{at:?} {painted} {true_color}");
                    known += 1;
                }
            }
            assert_eq!(known, 24 * 32);
        }
    }

    #[test]
    fn a_stretched_triangle_loses_against_a_compact_one_of_another_camera_at_the_same_place() {
        let corner =
            |x: f64, y: f64, value: f32| Corner { at: DVec2::new(x, y), depth: 2.0, color: [value; 3] };
        let mut sums = Grid::filled(4, 4, [0.0; 5]);
        for (reach, value) in [(12.0, 1.0), (4.0, 0.0)] {
            let mut raster = Raster {
                color: Grid::filled(4, 4, [0.0; 3]),
                depth: Grid::filled(4, 4, f32::INFINITY),
                quality: Grid::filled(4, 4, 0.0),
            };
            raster.add([corner(0.0, 0.0, value), corner(reach, 0.0, value), corner(0.0, reach, value)]);
            blend(&mut sums, &raster);
        }
        let [red, .., weight, _] = sums[(0, 0)];
        // Longest edges of 8.5 and 2.8 px of the picture: qualities of 1515 and 7172.
        assert!(red / weight < 1e-3 && weight > 0.0, "{}", red / weight);
        // In the other order it faces away.
        let mut raster = Raster {
            color: Grid::filled(4, 4, [0.0; 3]),
            depth: Grid::filled(4, 4, f32::INFINITY),
            quality: Grid::filled(4, 4, 0.0),
        };
        raster.add([corner(0.0, 0.0, 1.0), corner(0.0, 4.0, 1.0), corner(4.0, 0.0, 1.0)]);
        assert!(raster.quality.as_slice().iter().all(|quality| *quality == 0.0));
    }
}
