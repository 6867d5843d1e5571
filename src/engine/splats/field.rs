//! The splats of a set, span by span.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::sync::Arc;

use glam::Vec3;
use half::f16;
use rayon::prelude::*;

use super::gaussian::{Gaussian, Look};
use super::normals::normals;
use super::options::{SplatAmount, SplatSky};
use super::sky::dome;
use super::space::Space;
use crate::capture::Camera;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::page::{Coarsening, LeveledImage};
use crate::plural::counted;
use crate::samples::{PlacedSample, SampleImage, SampleSet, Span, halved_camera};

/// World units beyond which a sample counts as one at infinity: squares of its coordinates leave single precision not much farther off.
const FARTHEST: f64 = 1e15;

/// The splats that are seen over a span of frames.
#[derive(Debug)]
pub(super) struct SpanSplats {
    pub(super) span: Span,
    /// Indices of the images.
    images: Vec<usize>,
    has_dome: bool,
    /// How many there are.
    pub(super) count: u64,
}

/// All splats of a set, made when they are asked for.
pub(super) struct Field<'a> {
    set: &'a SampleSet,
    pub(super) space: Space,
    images: Vec<LeveledImage>,
    /// By the level at which an image may be, the cameras.
    cameras: Vec<Vec<Camera>>,
    /// Longest first, then earliest; none without a splat.
    pub(super) spans: Vec<SpanSplats>,
    dome: Vec<Gaussian>,
    /// Samples that are not at infinity in the set.
    pub(super) placed: u64,
    /// Samples at infinity in the set.
    pub(super) at_infinity: u64,
}

/// How many samples of images have a place.
fn placed_count(images: &[LeveledImage]) -> u64 {
    images.par_iter().map(|image| places(&image.samples).count() as u64).sum()
}

/// Inverse depths of the samples that have a place.
fn places(image: &SampleImage) -> impl Iterator<Item = f32> {
    image.inverse_depths().into_iter().filter(|depth| f64::from(*depth) > 1.0 / FARTHEST)
}

impl<'a> Field<'a> {
    /// The splats of a set, in some axes: as few as are asked for.
    ///
    /// # Errors
    /// `Invalid` where the set holds no sample with a place, or too many at its coarsest; `Cancelled`.
    pub(super) fn new(set: &'a SampleSet, space: Space, amount: SplatAmount, job: &Job) -> Result<Self> {
        let fine: Vec<_> = set.images.iter().map(|image| LeveledImage::fine(Arc::clone(image))).collect();
        let placed = placed_count(&fine);
        if placed == 0 {
            let what =
                "is not written: the store holds no sample that has a place; name another frame or store";
            return Err(Error::invalid(&set.name, what));
        }
        let dome = if amount.sky == SplatSky::Dome { dome(set, FARTHEST, &space)? } else { Vec::new() };
        let of_dome = dome.len() as u64;
        let images = match amount.at_most {
            Some(most) if placed + of_dome > most => fitting(set, most.saturating_sub(of_dome), job)?,
            _ => fine,
        };
        let coarsest = images.iter().map(|image| image.level).max().unwrap_or(0);
        let mut cameras = vec![set.cameras.clone()];
        for level in 0..coarsest {
            let halved = cameras[level].iter().map(halved_camera).collect();
            cameras.push(halved);
        }
        let frames = set.frame_count();
        let mut field = Self {
            set,
            space,
            spans: spans(&images, of_dome, frames),
            images,
            cameras,
            dome,
            placed,
            at_infinity: set.sample_count() - placed,
        };
        field.spans.retain(|span| span.count > 0);
        Ok(field)
    }

    /// How many splats there are.
    pub(super) fn count(&self) -> u64 {
        self.spans.iter().map(|span| span.count).sum()
    }

    /// How many of them are the sky's.
    pub(super) fn dome_count(&self) -> u64 {
        self.dome.len() as u64
    }

    fn camera(&self, image: &LeveledImage) -> &Camera {
        &self.cameras[image.level][image.samples.camera as usize]
    }

    /// The splats of a span, in the order of its images, then those of the sky.
    ///
    /// # Errors
    /// `Cancelled`.
    pub(super) fn splats(&self, span: &SpanSplats, job: &Job) -> Result<Vec<Gaussian>> {
        let of_images: Result<Vec<Vec<Gaussian>>> = span
            .images
            .par_iter()
            .map(|index| {
                job.check()?;
                let splats = self.splats_of(&self.images[*index]);
                job.advance(1);
                Ok(splats)
            })
            .collect();
        let mut splats = of_images?.concat();
        if span.has_dome {
            splats.extend_from_slice(&self.dome);
        }
        Ok(splats)
    }

