//! The gather stage for one block of pixels: what stands in each, decided at edges by the votes of the cameras; and the color
//! of every surface point that does.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::silhouette::{EdgePixel, Patch, Pixel, RING, SIDE};
use super::surface_points::SurfacePoints;
use super::view_weights::{BLOCK, SourceViews};
use super::visibility_votes::{VotedPoints, Votes};
use crate::render::input::{FrameSamples, TileCaches};
use crate::render::resolve::PictureRows;
use crate::render::splat::{inverse_depth_of, slot_of};
use crate::render::vantage::NO_IMAGE;

/// Most points ask no more cameras than these.
const ASKED_OFTEN: usize = 3;

/// What gathering a block needs for a while, and keeps for the next.
#[derive(Debug)]
pub(crate) struct GatherScratch {
    /// The block and its ring.
    pub(crate) patch: Patch,
    /// Among the lasting samples, and among all.
    windows: [TileCaches; 2],
    cameras: Vec<u16>,
    weights: Vec<(f32, u16)>,
    /// What is to be decided at edges, in the order of the pixels.
    questions: Vec<EdgePixel>,
    claims: VotedPoints,
    votes: Vec<Votes>,
    points: SurfacePoints,
}

/// What was used and may be used again, by one thread each.
#[derive(Debug, Default)]
pub(crate) struct ScratchPool(Mutex<Vec<GatherScratch>>);

/// One of [`ScratchPool`] on loan.
pub(crate) struct PooledScratch<'a> {
    scratch: Option<GatherScratch>,
    home: &'a ScratchPool,
}

impl ScratchPool {
    /// Forgets what windows show, for another frame or vantage.
    pub(crate) fn forget(&self) {
        for scratch in self.idle().iter_mut() {
            scratch.windows.iter_mut().for_each(TileCaches::forget);
        }
    }

    /// One of them, for so many cameras.
    pub(crate) fn borrow(&self, cameras: usize) -> PooledScratch<'_> {
        let scratch = self.idle().pop().filter(|scratch| scratch.windows[0].camera_count() == cameras);
        PooledScratch { scratch, home: self }
    }

    fn idle(&self) -> MutexGuard<'_, Vec<GatherScratch>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl PooledScratch<'_> {
    /// What was borrowed, or a new one where there was none.
    pub(crate) fn get(&mut self, cameras: usize) -> &mut GatherScratch {
        self.scratch.get_or_insert_with(|| GatherScratch::new(cameras))
    }
}

impl Drop for PooledScratch<'_> {
    fn drop(&mut self) {
        self.home.idle().extend(self.scratch.take());
    }
}

impl GatherScratch {
    /// For so many cameras.
    fn new(cameras: usize) -> Self {
        Self {
            patch: Patch::empty(),
            windows: [TileCaches::new(cameras), TileCaches::new(cameras)],
            cameras: Vec::new(),
            weights: Vec::new(),
            questions: Vec::new(),
            claims: VotedPoints::default(),
            votes: Vec::new(),
            points: SurfacePoints::new(),
        }
    }

