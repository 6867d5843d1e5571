//! What preprocessing leaves: sparse sample images, one per camera and span.
//!
//! ```text
//! SampleSet ── images ──▶ SampleImage (camera, span)
//!                           tiles:  [tile 0][tile 3][tile 4]…      only tiles that hold a sample, row-major
//!                           planes: color[…] depth[…] normal[…] values[…]   samples of tile 0, then of tile 3, …
//!
//! bytes a sample: color 6, depth 3 (see depth_plane), normal 2 where set, a value 4;  a tile: 40, and 12 for its depths
//! ```
//!
//! Inside a tile samples are stored row by row, left to right; bit `x` of `rows[y]` says whether pixel `(x, y)` of the
//! tile holds one. The file has the same order.

use glam::DVec3;
use half::f16;

use super::depth_plane::DepthPlane;
use super::oct_normal::OctNormal;
use super::tile::{Sample, SampleTile, TILE, TileMask};
use crate::capture::{Camera, ValueChannel, Values};
use crate::settings::{PruningMethod, Settings};

/// A run of frames `[start, end)`, as frame indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub struct Span {
    /// First frame.
    pub start: u32,
    /// One past the last frame.
    pub end: u32,
}

impl Span {
    /// Whether `frame` is in the span.
    #[must_use]
    pub fn contains(self, frame: usize) -> bool {
        (self.start as usize..self.end as usize).contains(&frame)
    }

    /// Frames in the span.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "no span is empty")]
    pub fn len(self) -> usize {
        (self.end - self.start) as usize
    }
}

/// The kept samples of one camera over one span.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleImage {
    /// Index of the camera in [`SampleSet::cameras`].
    pub camera: u32,
    /// Frames over which every sample of this image holds.
    pub span: Span,
    /// Tiles that hold a sample, row-major.
    pub tiles: Vec<SampleTile>,
    /// Linear Rec.709, one per sample.
    pub color: Vec<[f16; 3]>,
    /// Reciprocals of planar z, 1/unit, one per sample; 0 at infinity, never negative.
    pub depth: DepthPlane,
    /// World-space normals, one per sample, where the settings ask for them.
    pub normal: Option<Vec<OctNormal>>,
    /// The doubtful samples, tile after tile: those that no other camera confirms, among noisy cameras. A tile without one has no mask.
    pub doubtful: Vec<TileMask>,
    /// Scalar values, one for each of the set's channels and sample: those of some picture, bit for bit; empty where the set has none.
    pub values: Values,
}

impl SampleImage {
    /// Samples in the image.
    #[must_use]
    pub fn len(&self) -> usize {
        self.color.len()
    }