    /// The lowest and highest coordinates of the centers of a span's splats, as they are written.
    pub(super) fn bounds(&self, span: &SpanSplats) -> [Vec3; 2] {
        let join = |[low, high]: [Vec3; 2], point: Vec3| [low.min(point), high.max(point)];
        let none = || [Vec3::INFINITY, Vec3::NEG_INFINITY];
        let of_images = span.images.par_iter().map(|index| {
            let image = &self.images[*index];
            let camera = self.camera(image);
            let points = placed(&image.samples, camera).map(|placed| self.space.place(placed.point_in_world));
            points.fold(none(), join)
        });
        let bounds = of_images.reduce(none, |a, b| [a[0].min(b[0]), a[1].max(b[1])]);
        let dome = if span.has_dome { self.dome.as_slice() } else { &[] };
        dome.iter().fold(bounds, |bounds, splat| join(bounds, splat.center))
    }

    fn splats_of(&self, image: &LeveledImage) -> Vec<Gaussian> {
        let (samples, camera) = (&image.samples, self.camera(image));
        let holds_as_long = |other: &&LeveledImage| {
            let (span, own) = (other.samples.span, samples.span);
            other.level == image.level
                && other.samples.camera == samples.camera
                && span != own
                && span.start <= own.start
                && own.end <= span.end
        };
        let around: Vec<&SampleImage> =
            self.images.iter().filter(holds_as_long).map(|other| &*other.samples).collect();
        let normals = normals(samples, &around, camera, &self.set.settings.normals);
        let splat = |placed: PlacedSample| {
            let sample = placed.sample;
            let look = Look {
                normal_in_world: normals[sample.index],
                color: samples.color[sample.index].map(f16::to_f32),
                is_doubtful: samples.is_doubtful(sample.x, sample.y),
            };
            Gaussian::of_sample(&placed, camera, &look, &self.space)
        };
        placed(samples, camera).map(splat).collect()
    }
}

/// The samples of an image that have a place.
fn placed<'a>(image: &'a SampleImage, camera: &'a Camera) -> impl Iterator<Item = PlacedSample> + 'a {
    image.placed(camera).filter(|placed| 1.0 / placed.depth > 1.0 / FARTHEST)
}

/// Images of at most so many samples that have a place, merged where that loses least.
fn fitting(set: &SampleSet, most: u64, job: &Job) -> Result<Vec<LeveledImage>> {
    let mut count = 0;
    let best = Coarsening::new(set, job)?.finest(usize::BITS as usize, |images| {
        job.check()?;
        count = placed_count(images);
        Ok((count <= most).then(|| images.to_vec()))
    })?;
    best.ok_or_else(|| {
        // Nothing but the coarsest was tried.
        let what = format!(
            "takes {} at its coarsest besides the sky, more than the {most} that it may; allow more",
            counted(count, "splat")
        );
        Error::invalid(&set.name, what)
    })
}

/// The spans of images, longest first, then earliest. The dome is seen over all frames.
fn spans(images: &[LeveledImage], of_dome: u64, frames: usize) -> Vec<SpanSplats> {
    let mut by_span: BTreeMap<(Reverse<usize>, Span), Vec<usize>> = BTreeMap::new();
    let whole = Span { start: 0, end: frames as u32 };
    if of_dome > 0 {
        by_span.insert((Reverse(whole.len()), whole), Vec::new());
    }
    for (index, image) in images.iter().enumerate() {
        let span = image.samples.span;
        by_span.entry((Reverse(span.len()), span)).or_default().push(index);
    }
    let spans = by_span.into_iter().map(|((_, span), of_span)| {
        let has_dome = of_dome > 0 && span == whole;
        let placed: u64 = of_span.iter().map(|index| places(&images[*index].samples).count() as u64).sum();
        SpanSplats { span, images: of_span, has_dome, count: placed + if has_dome { of_dome } else { 0 } }
    });
    spans.collect()
}

/// A set of one frame: all that is seen then, as if there were no other.
pub(super) fn of_frame(set: &SampleSet, frame: usize) -> SampleSet {
    let images = set.images_at(frame).filter(|image| !image.is_empty());
    let images =
        images.map(|image| Arc::new(SampleImage { span: Span { start: 0, end: 1 }, ..(**image).clone() }));
    SampleSet {
        name: set.name.clone(),
        cameras: set.cameras.clone(),
        frame_numbers: set.frame_numbers.get(frame).copied().into_iter().collect(),
        up_in_world: set.up_in_world,
        settings: set.settings.clone(),
        images: images.collect(),
        values: Vec::new(),
    }
}
