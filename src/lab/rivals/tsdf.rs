//! A volume of truncated signed distances, integrated from all cameras and ray-cast.
//!
//! Source: B. Curless and M. Levoy, *A Volumetric Method for Building Complex Models from Range Images*, SIGGRAPH 1996, §3: each voxel
//! keeps the weighted mean of its signed distances to the surfaces that cameras saw along their lines of sight, and the surface is
//! the zero crossing of these means. Ray casting: S. Izadi et al., *`KinectFusion`*, UIST 2011. Blocks of voxels only near surfaces:
//! M. Nießner et al., *Real-time 3D Reconstruction at Scale Using Voxel Hashing*, SIGGRAPH Asia 2013. Constants and details are those
//! of `Open3D`'s `VoxelBlockGrid`: distances along z, truncated at eight voxels; every observation of weight 1; colors averaged
//! sRGB-encoded and interpolated over the eight voxels around the surface.
//!
//! What differs: voxels twice as wide until there are at most 100,000 blocks. A ray that hits nothing shows the sky of the nearest
//! camera that saw it in that direction.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use glam::{DVec2, DVec3, IVec3};
use rayon::prelude::*;

use super::model::{RecordedView, RivalModel, deflated, median_footprint};
use super::sky::Sky;
use overlook_engine::capture::Camera;
use overlook_engine::color::{linear_from_srgb, srgb_from_linear};
use overlook_engine::error::{Error, Result};
use overlook_engine::grid::Grid;
use overlook_engine::random::mix;
use overlook_engine::render::{NO_IMAGE, Picture};

/// Distance at which distances are truncated, in voxels.
const TRUNCATION_VOXELS: f64 = 8.0;

/// Blocks are searched along the line of sight of one pixel in this many.
const BLOCK_STRIDE: usize = 4;

/// Most blocks, of 10 kB each.
const MAX_BLOCKS: usize = 100_000;

/// Depths beyond this many times the median are not part of the volume.
const FARTHEST_MEDIANS: f64 = 6.0;

/// The volume and the views, for the sky.
pub(super) struct Tsdf {
    volume: Volume,
    views: Vec<RecordedView>,
}

impl Tsdf {
    /// With voxels as wide as `footprints` pixels at the median depth.
    pub(super) fn of_footprints(views: &[RecordedView], footprints: f64) -> Result<Self> {
        let (_, width) = median(views)?;
        Self::of_voxel(views, footprints * width)
    }

    /// With voxels of a width, in the capture's unit.
    pub(super) fn of_voxel(views: &[RecordedView], voxel: f64) -> Result<Self> {
        if !(voxel.is_finite() && voxel > 0.0) {
            return Err(Error::invalid("TSDF volume", "the width of a voxel must be finite and above 0"));
        }
        let farthest = FARTHEST_MEDIANS * median(views)?.0;
        let mut voxel = voxel;
        let mut places = block_places(views, voxel, farthest);
        while places.len() > MAX_BLOCKS {
            voxel *= 2.0;
            places = block_places(views, voxel, farthest);
        }
        let mut volume = Volume::new(voxel, places);
        let encoded: Vec<EncodedView> = views.iter().map(EncodedView::new).collect();
        volume.blocks.par_iter_mut().for_each(|block| integrate(block, voxel, &encoded, farthest));
        Ok(Self { volume, views: views.to_vec() })
    }
}

fn median(views: &[RecordedView]) -> Result<(f64, f64)> {
    median_footprint(views)
        .ok_or_else(|| Error::invalid("TSDF volume", "no camera saw a surface at a finite depth"))
}

/// The places of all blocks within the truncation distance of a surface, and the views that see it.
fn block_places(views: &[RecordedView], voxel: f64, farthest: f64) -> Vec<(IVec3, Vec<u32>)> {
    let (block_width, truncation) = (voxel * f64::from(SIDE), TRUNCATION_VOXELS * voxel);
    let of_view = |view: &RecordedView| {
        let mut places: ByPlace<IVec3> = ByPlace::default();
        let (width, height) = view.frame.size();
        for y in (0..height).step_by(BLOCK_STRIDE) {
            for x in (0..width).step_by(BLOCK_STRIDE) {
                let inverse_depth = f64::from(view.frame.inverse_depth[(x, y)]);
                if inverse_depth * farthest < 1.0 {
                    continue;
                }
                let depth = 1.0 / inverse_depth;
                let center = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let steps = (2.0 * truncation / (0.5 * block_width)).ceil() as usize;
                for step in 0..=steps {
                    let along = depth - truncation + 2.0 * truncation * step as f64 / steps as f64;
                    let place = (view.camera.unproject(center, along) / block_width).floor().as_ivec3();
                    if let Some(key) = packed(place).filter(|_| along > 0.0) {
                        places.insert(key, place);
                    }
                }
            }
        }
        places
    };
    let of_views: Vec<ByPlace<IVec3>> = views.par_iter().map(of_view).collect();
    let mut all: ByPlace<(IVec3, Vec<u32>)> = ByPlace::default();
    for (index, places) in of_views.into_iter().enumerate() {
        for (key, place) in places {
            all.entry(key).or_insert_with(|| (place, Vec::new())).1.push(index as u32);
        }
    }
    all.into_values().collect()
}

