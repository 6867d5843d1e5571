//! A finished picture carried to another viewpoint: what a window shows until the picture of that viewpoint is there.
//!
//! Source: Mark, `McMillan` and Bishop, *Post-Rendering 3D Warping*, I3D 1997. What differs: one reference picture instead of two. Depths
//! alone are warped forward, each as wide as its pixel becomes, so that surfaces that come nearer have no cracks. Colors are then looked
//! up backward and interpolated, so that textures slide smoothly. What nothing reaches is taken from the farther side of its row, which
//! is what a nearer surface has just uncovered.
//!
//! Samples at infinity have the inverse depth 0: they move with rotation alone.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use crate::capture::{Camera, Intrinsics};
use crate::grid::Grid;

/// A displayed color; the meaning of its channels does not matter.
pub type ScreenColor = [u8; 4];

/// Half the width of a pixel that is warped without change of size, pixels: more than a half, so that rounding leaves no cracks.
const REACH: f32 = 0.75;

/// Largest half width, pixels: farther magnified surfaces are seen through.
const LARGEST_REACH: f32 = 2.75;

/// Pixels around the warped depths, so that the widest pixel at their edge stays within.
const MARGIN: usize = 4;

/// Ratio of depths below which a point counts as behind the eye.
const NEAREST: f32 = 1e-3;

/// Marks a pixel that nothing reached; of two others the larger is nearer.
const EMPTY: u32 = 0;

/// A picture on a screen.
#[derive(Clone, Copy, Debug)]
pub struct ScreenPicture<'a> {
    /// Row-major; as many as `inverse_depth` has.
    pub colors: &'a [ScreenColor],
    /// Reciprocal of planar z; 0 at infinity. Negative values count as infinity.
    pub inverse_depth: &'a Grid<f32>,
    /// From where it was taken, with as many pixels as it has.
    pub camera: &'a Camera,
}

/// A picture as another camera sees it, about.
#[derive(Clone, Debug, PartialEq)]
pub struct CarriedPicture {
    /// Row-major.
    pub colors: Vec<ScreenColor>,
    /// Reciprocal of planar z; 0 at infinity.
    pub inverse_depth: Grid<f32>,
}

/// Carries pictures, and keeps the memory for it.
#[derive(Debug, Default)]
pub struct PictureCarrier {
    /// Warped depths with their margin, as [`key_of`] makes them.
    keys: Vec<u32>,
}

impl PictureCarrier {
    /// The picture as `to` sees it, at the size of `to`; `None` where a size is wrong or 0, nothing of the picture is in view, or a camera is
    /// orthographic.
    pub fn carry(&mut self, picture: &ScreenPicture<'_>, to: &Camera) -> Option<CarriedPicture> {
        let (width, height) = to.intrinsics.size();
        let fits = picture.camera.intrinsics.size() == picture.inverse_depth.size()
            && picture.colors.len() == picture.inverse_depth.len();
        let is_pinhole = |camera: &Camera| !camera.intrinsics.is_orthographic();
        let fits = fits && is_pinhole(picture.camera) && is_pinhole(to);
        if !fits || picture.colors.is_empty() || width == 0 || height == 0 {
            return None;
        }
        self.keys.clear();
        self.keys.resize((width + 2 * MARGIN) * (height + 2 * MARGIN), EMPTY);
        self.warp(picture, to);
        let back = PixelMap::new(to, picture.camera);
        let mut colors = vec![[0; 4]; width * height];
        let mut depths = vec![-1.0_f32; width * height];
        let rows = colors.par_chunks_mut(width).zip(depths.par_chunks_mut(width)).enumerate();
        rows.for_each(|(y, (colors, depths))| {
            let first = (y + MARGIN) * (width + 2 * MARGIN) + MARGIN;
            look_up(picture, &back, y, &self.keys[first..first + width], colors, depths);
            close_gaps(colors, depths);
        });
        fill_rows(&mut colors, &mut depths, width)?;
        Some(CarriedPicture { colors, inverse_depth: Grid::from_vec(width, height, depths) })
    }

    /// Warps the depths of a picture forward; of those that meet the nearest stays.
    fn warp(&mut self, picture: &ScreenPicture<'_>, to: &Camera) {
        let map = PixelMap::new(picture.camera, to);
        let (columns, rows) = picture.inverse_depth.size();
        let (width, height) = to.intrinsics.size();
        let stride = width + 2 * MARGIN;
        let limit = [width as f32, height as f32];
        let mut row = vec![WarpedPixel::default(); columns];
        for y in 0..rows {
            map.warp_row(y, picture.inverse_depth.row(y), &mut row);
            for pixel in &row {
                let [x, y] = pixel.place;
                if pixel.key == EMPTY || x <= -1.0 || y <= -1.0 || x >= limit[0] || y >= limit[1] {
                    continue;
                }
                // Numbers of the first and last pixel whose center is within reach, in the memory with its margin.
                let first = |at: f32| (at - pixel.reach + (MARGIN + 1) as f32) as usize;
                let last = |at: f32| (at + pixel.reach + MARGIN as f32) as usize;
                let columns = first(x)..=last(x);
                for y in first(y)..=last(y) {
                    for key in &mut self.keys[y * stride + columns.start()..=y * stride + columns.end()] {
                        *key = pixel.key.max(*key);
                    }
                }
            }
        }
    }
}

