//! What other cameras say of kept samples: how many confirm each, and how many look past it.
//!
//! Purpose: selecting by evidence, and showing it, once pruning is done. While it prunes, samples are voted on with the noise that is
//! measured then, by runs in vectors ([`crate::preprocess::agreement`]); here each sample is looked up once, at the first frame of its
//! span, with one tolerance. Source: as there, P. Merrell et al., 2007. What differs: a camera that sees the surface in any of the 3×3
//! pixels around confirms; one looks past only if all of them are farther and its pixels are no coarser than twice the sample's.

use rayon::prelude::*;

use super::seen::{PixelRays, Votes};
use crate::capture::sighting::tolerances::NOISY_PIXEL;
use crate::capture::sighting::{Landing, Sighting};
use crate::capture::{Camera, Capture, Frame, PixelSide};
use crate::error::Result;
use crate::job::Job;
use crate::samples::{ImageBuffer, SampleImage};

/// The votes on all samples of some images.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SampleVotes {
    /// For each image, for each of its samples.
    images: Vec<Vec<Votes>>,
}

/// A camera with what it saw at one moment.
struct Witness<'a> {
    camera: &'a Camera,
    frame: std::sync::Arc<Frame>,
    /// Width of a pixel at depth 1.
    pixel_width: f64,
}

impl SampleVotes {
    /// Asks the frames of a capture about the samples of images. Cameras are those that the samples are of; a camera is recognized by
    /// its name, and one that the capture does not have says nothing.
    ///
    /// # Errors
    /// Whatever the capture gives (naming file and frame), `Io` as [`ImageBuffer::get`], and `Cancelled`.
    pub fn of(images: &ImageBuffer, cameras: &[Camera], capture: &Capture, job: &Job) -> Result<Self> {
        let mut order: Vec<usize> = (0..images.len()).collect();
        let start = |index: &usize| images.facts_of(*index).span.start;
        order.sort_by_key(start);
        job.start("Asking other cameras", order.len());
        let mut votes = vec![Vec::new(); order.len()];
        for of_frame in order.chunk_by(|a, b| start(a) == start(b)) {
            let frame = start(&of_frame[0]) as usize;
            let witnesses = witnesses(cameras, capture, frame)?;
            let asked: Vec<(usize, Vec<Votes>)> = of_frame
                .par_iter()
                .map(|&index| {
                    job.check()?;
                    let asked = votes_on(&*images.get(index)?, cameras, &witnesses);
                    job.advance(1);
                    Ok((index, asked))
                })
                .collect::<Result<_>>()?;
            for (index, asked) in asked {
                votes[index] = asked;
            }
        }
        Ok(Self { images: votes })
    }

    /// The votes on the samples of an image, in their order; empty where there is no such image.
    #[must_use]
    pub fn of_image(&self, index: usize) -> &[Votes] {
        self.images.get(index).map_or(&[], Vec::as_slice)
    }
}

/// The cameras at a frame; `None` where the capture does not have one.
fn witnesses<'a>(cameras: &'a [Camera], capture: &Capture, frame: usize) -> Result<Vec<Option<Witness<'a>>>> {
    let witness = |camera: &'a Camera| {
        let known = capture.cameras.iter().position(|known| known.name == camera.name);
        let Some(known) = known.filter(|_| frame < capture.frame_count()) else { return Ok(None) };
        let pixel_width = camera.intrinsics.pixel_width(1.0, PixelSide::Longer);
        Ok(Some(Witness { camera, frame: capture.frame(known, frame)?, pixel_width }))
    };
    cameras.par_iter().map(witness).collect()
}

fn votes_on(image: &SampleImage, cameras: &[Camera], witnesses: &[Option<Witness<'_>>]) -> Vec<Votes> {
    let own = image.camera as usize;
    let rays = PixelRays::of(&cameras[own]);
    let lens = &cameras[own].intrinsics;
    let own_width = lens.pixel_width(1.0, PixelSide::Longer);
    let inverse_depths = image.inverse_depths();
    let others = || witnesses.iter().enumerate().filter(|(other, _)| *other != own);
    let mut votes = Vec::with_capacity(image.len());
    for sample in image.samples() {
        let mut counted = Votes::default();
        let inverse_depth = inverse_depths[sample.index];
        if inverse_depth > 0.0 {
            let seen = rays.seen(sample.x, sample.y, inverse_depth);
            for witness in others().filter_map(|(_, witness)| witness.as_ref()) {
                let size = witness.frame.size();
                let Some(landing) = Landing::of(seen.point_in_world, witness.camera, size) else { continue };
                let footprint = lens.spread_at(seen.depth) * own_width;
                match witness.says(&landing, footprint) {
                    Some(true) => counted.confirm = counted.confirm.saturating_add(1),
                    Some(false) => counted.look_past = counted.look_past.saturating_add(1),
                    None => {}
                }
            }
        } else {
            // Depth tells nothing of the sky: it is neither doubted nor contradicted.
            counted.confirm = u8::MAX;
        }
        votes.push(counted);
    }
    votes
}

impl Witness<'_> {
    /// Whether it confirms a point (true) or looks past it (false) with a pixel this wide; `None` where it cannot tell.
    fn says(&self, landing: &Landing, footprint: f64) -> Option<bool> {
        /// A pixel this many times as wide would have missed what is thin.
        const RESOLVES: f64 = 2.0;
        let depth = &self.frame.inverse_depth;
        let (x, y) = landing.pixel;
        let (width, height) = depth.size();
        let mut farther = true;
        for row in y.saturating_sub(1)..(y + 2).min(height) {
            for &inverse_depth in &depth.row(row)[x.saturating_sub(1)..(x + 2).min(width)] {
                match landing.compare(inverse_depth, NOISY_PIXEL) {
                    Sighting::Same => return Some(true),
                    Sighting::Farther => {}
                    // The sky is farther than any point; a pixel without depth says nothing.
                    Sighting::NoDepth => farther &= inverse_depth == 0.0,
                    Sighting::Nearer | Sighting::Outside => farther = false,
                }
            }
        }
        let width = self.camera.intrinsics.spread_at(landing.depth) * self.pixel_width;
        (farther && width <= RESOLVES * footprint).then_some(false)
    }
}
