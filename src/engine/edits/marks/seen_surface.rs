//! What a picture shows within what is drawn in it, whichever camera's samples stand for it.
//!
//! Purpose: a thing that is outlined in one picture is selected with all that pruning kept of it, not with this camera's samples alone.
//! Source: a z-buffer (W. Straßer, 1974; E. Catmull, 1974) of the samples of one frame, each as large as its pixel is there. What
//! differs: where the camera of the picture kept a sample of its own, that decides, so that what others misread before it hides nothing.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

use glam::{DAffine3, DVec2};
use rayon::prelude::*;

use crate::capture::sighting::tolerances::NOISY_PIXEL;
use crate::capture::sighting::{Landing, Sighting};
use crate::capture::{BoxInPicture, Camera, Intrinsics, PixelSide};
use crate::edits::drawn_area::DrawnArea;
use crate::edits::region::Region;
use crate::edits::seen::{ImageMarks, PixelRays, Seen};
use crate::edits::tile::Tile;
use crate::error::Result;
use crate::job::Job;
use crate::samples::{ImageBuffer, SampleImage, SampleSet};

/// No sample of the picture's own camera. No inverse depth has these bits.
const NONE: u32 = u32::MAX;

/// A sample covers at most this many pixels to each side.
const WIDEST: f64 = 16.0;

/// A drawn area of a picture.
pub(super) struct SeenSurface<'a> {
    lens: Intrinsics,
    camera_from_world: DAffine3,
    /// The camera of the picture, where it has samples.
    own: Option<&'a Camera>,
    area: DrawnArea,
    depth: Option<[f64; 2]>,
    columns: Range<usize>,
    rows: Range<usize>,
}

/// Inverse depths in the part of the picture that is drawn on, row-major, as bits: of what is not negative, larger numbers have larger bits.
struct DepthPart {
    own: Vec<AtomicU32>,
    nearest: Vec<AtomicU32>,
}

impl<'a> SeenSurface<'a> {
    /// `None` where its camera is not there, or nothing is drawn within the picture.
    pub(super) fn of(region: &Region, cameras: &'a [Camera]) -> Option<Self> {
        let (lens, camera_from_world, own, area, depth) = match region {
            Region::Pixels { camera, outline, strokes, .. } => {
                let own = cameras.iter().find(|known| known.name == *camera)?;
                (own.intrinsics, own.camera_from_world(), Some(own), DrawnArea::new(outline, strokes), None)
            }
            Region::View { viewpoint, outline, strokes, depth, .. } => {
                let area = DrawnArea::new(outline, strokes);
                (viewpoint.lens(), viewpoint.camera_from_world(), None, area, *depth)
            }
            _ => return None,
        };
        let [least, most] = area.bounds();
        let within = |least: f64, most: f64, side: u32| {
            // Its neighbors are looked at as well.
            let side = f64::from(side);
            ((least - 1.0).clamp(0.0, side) as usize)..((most + 2.0).clamp(0.0, side) as usize)
        };
        let (columns, rows) = (within(least.x, most.x, lens.width), within(least.y, most.y, lens.height));
        let is_empty = columns.is_empty() || rows.is_empty();
        (!is_empty).then_some(Self { lens, camera_from_world, own, area, depth, columns, rows })
    }

    /// Marks the samples of a frame that show what is seen there.
    pub(super) fn marks(
        &self,
        images: &ImageBuffer,
        outline: &SampleSet,
        frame: usize,
        job: &Job,
    ) -> Result<Vec<ImageMarks>> {
        let pixels = self.columns.len() * self.rows.len();
        let part = DepthPart {
            own: (0..pixels).map(|_| AtomicU32::new(NONE)).collect(),
            nearest: (0..pixels).map(|_| AtomicU32::new(0)).collect(),
        };
        let shown: Vec<usize> =
            (0..images.len()).filter(|index| images.facts_of(*index).span.contains(frame)).collect();
        shown.par_iter().try_for_each(|&index| -> Result<()> {
            job.check()?;
            let image = images.get(index)?;
            self.paint(&image, &outline.cameras[image.camera as usize], &part);
            Ok(())
        })?;
        let mut marks = vec![None; images.len()];
        let found: Vec<ImageMarks> = shown
            .par_iter()
            .map(|&index| {
                job.check()?;
                let image = images.get(index)?;
                Ok(self.marked(&image, &outline.cameras[image.camera as usize], &part))
            })
            .collect::<Result<_>>()?;
        for (index, found) in shown.into_iter().zip(found) {
            marks[index] = found;
        }
        Ok(marks)
    }

    /// Where a sample lies in the picture, and how deep; infinitely deep for the sky.
    fn landing(&self, seen: &Seen<'_>) -> Option<Landing> {
        let size = self.lens.size();
        if seen.depth.is_finite() {
            return Landing::through(
                &self.lens,
                self.camera_from_world.transform_point3(seen.point_in_world),
                size,
            );
        }
        let direction = self.camera_from_world.transform_vector3(seen.direction_in_world);
        Landing::at(&self.lens, self.lens.project(direction)?, f64::INFINITY, size)
    }