/// A pixel of the reference picture where it is seen from the new viewpoint.
#[derive(Clone, Copy, Debug, Default)]
struct WarpedPixel {
    /// Column and row; a center is a whole number.
    place: [f32; 2],
    /// Half its width, pixels.
    reach: f32,
    key: u32,
}

/// Where pixels of one camera lie in another, by their inverse depth.
struct PixelMap {
    /// From homogeneous pixel numbers to those of the other camera, of points at infinity. The third is the ratio of depths.
    at_infinity: [[f32; 3]; 3],
    /// What a unit of inverse depth adds.
    by_inverse_depth: [f32; 3],
    /// How much finer the other camera's pixels are.
    finer: f32,
}

impl PixelMap {
    fn new(from: &Camera, to: &Camera) -> Self {
        let to_from = to.camera_from_world() * from.world_from_camera;
        let lens = pixels_from_rays(&to.intrinsics);
        let at_infinity = lens * to_from.matrix3 * pixels_from_rays(&from.intrinsics).inverse();
        let single = |vector: DVec3| vector.to_array().map(|number| number as f32);
        let finer = (to.intrinsics.fx / from.intrinsics.fx).max(to.intrinsics.fy / from.intrinsics.fy);
        Self {
            at_infinity: [at_infinity.x_axis, at_infinity.y_axis, at_infinity.z_axis].map(single),
            by_inverse_depth: single(lens * to_from.translation),
            finer: finer as f32,
        }
    }

    /// Homogeneous place of the pixel in column 0 of a row, at infinity.
    fn row_start(&self, y: usize) -> [f32; 3] {
        let [_, down, corner] = self.at_infinity;
        std::array::from_fn(|axis| down[axis] * y as f32 + corner[axis])
    }

    #[inline(always)]
    fn place(&self, start: [f32; 3], x: usize, inverse_depth: f32) -> [f32; 3] {
        let along = self.at_infinity[0];
        std::array::from_fn(|axis| {
            along[axis] * x as f32 + start[axis] + self.by_inverse_depth[axis] * inverse_depth
        })
    }

    fn warp_row(&self, y: usize, inverse_depths: &[f32], row: &mut [WarpedPixel]) {
        let start = self.row_start(y);
        for (x, (inverse_depth, pixel)) in inverse_depths.iter().zip(row).enumerate() {
            let inverse_depth = inverse_depth.max(0.0);
            let [u, v, z] = self.place(start, x, inverse_depth);
            let nearer = z.max(NEAREST).recip();
            *pixel = WarpedPixel {
                place: [u * nearer, v * nearer],
                reach: (0.5 * self.finer * nearer + (REACH - 0.5)).clamp(REACH, LARGEST_REACH),
                key: if z > NEAREST { key_of(inverse_depth * nearer) } else { EMPTY },
            };
        }
    }
}

/// From rays through pixels, with z = 1, to numbers of pixels, whose centers are whole.
fn pixels_from_rays(lens: &Intrinsics) -> DMat3 {
    DMat3::from_cols(
        DVec3::new(lens.fx, 0.0, 0.0),
        DVec3::new(0.0, lens.fy, 0.0),
        DVec3::new(lens.cx - 0.5, lens.cy - 0.5, 1.0),
    )
}

/// Inverse depths in an order of whole numbers above [`EMPTY`].
fn key_of(inverse_depth: f32) -> u32 {
    inverse_depth.to_bits() + 1
}

