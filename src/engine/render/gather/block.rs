//! The gather stage for some blocks of pixels: which surfaces each pixel shows, decided block by block, at edges by the votes of the
//! cameras, and the color of each of these surface points.

use std::time::Instant;

use super::interpolate::{BlockCameras, ListedBlock, find_colors};
use super::near_cameras::{NearCameras, coarse_cameras, list_cameras};
use super::silhouette::{EdgePixel, Patch, PixelSurfaces, RING, SIDE};
use super::subpixels::{DecidedEdges, set_surfaces_of_pairs};
use super::surface_points::{PixelShares, StripPixel, SurfaceDepth, SurfacePoints};
use super::target::{BLOCK, PictureRows, set_images};
use super::view_weights::SourceViews;
use super::visibility_votes::{VisibilityVotes, VotedPoints, vote};
use crate::render::input::{FrameSamples, TileCaches};
use crate::render::splat::{inverse_depth_of, slot_of};
use crate::render::vantage::{FrontColor, NO_FRONT, NO_IMAGE};

/// Tiles are prefetched for this many cameras, the best ones: most points read no more.
const PREFETCHED_CAMERAS: usize = 3;

/// Memory that gathering blocks needs, kept for the next ones.
#[derive(Debug)]
pub(crate) struct GatherScratch {
    /// The block and its ring.
    pub(crate) patch: Patch,
    /// Unpacked tiles of the background, and of all samples.
    caches: [TileCaches; 2],
    cameras: Vec<u16>,
    weights: Vec<(f32, u16)>,
    near: NearCameras,
    /// The blocks whose colors are to be looked up.
    listed: BlockCameras,
    /// Pixels at steps in depth, row by row.
    edge_pixels: Vec<EdgePixel>,
    voted_points: VotedPoints,
    votes: Vec<VisibilityVotes>,
    points: Box<SurfacePoints>,
    /// Nanoseconds spent on silhouettes and on look-ups.
    pub(super) spent_ns: [u64; 2],
}

impl GatherScratch {
    /// Scratch memory for this many cameras.
    pub(super) fn new(cameras: usize) -> Self {
        Self {
            patch: Patch::empty(),
            caches: [TileCaches::new(cameras), TileCaches::new(cameras)],
            cameras: Vec::new(),
            weights: Vec::new(),
            near: NearCameras::new(cameras),
            listed: BlockCameras::default(),
            edge_pixels: Vec::new(),
            voted_points: VotedPoints::default(),
            votes: Vec::new(),
            points: SurfacePoints::new(),
            spent_ns: [0; 2],
        }
    }

    /// The number of cameras that it was made for.
    pub(super) fn camera_count(&self) -> usize {
        self.caches[0].camera_count()
    }

    /// Empties the tile caches.
    pub(super) fn forget(&mut self) {
        self.caches.iter_mut().for_each(TileCaches::forget);
    }

    /// Begins anew: no colors are to be looked up.
    pub(crate) fn begin(&mut self) {
        self.points.clear();
        self.listed.clear();
    }

    /// Decides what some pixels of the loaded block show, a mask of columns per row: all but their colors are set in the rows of a picture.
    /// `views` are those of the `nth` tile cache. At most [`TOGETHER`](super::target::TOGETHER) blocks are listed until colors are found.
    #[inline(always)]
    pub(crate) fn decide(
        &mut self,
        views: &SourceViews<'_>,
        nth: usize,
        which: &[u16; BLOCK],
        rows: &mut PictureRows<'_>,
    ) {
        let started = Instant::now();
        let (patch, frame) = (&self.patch, views.lookup.frame);
        let keys = patch.keys.as_flattened();
        list_cameras(keys, frame, &mut self.cameras);
        let center = ((patch.left + BLOCK / 2) as f32, (patch.top + BLOCK / 2) as f32);
        let w = inverse_depth_of(keys[SIDE * SIDE / 2 + SIDE / 2]).max(0.0);
        let slope = patch.slope(BLOCK / 2, BLOCK / 2);
        views.rank(center, w, slope, &mut self.cameras, &mut self.weights);
        if views.pruned && NearCameras::pay_off(&self.cameras) {
            self.near.find(patch, frame, &self.cameras, coarse_cameras(views, center, w, &self.cameras));
        } else {
            self.near.set_all();
        }
        self.prefetch(views, nth, w);
        let (columns, row_count) = rows.extent(patch.left);
        let subpixels = rows.subpixels;
        let mut which = *which;
        for (row, which) in which.iter_mut().enumerate() {
            *which &= if row < row_count { (u32::MAX >> (32 - columns)) as u16 } else { 0 };
        }
        let mut edges = patch.edges();
        for (edges, which) in edges.iter_mut().zip(&which) {
            *edges &= which;
        }
        self.list_edge_pixels(&edges[..row_count], subpixels);
        vote(views, &self.voted_points, &self.cameras, &mut self.caches[nth], &mut self.votes);
        let first = self.points.begin_block();
        if subpixels == 1 {
            self.set_surfaces(frame, &edges, &which, rows);
        } else {
            let decided = DecidedEdges { edges, pixels: &self.edge_pixels, votes: &self.votes };
            let decided = (decided, &self.near);
            set_surfaces_of_pairs(&self.patch, frame, decided, &which, rows, &mut self.points);
        }
        let listed = self.listed.cameras.len();
        self.listed.cameras.extend_from_slice(&self.cameras);
        let (points, cameras) = (first..self.points.end(), listed..self.listed.cameras.len());
        self.listed.blocks.push(ListedBlock { points, cameras });
        self.spent_ns[0] += started.elapsed().as_nanos() as u64;
    }

