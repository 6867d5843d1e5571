//! What a region may ask of a sample, or of a pixel before pruning.

use glam::{DAffine3, DVec2, DVec3};
use half::f16;

use crate::capture::{Camera, Intrinsics};
use crate::error::{Error, Result};
use crate::samples::{Sample, SampleImage, VoteCounts};

/// Which samples of an image are in a region that depends on other samples; `None` where none is.
pub(super) type ImageMarks = Option<Box<[bool]>>;

/// A sample, or a pixel with depth, with all that a region may ask.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen<'a> {
    /// Center of its pixel in its own picture, pixels.
    pub(super) pixel: DVec2,
    /// Toward it from its camera, world space, not of unit length.
    pub(super) direction_in_world: DVec3,
    /// Planar depth in its own camera, world units; infinite for the sky.
    pub(super) depth: f64,
    /// In world space; not finite for the sky.
    pub(super) point_in_world: DVec3,
    /// As stores mark it.
    pub(super) is_doubtful: bool,
    /// Unit normal in world space; 0 where there is none.
    pub(super) normal_in_world: DVec3,
    /// What other cameras say.
    pub(super) votes: VoteCounts,
    /// Linear Rec.709.
    pub(super) color: [f16; 3],
    /// Scalar values, one a channel; none where there are none.
    pub(super) values: &'a [f32],
    /// The marks of its image, for each region that depends on other samples.
    pub(super) marks: &'a [ImageMarks],
    /// Index into the planes of its image.
    pub(super) index: usize,
}

impl Seen<'_> {
    /// Whether it is in the region at this place among those that depend on other samples.
    pub(super) fn is_marked(&self, region: usize) -> bool {
        self.marks.get(region).and_then(Option::as_ref).is_some_and(|marks| marks[self.index])
    }
}

/// A camera with what turns its pixels into places.
#[derive(Clone, Copy, Debug)]
pub(super) struct PixelRays {
    lens: Intrinsics,
    world_from_camera: DAffine3,
}

impl PixelRays {
    pub(super) fn of(camera: &Camera) -> Self {
        Self { lens: camera.intrinsics, world_from_camera: camera.world_from_camera }
    }

    /// What is seen at a pixel with an inverse depth from 0, without evidence.
    pub(super) fn seen(&self, x: usize, y: usize, inverse_depth: f32) -> Seen<'static> {
        let pixel = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
        let direction_in_world = self.world_from_camera.transform_vector3(self.lens.ray_in_camera(pixel));
        let depth = 1.0 / f64::from(inverse_depth);
        Seen {
            pixel,
            direction_in_world,
            depth,
            point_in_world: if self.lens.is_orthographic() {
                self.world_from_camera.transform_point3(self.lens.point_in_camera(pixel, depth))
            } else {
                self.world_from_camera.translation + direction_in_world * depth
            },
            is_doubtful: false,
            normal_in_world: DVec3::ZERO,
            votes: VoteCounts::default(),
            color: [f16::ZERO; 3],
            values: &[],
            marks: &[],
            index: 0,
        }
    }
}

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