/// A view as integration reads it.
struct EncodedView {
    camera: Camera,
    camera_from_world: glam::DAffine3,
    inverse_depth: Grid<f32>,
    color: Grid<[f32; 3]>,
}

impl EncodedView {
    fn new(view: &RecordedView) -> Self {
        Self {
            camera: view.camera.clone(),
            camera_from_world: view.camera.camera_from_world(),
            inverse_depth: view.frame.inverse_depth.clone(),
            color: view.frame.color.map(|color| color.map(|linear| srgb_from_linear(linear.to_f32()))),
        }
    }
}

/// Takes every observation of a block's voxels into their means.
fn integrate(block: &mut VoxelBlock, voxel: f64, views: &[EncodedView], farthest: f64) {
    let truncation = TRUNCATION_VOXELS * voxel;
    let corner = block.place * SIDE;
    for view in block.views.iter().map(|view| &views[*view as usize]) {
        let (width, height) = view.inverse_depth.size();
        for (index, known) in block.voxels.iter_mut().enumerate() {
            let offset =
                IVec3::new(index as i32 % SIDE, index as i32 / SIDE % SIDE, index as i32 / (SIDE * SIDE));
            let point = view.camera_from_world.transform_point3((corner + offset).as_dvec3() * voxel);
            let Some(at) = view.camera.intrinsics.project(point) else { continue };
            if at.x < 0.0 || at.y < 0.0 || at.x >= width as f64 || at.y >= height as f64 {
                continue;
            }
            let at = (at.x as usize, at.y as usize);
            let inverse_depth = f64::from(view.inverse_depth[at]);
            if inverse_depth < 0.0 {
                continue;
            }
            let depth = if inverse_depth * farthest < 1.0 { f64::INFINITY } else { 1.0 / inverse_depth };
            let distance = depth - point.z;
            if distance < -truncation {
                continue;
            }
            let share = 1.0 / (known.weight + 1.0);
            let distance = (distance.min(truncation) / truncation) as f32;
            known.distance += share * (distance - known.distance);
            for (mean, value) in known.color.iter_mut().zip(view.color[at]) {
                *mean += share * (value - *mean);
            }
            known.weight += 1.0;
        }
    }
}