    /// Paints some pixels of the block that is loaded, a mask of columns per row, into the strip of a picture of `width` columns, gathering with
    /// one of two [`SourceViews`]s.
    #[inline(always)]
    pub(crate) fn gather(
        &mut self,
        (gather, among): (&SourceViews<'_>, usize),
        frame: &FrameSamples<'_>,
        which: &[u16; BLOCK],
        (rows, width): (&mut PictureRows<'_>, usize),
    ) {
        let patch = &self.patch;
        frame.cameras_of(patch.keys.as_flattened(), &mut self.cameras);
        let middle = patch.keys.as_flattened()[SIDE * SIDE / 2 + SIDE / 2];
        let center = ((patch.left + BLOCK / 2) as f32, (patch.top + BLOCK / 2) as f32);
        let (weights, w) = (&mut self.weights, inverse_depth_of(middle).max(0.0));
        gather.rank(center, w, &mut self.cameras, weights);
        self.fetch_ahead((gather, among), (patch.left, patch.top), w);
        let extent = (BLOCK.min(width - patch.left), rows.image.len() / width);
        let mut which = *which;
        for (row, which) in which.iter_mut().enumerate() {
            *which &= if row < extent.1 { (u32::MAX >> (32 - extent.0)) as u16 } else { 0 };
        }
        let mut edges = patch.edges();
        for (edges, which) in edges.iter_mut().zip(&which) {
            *edges &= which;
        }
        self.ask(&edges[..extent.1]);
        gather.vote(&self.claims, &self.cameras, &mut self.windows[among], &mut self.votes);
        self.settle(frame, (&edges, &which), (rows, width));
        gather.find(&mut self.points, &self.cameras, &mut self.windows[among]);
        for nth in 0..self.points.count() {
            let (key, share, pixel) = self.points.layer(nth);
            let color = self.points.color(nth, || frame.color_of(slot_of(key)));
            let sum = &mut rows.color[pixel as usize];
            (0..3).for_each(|channel| sum[channel] += share * color[channel]);
        }
    }

    /// Asks for what the next block will read of the cameras that count most for this one, at inverse depth `w`.
    #[inline(always)]
    fn fetch_ahead(&self, (gather, among): (&SourceViews<'_>, usize), (left, top): (usize, usize), w: f32) {
        let right = (left + 2 * BLOCK) as f32;
        for &camera in self.cameras.iter().take(ASKED_OFTEN) {
            for y in [top, top + BLOCK] {
                if let Some(pixel) = gather.pixel_in(camera, (right, y as f32), w) {
                    self.windows[among].fetch_ahead(&gather.lookup, camera as usize, pixel);
                }
            }
        }
    }

    /// Lists what is to be decided at edges: a mask of columns per row.
    #[inline(always)]
    fn ask(&mut self, edges: &[u16]) {
        let patch = &self.patch;
        self.questions.clear();
        self.claims.clear();
        for (row, &edges) in edges.iter().enumerate() {
            let mut left = edges;
            while left != 0 {
                let column = left.trailing_zeros() as usize % BLOCK;
                left &= left - 1;
                let question = patch.question(column, row);
                if let Some(claim) = question.claim() {
                    let (x, y) = ((patch.left + column) as f32, (patch.top + row) as f32);
                    self.claims.push(x, y, inverse_depth_of(claim));
                }
                self.questions.push(question);
            }
        }
    }

    /// Sets depth and image of some pixels, a mask of columns per row, and lists their surface points.
    #[inline(always)]
    fn settle(
        &mut self,
        frame: &FrameSamples<'_>,
        (edges, which): (&[u16; BLOCK], &[u16; BLOCK]),
        (rows, width): (&mut PictureRows<'_>, usize),
    ) {
        let patch = &self.patch;
        let columns = BLOCK.min(width - patch.left);
        let (mut questions, mut votes) = (self.questions.iter(), self.votes.iter());
        self.points.clear();
        for row in (0..BLOCK).filter(|row| which[*row] != 0) {
            let start = row * width + patch.left;
            let depths = &mut rows.inverse_depth[start..start + columns];
            let images = &mut rows.image[start..start + columns];
            let colors = &mut rows.color[start..start + columns];
            let first = (patch.left as f32, (patch.top + row) as f32);
            if edges[row] == 0
                && which[row] == u16::MAX
                && let Some(keys) = patch.keys[row + RING][RING..].first_chunk::<BLOCK>()
                && let Some(depths) = depths.first_chunk_mut::<BLOCK>()
                && keys.iter().all(|key| *key != 0)
            {
                let mut cameras = [0; BLOCK];
                for ((key, camera), image) in keys.iter().zip(&mut cameras).zip(images) {
                    (*camera, *image) = (frame.camera_of(slot_of(*key)), frame.image_of(slot_of(*key)));
                }
                colors.fill([0.0; 3]);
                self.points.push_row(keys, first, (start as u32, &cameras), depths);
                continue;
            }
            for column in (0..columns).filter(|column| which[row] >> column & 1 == 1) {
                colors[column] = [0.0; 3];
                let mut key = patch.keys[row + RING][column + RING];
                let place = ((patch.left + column) as f32, (patch.top + row) as f32);
                let at = (start + column) as u32;
                if edges[row] >> column & 1 == 1 {
                    let Some(question) = questions.next() else { continue };
                    let votes = question.claim().and_then(|_| votes.next().copied());
                    let pixel = question.answer(votes.unwrap_or_default());
                    let mut push = |key, share| {
                        if share > 0.0 {
                            self.points.push(key, place, (at, share), frame.camera_of(slot_of(key)));
                        }
                    };
                    key = match pixel {
                        Pixel::Hole => 0,
                        Pixel::Surface(key) => {
                            push(key, 1.0);
                            key
                        }
                        Pixel::Edge { near, far, share } => {
                            push(near, share);
                            push(far, 1.0 - share);
                            if share >= 0.5 { near } else { far }
                        }
                    };
                } else if key != 0 {
                    self.points.push(key, place, (at, 1.0), frame.camera_of(slot_of(key)));
                }
                depths[column] = inverse_depth_of(key);
                images[column] = if key == 0 { NO_IMAGE } else { frame.image_of(slot_of(key)) };
            }
        }
    }
}
