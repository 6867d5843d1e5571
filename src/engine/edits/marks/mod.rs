//! Regions that depend on other samples than the one that is asked about: what a picture shows, a surface that a sample lies on, what is
//! near others. They are worked out once for all samples, before edits act.
//!
//! ```text
//! region ─▶ those of its parts that depend on other samples, inner ones first ─▶ a mark for each sample of each image
//! ```

mod grown;
mod placed_points;
mod point_tree;
mod same_surface;
mod seen_surface;

use glam::DVec3;
use rayon::prelude::*;

use super::region::Region;
use super::region_test::{RegionContext, RegionTest};
use super::seen::{Evidence, ImageMarks};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::plural::counted;
use crate::samples::{ImageBuffer, SampleSet, SampleVotes};
use grown::grown;
use same_surface::SurfaceRule;
use seen_surface::SeenSurface;

/// Which samples are in which of such regions.
#[derive(Debug, Default)]
pub(super) struct SampleMarks {
    regions: Vec<Region>,
    /// For each image, for each region.
    images: Vec<Vec<ImageMarks>>,
}

impl SampleMarks {
    /// Works out all such parts of some regions. `outline` is all of the set but its images; `votes` are those on the images; `place` is
    /// named in errors.
    ///
    /// # Errors
    /// `Invalid` where a region names a frame that is not there, or asks for normals that are not there; `Io` as [`ImageBuffer::get`]; `Cancelled`.
    pub(super) fn of<'a>(
        images: &ImageBuffer,
        outline: &SampleSet,
        regions: impl Iterator<Item = &'a Region>,
        votes: Option<&SampleVotes>,
        place: &str,
        job: &Job,
    ) -> Result<Self> {
        let mut asked = Vec::new();
        regions.for_each(|region| region.note_those_that_ask_others(&mut asked));
        let mut marks = Self::default();
        if !asked.is_empty() {
            marks.images = vec![Vec::new(); images.len()];
        }
        for region in asked {
            job.check()?;
            let found = marks.found(region, images, outline, votes, place, job)?;
            marks.images.iter_mut().zip(found).for_each(|(of_image, found)| of_image.push(found));
            marks.regions.push(region.clone());
        }
        Ok(marks)
    }

    /// The marks of one region, of whose parts the marks are known.
    fn found(
        &self,
        region: &Region,
        images: &ImageBuffer,
        outline: &SampleSet,
        votes: Option<&SampleVotes>,
        place: &str,
        job: &Job,
    ) -> Result<Vec<ImageMarks>> {
        let nothing = || vec![None; images.len()];
        match region {
            Region::Pixels { frame: Some(number), .. } | Region::View { frame: Some(number), .. } => {
                let frame = frame_at(outline, *number, place)?;
                let seen = SeenSurface::of(region, &outline.cameras);
                seen.map_or_else(|| Ok(nothing()), |seen| seen.marks(images, outline, frame, job))
            }
            Region::SameSurface { seed, frame, footprints, angle, radius } => {
                let rule = SurfaceRule {
                    seed_in_world: DVec3::from(*seed),
                    frame: frame_at(outline, *frame, place)?,
                    footprints: *footprints,
                    least_cosine: angle.to_radians().cos() as f32,
                    radius: *radius,
                };
                rule.marks(images, outline, job)
            }
            Region::Grow { region: part, footprints } | Region::Shrink { region: part, footprints } => {
                let inside = self.inside(part, images, outline, votes, job)?;
                grown(images, outline, &inside, *footprints, matches!(region, Region::Grow { .. }), job)
            }
            _ => Ok(nothing()),
        }
    }

    /// Which samples are in a region of whose parts the marks are known.
    fn inside(
        &self,
        region: &Region,
        images: &ImageBuffer,
        outline: &SampleSet,
        votes: Option<&SampleVotes>,
        job: &Job,
    ) -> Result<Vec<ImageMarks>> {
        let of_image = |index: usize| {
            job.check()?;
            let facts = images.facts_of(index);
            let camera = &outline.cameras[facts.camera as usize];
            let context = RegionContext { camera, channels: &outline.values, marked: &self.regions };
            let test = RegionTest::new(region, context);
            if let RegionTest::Constant(inside) = test {
                return Ok(inside.then(|| vec![true; facts.samples].into_boxed_slice()));
            }
            let image = images.get(index)?;
            let votes = votes.map_or(&[][..], |votes| votes.of_image(index));
            let evidence =
                Evidence::new(&image, votes, self.of_image(index), test.asks_for_normals(), camera)?;
            let mut inside: ImageMarks = None;
            test.for_each_inside(&image, camera, &evidence, |sample| {
                inside.get_or_insert_with(|| vec![false; image.len()].into())[sample.index] = true;
            });
            Ok(inside)
        };
        (0..images.len()).into_par_iter().map(of_image).collect()
    }

    /// The regions, in the order of the marks of each image.
    pub(super) fn regions(&self) -> &[Region] {
        &self.regions
    }

    /// The marks of an image, for each region; empty without any.
    pub(super) fn of_image(&self, index: usize) -> &[ImageMarks] {
        self.images.get(index).map_or(&[], Vec::as_slice)
    }
}

/// The index of a frame.
fn frame_at(outline: &SampleSet, number: i64, place: &str) -> Result<usize> {
    outline.frame_numbers.binary_search(&number).map_err(|_| {
        let (first, last) = (outline.frame_numbers.first(), outline.frame_numbers.last());
        let there = match first.zip(last) {
            Some((first, last)) => {
                format!("of {} from {first} to {last}", counted(outline.frame_numbers.len(), "frame"))
            }
            None => "of no frames".to_owned(),
        };
        Error::invalid(place, format!("a region names frame {number}, which is not one {there}"))
    })
}