/// Looks up the colors of the pixels of a row that have a depth.
fn look_up(
    picture: &ScreenPicture<'_>,
    back: &PixelMap,
    y: usize,
    keys: &[u32],
    colors: &mut [ScreenColor],
    depths: &mut [f32],
) {
    let start = back.row_start(y);
    let (columns, rows) = picture.inverse_depth.size();
    let last = [columns - 1, rows - 1];
    for (x, key) in keys.iter().enumerate().filter(|(_, key)| **key != EMPTY) {
        depths[x] = f32::from_bits(key - 1);
        let [u, v, z] = back.place(start, x, depths[x]);
        let nearer = z.max(NEAREST).recip();
        let at = [u * nearer, v * nearer];
        let at: [f32; 2] = std::array::from_fn(|axis| at[axis].clamp(0.0, last[axis] as f32));
        let whole = at.map(|at| at as usize);
        let next: [usize; 2] = std::array::from_fn(|axis| (whole[axis] + 1).min(last[axis]));
        let share: [u32; 2] =
            std::array::from_fn(|axis| ((at[axis] - whole[axis] as f32) * 256.0 + 0.5) as u32);
        let color = |x: usize, y: usize| u32::from_le_bytes(picture.colors[y * columns + x]);
        let [above, below] =
            [whole[1], next[1]].map(|y| mixed(color(whole[0], y), color(next[0], y), share[0]));
        colors[x] = mixed(above, below, share[1]).to_le_bytes();
    }
}

/// Four bytes on the way from `a` to `b`, by `share` parts of 256.
#[inline(always)]
fn mixed(a: u32, b: u32, share: u32) -> u32 {
    const EVEN: u32 = 0x00ff_00ff;
    const HALF: u32 = 0x0080_0080;
    let mix = |a: u32, b: u32| ((a & EVEN) * (256 - share) + (b & EVEN) * share + HALF) >> 8 & EVEN;
    mix(a, b) | mix(a >> 8, b >> 8) << 8
}

/// Fills the gaps of a row with what is farther of both sides.
fn close_gaps(colors: &mut [ScreenColor], depths: &mut [f32]) {
    let mut x = 0;
    while x < depths.len() {
        if depths[x] >= 0.0 {
            x += 1;
            continue;
        }
        let end = depths[x..].iter().position(|depth| *depth >= 0.0).map_or(depths.len(), |run| x + run);
        let sides = [x.checked_sub(1), (end < depths.len()).then_some(end)];
        let farther = sides.into_iter().flatten().min_by(|a, b| depths[*a].total_cmp(&depths[*b]));
        if let Some(side) = farther {
            let (color, depth) = (colors[side], depths[side]);
            colors[x..end].fill(color);
            depths[x..end].fill(depth);
        }
        x = end;
    }
}