    /// Finds the colors of the listed blocks; each is then added to its rows.
    #[inline(always)]
    pub(crate) fn find_colors(&mut self, views: &SourceViews<'_>, nth: usize) {
        let started = Instant::now();
        find_colors(views, &mut self.points, &mut self.listed, &mut self.caches[nth]);
        self.spent_ns[1] += started.elapsed().as_nanos() as u64;
    }

    /// Adds the colors of the `nth` listed block to the rows of the picture that it was decided for.
    #[inline(always)]
    pub(crate) fn add_colors(&mut self, nth: usize, frame: &FrameSamples<'_>, rows: &mut PictureRows<'_>) {
        let started = Instant::now();
        let block = self.listed.blocks[nth].points.clone();
        self.points.add_colors(block, rows.color, rows.fronts, |key| frame.color_of(slot_of(key)));
        self.spent_ns[1] += started.elapsed().as_nanos() as u64;
    }

    /// Prefetches the tiles that the next block will read from the cameras that count most for this one, at inverse depth `w`.
    #[inline(always)]
    fn prefetch(&self, views: &SourceViews<'_>, nth: usize, w: f32) {
        let right = (self.patch.left + 2 * BLOCK) as f32;
        for &camera in self.cameras.iter().take(PREFETCHED_CAMERAS) {
            for y in [self.patch.top, self.patch.top + BLOCK] {
                if let Some(pixel) = views.pixel_in(camera, (right, y as f32), w) {
                    self.caches[nth].prefetch(&views.lookup, camera as usize, pixel);
                }
            }
        }
    }

    /// Lists the pixels at steps in depth, a mask of columns per row, and the points that cameras vote on; those that share a pixel
    /// of the picture one after another.
    #[inline(always)]
    fn list_edge_pixels(&mut self, edges: &[u16], subpixels: usize) {
        let patch = &self.patch;
        self.edge_pixels.clear();
        self.voted_points.clear();
        for (nth, edges) in edges.chunks(subpixels).enumerate() {
            if edges.iter().all(|edges| *edges == 0) {
                continue;
            }
            // Not by closures, which would be compiled for the least instruction set.
            let mut around = [None, None];
            for (row, (edges, around)) in edges.iter().zip(&mut around).enumerate() {
                if *edges != 0 {
                    *around = Some(patch.edge_row(nth * subpixels + row));
                }
            }
            let mut left = edges.iter().fold(0, |all, row| all | row);
            while left != 0 {
                let first = left.trailing_zeros() as usize % BLOCK / subpixels * subpixels;
                left &= !(((1 << subpixels) - 1) << first);
                for (row, (edges, around)) in edges.iter().zip(&around).enumerate() {
                    let Some(around) = around else { continue };
                    for column in first..first + subpixels {
                        if edges >> column & 1 == 0 {
                            continue;
                        }
                        let row = nth * subpixels + row;
                        let edge_pixel = patch.edge_pixel(column, row, around);
                        if let Some(key) = edge_pixel.voted_key() {
                            let (x, y) = ((patch.left + column) as f32, (patch.top + row) as f32);
                            self.voted_points.push(x, y, inverse_depth_of(key));
                        }
                        self.edge_pixels.push(edge_pixel);
                    }
                }
            }
        }
    }

