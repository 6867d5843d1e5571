//! What of a region's questions only the image of a sample answers.

use super::seen::{ImageMarks, Seen};
use crate::capture::Camera;
use crate::error::{Error, Result};
use crate::samples::{Sample, SampleImage, VoteCounts};

/// An image with what is known of its samples.
pub(super) struct Evidence<'a> {
    image: &'a SampleImage,
    votes: &'a [VoteCounts],
    marks: &'a [ImageMarks],
}

impl<'a> Evidence<'a> {
    /// # Errors
    /// `Invalid` where normals are asked for and the image has none.
    pub(super) fn new(
        image: &'a SampleImage,
        votes: &'a [VoteCounts],
        marks: &'a [ImageMarks],
        asks_for_normals: bool,
        camera: &Camera,
    ) -> Result<Self> {
        if image.normal.is_none() && asks_for_normals {
            return Err(Error::invalid(
                format!("camera '{}'", camera.name),
                "an edit asks for the angle of view, and its samples have no normals; preprocess with --set store.normals=true",
            ));
        }
        Ok(Self { image, votes, marks })
    }

    /// The image's marks, for each region that depends on other samples.
    pub(super) fn marks(&self) -> &'a [ImageMarks] {
        self.marks
    }

    pub(super) fn add_to(&self, seen: &mut Seen<'a>, sample: &Sample) {
        seen.votes = self.votes.get(sample.index).copied().unwrap_or_default();
        seen.is_doubtful = !self.image.doubtful.is_empty() && self.image.is_doubtful(sample.x, sample.y);
        (seen.marks, seen.index) = (self.marks, sample.index);
        seen.color = self.image.color[sample.index];
        seen.values = self.image.values.of(sample.index);
        if let Some(normals) = &self.image.normal {
            seen.normal_in_world = normals[sample.index].decode().as_dvec3();
        }
    }
}