/// Fills rows that nothing reached with the nearest row that something did; `None` if there is none.
fn fill_rows(colors: &mut [ScreenColor], depths: &mut [f32], width: usize) -> Option<()> {
    let rows = depths.len() / width;
    let reached: Vec<usize> = (0..rows).filter(|y| depths[y * width] >= 0.0).collect();
    let first = *reached.first()?;
    let mut next = 0;
    for y in 0..rows {
        while next + 1 < reached.len() && reached[next + 1].abs_diff(y) <= reached[next].abs_diff(y) {
            next += 1;
        }
        let nearest = reached.get(next).copied().unwrap_or(first);
        if nearest != y {
            colors.copy_within(nearest * width..(nearest + 1) * width, y * width);
            depths.copy_within(nearest * width..(nearest + 1) * width, y * width);
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec2};

    const SIZE: (usize, usize) = (64, 48);

    fn camera(eye: DVec3) -> Camera {
        let lens = Intrinsics::from_horizontal_angle(SIZE.0 as u32, SIZE.1 as u32, 1.0);
        Camera::look_at("c", lens, eye, eye + DVec3::Y, DVec3::Z)
    }

    /// A color for each pixel, none like another nearby.
    fn colors() -> Vec<ScreenColor> {
        let byte = |at: usize| (at % 251) as u8;
        (0..SIZE.0 * SIZE.1).map(|at| [byte(at * 7), byte(at * 31), byte(at * 57), 255]).collect()
    }

    fn carried(colors: &[ScreenColor], depth: &Grid<f32>, from: &Camera, to: &Camera) -> CarriedPicture {
        let picture = ScreenPicture { colors, inverse_depth: depth, camera: from };
        PictureCarrier::default().carry(&picture, to).unwrap()
    }

    #[test]
    fn to_where_it_was_taken_every_pixel_is_carried_unchanged() {
        let depth = Grid::from_fn(SIZE.0, SIZE.1, |x, y| ((x / 5 + y / 7) % 4) as f32 * 0.3);
        let here = camera(DVec3::new(1.0, -2.0, 0.5));
        let same = carried(&colors(), &depth, &here, &here);
        assert_eq!((same.colors, same.inverse_depth), (colors(), depth));
    }

    #[test]
    fn a_sky_moves_with_rotation_alone() {
        let sky = Grid::filled(SIZE.0, SIZE.1, 0.0);
        let here = camera(DVec3::ZERO);
        let elsewhere = camera(DVec3::new(3.0, 1.0, -2.0));
        assert_eq!(carried(&colors(), &sky, &here, &elsewhere).colors, colors(), "it is too far away");
        // By as much as one pixel in the middle is wide, to the right.
        let mut turned = here.clone();
        let angle = (1.0 / here.intrinsics.fx).atan();
        turned.world_from_camera.matrix3 *= DMat3::from_quat(DQuat::from_axis_angle(DVec3::Y, angle));
        let smooth: Vec<ScreenColor> =
            (0..SIZE.0 * SIZE.1).map(|at| [(at % SIZE.0 * 3) as u8, 0, 0, 255]).collect();
        let moved = carried(&smooth, &sky, &here, &turned);
        let middle = SIZE.1 / 2 * SIZE.0 + SIZE.0 / 2;
        assert!(moved.colors[middle][0].abs_diff(smooth[middle + 1][0]) <= 1);
        assert!(moved.inverse_depth.as_slice().iter().all(|depth| *depth == 0.0));
    }

    #[test]
    fn a_plane_lies_where_projection_says_after_a_step() {
        let plane = Grid::filled(SIZE.0, SIZE.1, 0.25);
        let (here, there) = (camera(DVec3::ZERO), camera(DVec3::new(0.4, 0.5, 0.1)));
        let mut colors = vec![[10, 20, 30, 255]; SIZE.0 * SIZE.1];
        // A mark of three by three pixels.
        let (x, y) = (40, 20);
        for (dx, dy) in (0..9).map(|nth| (nth % 3, nth / 3)) {
            colors[(y + dy) * SIZE.0 + x + dx] = [200, 100, 50, 255];
        }
        let moved = carried(&colors, &plane, &here, &there);
        let point = here.unproject(DVec2::new(x as f64 + 1.5, y as f64 + 1.5), 4.0);
        let (place, depth) = there.project(point).unwrap();
        let at = (place.x as usize, place.y as usize);
        assert_eq!(moved.colors[at.1 * SIZE.0 + at.0], [200, 100, 50, 255]);
        assert!((f64::from(moved.inverse_depth[at]) * depth - 1.0).abs() < 1e-5);
        let cracks = moved.inverse_depth.as_slice().iter().filter(|w| (**w - 1.0 / 3.5).abs() > 1e-5);
        assert_eq!(cracks.count(), 0, "all of it is one plane, nearer by the step");
    }

    #[test]
    fn what_is_nearer_wins_and_what_it_uncovers_is_what_is_behind() {
        let stands = |x: usize| (24..40).contains(&x);
        let depth = Grid::from_fn(SIZE.0, SIZE.1, |x, _| if stands(x) { 1.0 } else { 0.1 });
        let colors: Vec<ScreenColor> = (0..SIZE.0 * SIZE.1)
            .map(|at| if stands(at % SIZE.0) { [255, 0, 0, 255] } else { [0, 0, 255, 255] })
            .collect();
        let (here, there) = (camera(DVec3::ZERO), camera(DVec3::new(0.2, 0.0, 0.0)));
        let moved = carried(&colors, &depth, &here, &there);
        // The post moves to the left by fx · 0.2, the wall by a tenth of that.
        let shift = here.intrinsics.fx * 0.2;
        for x in 0..SIZE.0 {
            let place = x as f64 + shift;
            let expected = if (25.0..38.0).contains(&place) {
                Some([255, 0, 0, 255])
            } else if (22.0..42.0).contains(&place) {
                None
            } else {
                Some([0, 0, 255, 255])
            };
            let shown = moved.colors[20 * SIZE.0 + x];
            assert!(expected.is_none_or(|expected| shown == expected), "{x}: {shown:?}");
        }
    }

    #[test]
    fn a_surface_that_comes_nearer_has_no_cracks() {
        let depth = Grid::from_fn(SIZE.0, SIZE.1, |x, _| if x < 32 { 0.5 } else { 0.0 });
        let (here, there) = (camera(DVec3::ZERO), camera(DVec3::new(0.0, 1.2, 0.0)));
        let moved = carried(&colors(), &depth, &here, &there);
        assert!((0..SIZE.1).all(|y| (0..30).all(|x| moved.inverse_depth[(x, y)] > 0.0)));
    }

    #[test]
    fn pictures_of_another_size_than_their_camera_are_not_carried_and_nothing_is_seen_behind() {
        let (here, depth) = (camera(DVec3::ZERO), Grid::filled(SIZE.0, SIZE.1, 0.5));
        let colors = colors();
        let picture = ScreenPicture { colors: &colors[1..], inverse_depth: &depth, camera: &here };
        assert_eq!(PictureCarrier::default().carry(&picture, &here), None);
        let behind = Camera::look_at("c", here.intrinsics, DVec3::ZERO, DVec3::NEG_Y, DVec3::Z);
        let picture = ScreenPicture { colors: &colors, ..picture };
        assert_eq!(PictureCarrier::default().carry(&picture, &behind), None);
    }
}
