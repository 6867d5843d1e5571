//! A sparse volume: blocks of voxels near surfaces, found by their place.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use glam::{DVec3, IVec3};

use overlook_engine::random::mix;

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
