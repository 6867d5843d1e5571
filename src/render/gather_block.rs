//! The gather stage for one block of pixels: what stands in each, decided at edges by the votes of the cameras; and the color
//! of every surface point that does.

use super::frame_samples::FrameSamples;
use super::gather::{BLOCK, Gather};
use super::gather_points::SurfacePoints;
use super::keys::{inverse_depth_of, slot_of};
use super::resolve::Rows;
use super::silhouette::{Patch, Pixel, Question, RING, SIDE};
use super::vantage::NO_IMAGE;
use super::votes::{Points, Votes};
use super::window::Windows;

/// What gathering a block needs for a while, and keeps for the next.
pub(super) struct Scratch {
    /// Among the lasting samples, and among all.
    windows: [Windows; 2],
    cameras: Vec<u16>,
    weights: Vec<(f32, u16)>,
    /// What is to be decided at edges, in the order of the pixels.
    questions: Vec<Question>,
    claims: Points,
    votes: Vec<Votes>,
    points: SurfacePoints,
    /// Where the points go.
    layers: Vec<Layer>,
}

/// A surface point's place in the picture.
#[derive(Clone, Copy)]
struct Layer {
    key: u64,
    /// How much it counts in its pixel.
    share: f32,
    /// The pixel, as an index in the strip.
    at: u32,
}

impl Scratch {
    /// For so many cameras.
    pub(super) fn new(cameras: usize) -> Self {
        Self {
            windows: [Windows::new(cameras), Windows::new(cameras)],
            cameras: Vec::new(),
            weights: Vec::new(),
            questions: Vec::new(),
            claims: Points::default(),
            votes: Vec::new(),
            points: SurfacePoints::new(),
            layers: Vec::new(),
        }
    }

    /// Paints a block into the strip of a picture of `width` columns, gathering with one of two [`Gather`]s.
    #[inline(always)]
    pub(super) fn gather(
        &mut self,
        (gather, among): (&Gather<'_>, usize),
        frame: &FrameSamples<'_>,
        patch: &Patch,
        (rows, width): (&mut Rows<'_>, usize),
    ) {
        frame.cameras_of(patch.keys.as_flattened(), &mut self.cameras);
        let middle = patch.keys.as_flattened()[SIDE * SIDE / 2 + SIDE / 2];
        let center = ((patch.left + BLOCK / 2) as f32, (patch.top + BLOCK / 2) as f32);
        let weights = &mut self.weights;
        gather.rank(center, inverse_depth_of(middle).max(0.0), &mut self.cameras, weights);
        let extent = (BLOCK.min(width - patch.left), rows.image.len() / width);
        let mut edges = patch.edges();
        for edges in &mut edges {
            *edges &= (u32::MAX >> (32 - extent.0)) as u16;
        }
        self.ask(patch, &edges[..extent.1]);
        gather.vote(&self.claims, &self.cameras, &mut self.windows[among], &mut self.votes);
        self.settle(frame, patch, (&edges, extent), (rows, width));
        gather.find(&mut self.points, &self.cameras, &mut self.windows[among]);
        for (nth, &Layer { key, share, at }) in self.layers.iter().enumerate() {
            let color = self.points.color(nth, || frame.color_of(slot_of(key)));
            let sum = &mut rows.color[at as usize];
            (0..3).for_each(|channel| sum[channel] += share * color[channel]);
        }
    }

    /// Lists what is to be decided at edges: a mask of columns per row.
    #[inline(always)]
    fn ask(&mut self, patch: &Patch, edges: &[u16]) {
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

    /// Sets depth and image of every pixel of `extent`, and lists its surface points.
    #[inline(always)]
    fn settle(
        &mut self,
        frame: &FrameSamples<'_>,
        patch: &Patch,
        (edges, extent): (&[u16; BLOCK], (usize, usize)),
        (rows, width): (&mut Rows<'_>, usize),
    ) {
        let (mut questions, mut votes) = (self.questions.iter(), self.votes.iter());
        self.points.clear();
        self.layers.clear();
        for row in 0..extent.1 {
            let start = row * width + patch.left;
            let depths = &mut rows.inverse_depth[start..start + extent.0];
            let images = &mut rows.image[start..start + extent.0];
            rows.color[start..start + extent.0].fill([0.0; 3]);
            for column in 0..extent.0 {
                let mut key = patch.keys[row + RING][column + RING];
                let place = ((patch.left + column) as f32, (patch.top + row) as f32);
                let at = (start + column) as u32;
                if edges[row] >> column & 1 == 1 {
                    let Some(question) = questions.next() else { continue };
                    let votes = question.claim().and_then(|_| votes.next().copied());
                    let pixel = question.answer(votes.unwrap_or_default());
                    let mut push = |key, share| {
                        if share > 0.0 {
                            self.points.push(place, inverse_depth_of(key), frame.camera_of(slot_of(key)));
                            self.layers.push(Layer { key, share, at });
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
                    self.points.push(place, inverse_depth_of(key), frame.camera_of(slot_of(key)));
                    self.layers.push(Layer { key, share: 1.0, at });
                }
                depths[column] = inverse_depth_of(key);
                images[column] = if key == 0 { NO_IMAGE } else { frame.image_of(slot_of(key)) };
            }
        }
    }
}