impl RivalModel for Tsdf {
    fn render(&self, target: &Camera) -> Picture {
        let (width, height) = target.intrinsics.size();
        let sky = Sky::seen_from(&self.views, target);
        let (eye, turn) = (target.position_in_world(), target.world_from_camera.matrix3);
        let bounds = self.volume.bounds();
        let pixel = |index: usize| {
            let center = DVec2::new((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
            let ray: DVec3 = turn * target.intrinsics.ray_in_camera(center);
            let surface = bounds.and_then(|(low, high)| self.surface(eye, ray, low, high));
            let shown = surface.and_then(|depth| Some((self.color(eye + depth * ray)?, 1.0 / depth)));
            match shown.or_else(|| Some((sky.color(ray)?, 0.0))) {
                Some((color, inverse_depth)) => (color, inverse_depth as f32, 0),
                None => ([0.0; 3], -1.0, NO_IMAGE),
            }
        };
        let pixels: Vec<([f32; 3], f32, u32)> = (0..width * height).into_par_iter().map(pixel).collect();
        Picture {
            color: Grid::from_vec(width, height, pixels.iter().map(|pixel| pixel.0).collect()),
            inverse_depth: Grid::from_vec(width, height, pixels.iter().map(|pixel| pixel.1).collect()),
            image: Grid::from_vec(width, height, pixels.iter().map(|pixel| pixel.2).collect()),
            ..Picture::empty(width, height)
        }
    }

    fn bytes(&self) -> Option<u64> {
        let mut planes = vec![Vec::new(); 5];
        for block in &self.volume.blocks {
            for voxel in &block.voxels {
                let Voxel { distance, weight, color } = voxel;
                let [r, g, b] = color.map(|encoded| (255.0 * encoded + 0.5).clamp(0.0, 255.0) as u8);
                let values = [(distance * 127.0 + 128.0) as u8, weight.min(255.0) as u8, r, g, b];
                planes.iter_mut().zip(values).for_each(|(plane, value)| plane.push(value));
            }
        }
        let places = self.volume.blocks.iter().flat_map(|block| block.place.to_array());
        let places: Vec<u8> = places.flat_map(i32::to_le_bytes).collect();
        Some(deflated(&planes.concat()) + deflated(&places))
    }
}

impl Tsdf {
    /// Depth along a ray, in multiples of it, at which the distance first crosses zero from the front, within the box from `low` to
    /// `high`; `None` if it never does.
    fn surface(&self, eye: DVec3, ray: DVec3, low: DVec3, high: DVec3) -> Option<f64> {
        let inverse = ray.recip();
        let (to_low, to_high) = ((low - eye) * inverse, (high - eye) * inverse);
        let enters = to_low.min(to_high).max_element().max(0.0);
        let leaves = to_low.max(to_high).min_element();
        let voxel = self.volume.voxel / ray.length();
        let block_width = self.volume.block_width();
        let (mut at, mut before): (f64, Option<(f64, f32)>) = (enters, None);
        while at < leaves {
            let point = eye + at * ray;
            let place = (point / block_width).floor();
            if self.volume.block(place.as_ivec3()).is_none() {
                let (near, far) = (place * block_width, (place + 1.0) * block_width);
                let exit = ((near - eye) * inverse).max((far - eye) * inverse).min_element();
                (at, before) = (exit.max(at) + 1e-3 * voxel, None);
                continue;
            }
            let known = self.volume.voxel((point / self.volume.voxel).round().as_ivec3());
            let Some(Voxel { distance, .. }) = known.filter(|known| known.weight > 0.0) else {
                (at, before) = (at + voxel, None);
                continue;
            };
            if let Some((there, in_front)) =
                before.filter(|(_, in_front)| *in_front > 0.0 && *distance <= 0.0)
            {
                let (there_distance, here) = self.ends((eye + there * ray, in_front), (point, *distance));
                return Some((at * there_distance - there * here) / (there_distance - here));
            }
            before = Some((at, *distance));
            // Along z a surface is no nearer than this, but beside the line of sight it may be.
            let free = f64::from(*distance) * 0.5 * TRUNCATION_VOXELS * voxel;
            at += free.max(voxel);
        }
        None
    }

    /// Distances at two points on either side of a surface. They are interpolated if that keeps their signs; otherwise they are the given
    /// ones.
    fn ends(&self, front: (DVec3, f32), back: (DVec3, f32)) -> (f64, f64) {
        let distances = [front.0, back.0].map(|point| self.interpolated(point).map(|voxel| voxel.distance));
        let (in_front, behind) = match distances {
            [Some(in_front), Some(behind)] if in_front > 0.0 && behind <= 0.0 => (in_front, behind),
            _ => (front.1, back.1),
        };
        (f64::from(in_front), f64::from(behind))
    }

    /// Linear color at a point on a surface.
    fn color(&self, point: DVec3) -> Option<[f32; 3]> {
        Some(self.interpolated(point)?.color.map(linear_from_srgb))
    }

    /// The mean of the known voxels around a point, by their nearness; its weight is the sum of the shares.
    fn interpolated(&self, point: DVec3) -> Option<Voxel> {
        let position = point / self.volume.voxel;
        let corner = position.floor();
        let share = position - corner;
        let mut mean = Voxel::default();
        for index in 0..8 {
            let offset = IVec3::new(index & 1, (index >> 1) & 1, (index >> 2) & 1);
            let Some(voxel) = self.volume.voxel(corner.as_ivec3() + offset) else { continue };
            let along = |axis: usize| if offset[axis] == 1 { share[axis] } else { 1.0 - share[axis] };
            let weight = (along(0) * along(1) * along(2)) as f32;
            if voxel.weight > 0.0 {
                mean.weight += weight;
                mean.distance += weight * voxel.distance;
                for (sum, value) in mean.color.iter_mut().zip(voxel.color) {
                    *sum += weight * value;
                }
            }
        }
        (mean.weight > 0.0).then(|| Voxel {
            distance: mean.distance / mean.weight,
            color: mean.color.map(|sum| sum / mean.weight),
            weight: mean.weight,
        })
    }
}

/// Voxels along each side of a block.
pub(super) const SIDE: i32 = 8;

/// Voxels of a block.
pub(super) const VOXELS: usize = (SIDE * SIDE * SIDE) as usize;

/// One voxel of a truncated signed distance field.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Voxel {
    /// Distance to the nearest surface in front of the cameras, in truncation distances: -1 (behind) to 1 (in front).
    pub(super) distance: f32,
    /// Number of observations; 0 where nothing is known.
    pub(super) weight: f32,
    /// Mean of the sRGB-encoded colors.
    pub(super) color: [f32; 3],
}

/// A cube of [`SIDE`]³ voxels.
pub(super) struct VoxelBlock {
    /// Place, in blocks.
    pub(super) place: IVec3,
    /// x fastest, then y, then z.
    pub(super) voxels: Vec<Voxel>,
    /// Views that saw a surface in or near it.
    pub(super) views: Vec<u32>,
}

/// The hash of a place that is packed into 64 bits.
#[derive(Default)]
pub(super) struct PlaceHasher(u64);

impl Hasher for PlaceHasher {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = mix(self.0 ^ u64::from(*byte));
        }
    }

    fn write_u64(&mut self, packed: u64) {
        self.0 = mix(packed);
    }
}