    fn is_own(&self, camera: &Camera) -> bool {
        self.own.is_some_and(|own| std::ptr::eq(own, camera))
    }

    fn place_of(&self, tile: &Tile<'_>) -> BoxInPicture {
        tile.space.in_picture(&self.lens, &self.camera_from_world)
    }

    /// Between the edges of the pixels that are looked at.
    fn looked_at(&self) -> [DVec2; 2] {
        let at = |x: usize, y: usize| DVec2::new(x as f64, y as f64);
        [at(self.columns.start, self.rows.start), at(self.columns.end, self.rows.end)]
    }

    fn place(&self, x: usize, y: usize) -> Option<usize> {
        let is_within = self.columns.contains(&x) && self.rows.contains(&y);
        is_within.then(|| (y - self.rows.start) * self.columns.len() + x - self.columns.start)
    }

    fn paint(&self, image: &SampleImage, camera: &Camera, part: &DepthPart) {
        let rays = PixelRays::of(camera);
        let is_own = self.is_own(camera);
        // Pixels of the picture along half of one of the camera's at the same depth.
        let width = |lens: &Intrinsics| lens.pixel_width(1.0, PixelSide::Longer);
        let magnified = 0.5 * width(&camera.intrinsics) / width(&self.lens);
        let looked_at = self.looked_at();
        let near =
            Tile::all(image, camera).filter(|tile| !self.place_of(tile).is_off(looked_at, WIDEST + 1.0));
        for (sample, inverse_depth) in near.flat_map(|tile| tile.samples()) {
            if is_own {
                if let Some(at) = self.place(sample.x, sample.y) {
                    part.own[at].store(inverse_depth.to_bits(), Ordering::Relaxed);
                }
                continue;
            }
            let seen = rays.seen(sample.x, sample.y, inverse_depth);
            let Some(landing) = self.landing(&seen).filter(|landing| landing.depth.is_finite()) else {
                continue;
            };
            let (seen_at, here) =
                (camera.intrinsics.spread_at(seen.depth), self.lens.spread_at(landing.depth));
            let half = DVec2::splat((magnified * seen_at / here).min(WIDEST));
            let bits = ((1.0 / landing.depth) as f32).to_bits();
            // The pixels whose centers it covers, and the one that it lies in.
            let ends = [landing.position - half, landing.position + half];
            let [first, last] = ends.map(|end| (end - 0.5).max(DVec2::ZERO));
            let (x, y) = landing.pixel;
            for row in y.min(first.y.ceil() as usize)..=y.max(last.y as usize) {
                for column in x.min(first.x.ceil() as usize)..=x.max(last.x as usize) {
                    if let Some(at) = self.place(column, row) {
                        part.nearest[at].fetch_max(bits, Ordering::Relaxed);
                    }
                }
            }
        }
    }

    fn marked(&self, image: &SampleImage, camera: &Camera, part: &DepthPart) -> ImageMarks {
        let rays = PixelRays::of(camera);
        let mut marks = None;
        let drawn = self.area.bounds();
        let near = Tile::all(image, camera).filter(|tile| !self.place_of(tile).is_off(drawn, 1.0));
        for (sample, inverse_depth) in near.flat_map(|tile| tile.samples()) {
            let seen = rays.seen(sample.x, sample.y, inverse_depth);
            let Some(landing) = self.landing(&seen).filter(|at| self.area.contains(at.position)) else {
                continue;
            };
            let is_in_range = self.depth.is_none_or(|[from, to]| (from..=to).contains(&landing.depth));
            if is_in_range && (self.is_own(camera) || self.shows(&landing, part)) {
                let marks = marks.get_or_insert_with(|| vec![false; image.len()].into_boxed_slice());
                marks[sample.index] = true;
            }
        }
        marks
    }

    /// Whether the picture shows a sample: one of the nine pixels around does.
    fn shows(&self, landing: &Landing, part: &DepthPart) -> bool {
        let (x, y) = landing.pixel;
        let near = (y.saturating_sub(1)..y + 2)
            .flat_map(|row| (x.saturating_sub(1)..x + 2).map(move |column| (column, row)));
        near.filter_map(|(column, row)| self.place(column, row)).any(|at| {
            let own = part.own[at].load(Ordering::Relaxed);
            let bits = if own == NONE { part.nearest[at].load(Ordering::Relaxed) } else { own };
            let inverse_depth = f32::from_bits(bits);
            if landing.depth.is_finite() {
                landing.compare(inverse_depth, NOISY_PIXEL) == Sighting::Same
            } else {
                inverse_depth == 0.0
            }
        })
    }
}