    /// Sets depth and image of the pixels of `which`, and lists their surface points. The votes decide the pixels of `edges`. Both are
    /// masks of columns per row.
    #[inline(always)]
    fn set_surfaces(
        &mut self,
        frame: &FrameSamples<'_>,
        edges: &[u16; BLOCK],
        which: &[u16; BLOCK],
        rows: &mut PictureRows<'_>,
    ) {
        let patch = &self.patch;
        let columns = BLOCK.min(rows.width - patch.left);
        let (mut edge_pixels, mut votes) = (self.edge_pixels.iter(), self.votes.iter());
        for row in (0..BLOCK).filter(|row| which[*row] != 0) {
            let start = row * rows.width + patch.left;
            let depths = &mut rows.inverse_depth[start..start + columns];
            let images = &mut rows.image[start..start + columns];
            let colors = &mut rows.color[start..start + columns];
            let first =
                StripPixel { x: patch.left as f32, y: (patch.top + row) as f32, at: start as u32, near: 0 };
            if edges[row] == 0
                && which[row] == u16::MAX
                && let Some(keys) = patch.keys[row + RING][RING..].first_chunk::<BLOCK>()
                && let Some(depths) = depths.first_chunk_mut::<BLOCK>()
                && keys.iter().all(|key| *key != 0)
            {
                let cameras = set_images(keys, frame, images);
                for i in 0..BLOCK {
                    depths[i] = inverse_depth_of(keys[i]);
                }
                colors.fill([0.0; 3]);
                if let Some(fronts) = rows.fronts.get_mut(start..start + columns) {
                    fronts.fill(NO_FRONT);
                }
                let mut slopes = [[0.0; BLOCK]; 2];
                for column in 0..BLOCK {
                    [slopes[0][column], slopes[1][column]] = patch.slope(column, row);
                }
                self.points.push_row(keys, depths, &slopes, (&cameras, &self.near.row(row, 1)), first, 1.0);
                continue;
            }
            for column in (0..columns).filter(|column| which[row] >> column & 1 == 1) {
                colors[column] = [0.0; 3];
                let pixel = StripPixel {
                    x: (patch.left + column) as f32,
                    at: (start + column) as u32,
                    near: self.near.mask(column, row),
                    ..first
                };
                let mut push = |key, shares: PixelShares| {
                    let own = frame.camera_of(slot_of(key));
                    let slope = if shares.pixel == 1.0 { patch.slope(column, row) } else { [0.0; 2] };
                    self.points.push(
                        key,
                        SurfaceDepth { w: inverse_depth_of(key), slope },
                        own,
                        pixel,
                        shares,
                    );
                };
                let (mut key, mut front) = (patch.keys[row + RING][column + RING], NO_FRONT);
                if edges[row] >> column & 1 == 1 {
                    let Some(edge_pixel) = edge_pixels.next() else { continue };
                    let votes = edge_pixel.voted_key().and_then(|_| votes.next().copied());
                    (key, front) = push_surfaces(edge_pixel.decide(votes.unwrap_or_default(), 1), push);
                } else if key != 0 {
                    push(key, PixelShares::WHOLE);
                }
                if let Some(place) = rows.fronts.get_mut(start + column) {
                    *place = front;
                }
                depths[column] = inverse_depth_of(key);
                images[column] = if key == 0 { NO_IMAGE } else { frame.image_of(slot_of(key)) };
            }
        }
    }
}

/// Gives `push` the key and the shares of each surface that an edge pixel shows. Returns the key of the surface that covers most of
/// the pixel, 0 in a hole, and the pixel's front.
#[inline(always)]
fn push_surfaces(surfaces: PixelSurfaces, mut push: impl FnMut(u64, PixelShares)) -> (u64, FrontColor) {
    let mut front = NO_FRONT;
    let key = match surfaces {
        PixelSurfaces::Hole => 0,
        PixelSurfaces::One(key) => {
            push(key, PixelShares::WHOLE);
            key
        }
        PixelSurfaces::Two { near, far, share } => {
            if share > 0.0 && share < 1.0 {
                (front[3], front[4]) = (inverse_depth_of(far), share);
            }
            let front_share = if share < 1.0 { 1.0 } else { 0.0 };
            for (key, pixel, front) in [(near, share, front_share), (far, 1.0 - share, 0.0)] {
                if pixel > 0.0 {
                    push(key, PixelShares { pixel, front });
                }
            }
            if share >= 0.5 { near } else { far }
        }
    };
    (key, front)
}