/// Values by place.
pub(super) type ByPlace<T> = HashMap<u64, T, BuildHasherDefault<PlaceHasher>>;

/// A place in blocks, packed; `None` if it is more than a million blocks from the origin.
pub(super) fn packed(place: IVec3) -> Option<u64> {
    const HALF: i32 = 1 << 20;
    let coordinate = |value: i32| (-HALF..HALF).contains(&value).then_some((value + HALF) as u64);
    Some((coordinate(place.x)? << 42) | (coordinate(place.y)? << 21) | coordinate(place.z)?)
}

/// The blocks.
pub(super) struct Volume {
    /// Width of a voxel, in the capture's unit.
    pub(super) voxel: f64,
    /// In the order of their places.
    pub(super) blocks: Vec<VoxelBlock>,
    index: ByPlace<u32>,
}

impl Volume {
    /// Blocks at the given places, each with the views that saw it.
    pub(super) fn new(voxel: f64, mut places: Vec<(IVec3, Vec<u32>)>) -> Self {
        places.sort_unstable_by_key(|(place, _)| place.to_array());
        let number = |(index, (place, _)): (usize, &(IVec3, Vec<u32>))| Some((packed(*place)?, index as u32));
        let index = places.iter().enumerate().filter_map(number).collect();
        let block = |(place, views)| VoxelBlock { place, voxels: vec![Voxel::default(); VOXELS], views };
        Self { voxel, blocks: places.into_iter().map(block).collect(), index }
    }

    /// Width of a block, in the capture's unit.
    pub(super) fn block_width(&self) -> f64 {
        self.voxel * f64::from(SIDE)
    }

    /// The block at a place.
    pub(super) fn block(&self, place: IVec3) -> Option<&VoxelBlock> {
        self.blocks.get(*self.index.get(&packed(place)?)? as usize)
    }

    /// The voxel at a place in voxels; `None` if no block holds it.
    pub(super) fn voxel(&self, place: IVec3) -> Option<&Voxel> {
        let block = self.block(IVec3::from_array(place.to_array().map(|value| value.div_euclid(SIDE))))?;
        let [x, y, z] = place.to_array().map(|value| value.rem_euclid(SIDE));
        block.voxels.get((x + SIDE * (y + SIDE * z)) as usize)
    }

    /// Smallest and largest corner of all blocks.
    pub(super) fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let places = || self.blocks.iter().map(|block| block.place);
        let low = places().reduce(IVec3::min)?.as_dvec3() * self.block_width();
        let high = (places().reduce(IVec3::max)? + 1).as_dvec3() * self.block_width();
        Some((low, high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rivals::tests::slope;

    #[test]
    fn the_volume_has_its_surface_within_a_sixth_of_a_voxel_of_the_true_slope() {
        let volume = Tsdf::of_footprints(&[slope(-0.3), slope(0.3)], 2.0).unwrap();
        let truth = slope(0.1);
        let picture = volume.render(&truth.camera);
        let mut off = Vec::new();
        for y in 6..26 {
            for x in 12..36 {
                let at = (x, y);
                assert_eq!(picture.image[at], 0, "{at:?}");
                let depths =
                    [picture.inverse_depth[at], truth.frame.inverse_depth[at]].map(|inverse| 1.0 / inverse);
                off.push(f64::from((depths[0] - depths[1]).abs()) / volume.volume.voxel);
                let [painted, true_color] = [picture.color[at][0], truth.frame.color[at][0].to_f32()];
                assert!((painted - true_color).abs() < 0.03, "{at:?} {painted} {true_color}");
            }
        }
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        // Each voxel takes the depth of the nearest pixel, as in Open3D, and is two pixels wide: the mean is 0.157 voxels here.
        assert!(mean < 1.0 / 6.0, "{mean} voxels");
    }

    #[test]
    fn a_volume_of_nothing_or_of_no_width_is_refused() {
        let mut empty = slope(0.0);
        empty.frame = std::sync::Arc::new(overlook_engine::capture::Frame {
            inverse_depth: Grid::filled(48, 32, 0.0),
            ..(*empty.frame).clone()
        });
        let said = |outcome: Result<Tsdf>| outcome.err().map(|error| error.to_string()).unwrap_or_default();
        assert!(said(Tsdf::of_footprints(&[empty], 2.0)).contains("finite depth"));
        assert!(said(Tsdf::of_voxel(&[slope(0.0)], 0.0)).contains("above 0"));
    }
}