    /// Whether the image holds no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.color.is_empty()
    }

    /// The inverse depth of every sample, in storage order.
    #[must_use]
    pub fn inverse_depths(&self) -> Vec<f32> {
        self.depth.unpack(&self.tiles)
    }

    /// Which pixels of a tile, given by its index, hold a doubtful sample: a mask of columns per row; `None` where none does.
    #[must_use]
    #[inline]
    pub fn doubtful_rows(&self, tile: usize) -> Option<&[u16; TILE]> {
        let found = self.doubtful.binary_search_by_key(&(tile as u32), |mask| mask.tile);
        found.ok().map(|at| &self.doubtful[at].rows)
    }

    /// The tile that holds a pixel, by its index; `None` where it holds no sample.
    fn tile_of(&self, x: usize, y: usize) -> Option<usize> {
        let place = ((y / TILE) as u16, (x / TILE) as u16);
        self.tiles.binary_search_by_key(&place, |tile| (tile.tile_y, tile.tile_x)).ok()
    }

    /// The sample of a pixel: its index into the planes and its inverse depth; `None` where there is none.
    #[must_use]
    pub fn sample_at(&self, x: usize, y: usize) -> Option<(usize, f32)> {
        let index = self.tile_of(x, y)?;
        let tile = &self.tiles[index];
        let (row, column) = (y % TILE, x % TILE);
        let is_sampled = tile.rows[row] >> column & 1 == 1;
        let before: u32 = tile.rows[..row].iter().map(|row| row.count_ones()).sum();
        let nth = (before + (tile.rows[row] & ((1 << column) - 1)).count_ones()) as usize;
        is_sampled
            .then(|| (tile.first as usize + nth, self.depth.tile(index, tile.first, tile.count()).get(nth)))
    }

    /// Whether the sample at a pixel is doubtful; false without a sample.
    #[must_use]
    pub fn is_doubtful(&self, x: usize, y: usize) -> bool {
        let rows = self.tile_of(x, y).and_then(|tile| self.doubtful_rows(tile));
        rows.is_some_and(|rows| rows[y % TILE] >> (x % TILE) & 1 == 1)
    }

    /// How many samples are doubtful.
    #[must_use]
    pub fn doubtful_count(&self) -> usize {
        self.doubtful.iter().flat_map(|mask| mask.rows).map(|row| row.count_ones() as usize).sum()
    }

    /// An image in its place that holds nothing.
    #[must_use]
    pub fn without_samples(&self) -> Self {
        Self {
            camera: self.camera,
            span: self.span,
            tiles: Vec::new(),
            color: Vec::new(),
            depth: DepthPlane::default(),
            normal: self.normal.as_ref().map(|_| Vec::new()),
            doubtful: Vec::new(),
            values: Values::missing(self.values.channels(), 0),
        }
    }

    /// Every sample with its pixel, in storage order.
    pub fn samples(&self) -> impl Iterator<Item = Sample> + '_ {
        self.tiles.iter().flat_map(SampleTile::samples)
    }

    /// Bytes this image occupies in memory.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let normal = self.normal.as_ref().map_or(0, |normal| size_of_val(normal.as_slice()));
        size_of_val(self.tiles.as_slice())
            + size_of_val(self.color.as_slice())
            + self.depth.bytes()
            + normal
            + size_of_val(self.doubtful.as_slice())
            + self.values.bytes()
    }
}

/// Everything that is left of a capture: what a store holds and what a renderer paints.
#[derive(Clone, Debug)]
pub struct SampleSet {
    /// Name of the capture.
    pub name: String,
    /// The cameras.
    pub cameras: Vec<Camera>,
    /// The number each frame bears in the capture, ascending.
    pub frame_numbers: Vec<i64>,
    /// Up in world space, unit length.
    pub up_in_world: DVec3,
    /// How the set was made.
    pub settings: Settings,
    /// The channels of scalar values that samples have; none as a rule.
    pub values: Vec<ValueChannel>,
    /// Sample images, ordered by span (longest first, then earliest), then by camera. Empty ones are left out, save where a
    /// set holds one frame of a store that plays from disk: the images of other frames are in their places without samples.
    pub images: Vec<std::sync::Arc<SampleImage>>,
}

impl SampleSet {
    /// Whether samples that others represent were dropped.
    #[must_use]
    pub fn is_pruned(&self) -> bool {
        self.settings.pruning.method != PruningMethod::Off
    }

    /// The images whose span contains `frame`, longest span first: together they show every camera at that frame.
    pub fn images_at(&self, frame: usize) -> impl Iterator<Item = &std::sync::Arc<SampleImage>> {
        self.images.iter().filter(move |image| image.span.contains(frame))
    }

    /// Whether some images, by their index, are the very same in another set, and seen by the same cameras.
    #[must_use]
    pub fn shares(&self, other: &Self, images: &[usize]) -> bool {
        let same = |index: &usize| match (self.images.get(*index), other.images.get(*index)) {
            (Some(mine), Some(theirs)) => std::sync::Arc::ptr_eq(mine, theirs),
            _ => false,
        };
        images.iter().all(same) && self.cameras == other.cameras
    }

    /// Samples in all images.
    #[must_use]
    pub fn sample_count(&self) -> u64 {
        self.images.iter().map(|image| image.len() as u64).sum()
    }

    /// Bytes all images occupy in memory.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.images.iter().map(|image| image.bytes() as u64).sum()
    }

    /// Frames per camera.
    #[must_use]
    pub fn frame_count(&self) -> usize {
        self.frame_numbers.len()
    }
}
