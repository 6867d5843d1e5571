//! The splats of a set, span by span.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use half::f16;
use rayon::prelude::*;

use super::backs::{back, blocks};
use super::gaussian::{Gaussian, Look, WIDER_ALONE};
use super::normals::normals;
use super::options::{SplatAmount, SplatSky};
use super::space::{FARTHEST, Space, is_near};
use crate::capture::Camera;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::page::{Coarsening, LeveledImage};
use crate::plural::counted;
use crate::render::surroundings;
use crate::samples::{PlacedSample, SampleImage, SampleSet, Span, halved_camera};

/// The splats that are seen over a span of frames.
#[derive(Debug)]
pub(super) struct SpanSplats {
    pub(super) span: Span,
    /// Indices of the images.
    images: Vec<usize>,
    has_dome: bool,
    /// How many there are.
    pub(super) count: u64,
    /// How many of them are backs.
    backs: u64,
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
    has_backs: bool,
    /// Samples that are not at infinity in the set.
    pub(super) placed: u64,
    /// Samples at infinity in the set.
    pub(super) at_infinity: u64,
}

/// How many samples of an image have a place.
fn placed_count(image: &SampleImage) -> u64 {
    image.inverse_depths().into_iter().filter(|depth| is_near(*depth)).count() as u64
}

/// Cameras of a set by the level at which an image may be.
fn leveled(set: &SampleSet, images: &[LeveledImage]) -> Vec<Vec<Camera>> {
    let coarsest = images.iter().map(|image| image.level).max().unwrap_or(0);
    let mut cameras = vec![set.cameras.clone()];
    for level in 0..coarsest {
        let halved = cameras[level].iter().map(halved_camera).collect();
        cameras.push(halved);
    }
    cameras
}

impl<'a> Field<'a> {
    /// The splats of a set, in some axes: as few as are asked for, with or without backs behind surfaces.
    ///
    /// # Errors
    /// `Invalid` where the set holds no sample with a place, or too many at its coarsest; `Cancelled`.
    pub(super) fn new(
        set: &'a SampleSet,
        space: Space,
        amount: SplatAmount,
        has_backs: bool,
        job: &Job,
    ) -> Result<Self> {
        let fine: Vec<_> = set.images.iter().map(|image| LeveledImage::fine(Arc::clone(image))).collect();
        let placed: u64 = set.images.par_iter().map(|image| placed_count(image)).sum();
        if placed == 0 {
            let what =
                "is not written: the store holds no sample that has a place; name another frame or store";
            return Err(Error::invalid(&set.name, what));
        }
        let dome = if amount.sky == SplatSky::Dome { dome(set, FARTHEST, &space)? } else { Vec::new() };
        let of_dome = dome.len() as u64;
        let images = match amount.at_most {
            Some(most) => fitting(set, fine, most.saturating_sub(of_dome), has_backs, job)?,
            None => fine,
        };
        let cameras = leveled(set, &images);
        let counts = counts(&images, &cameras, has_backs);
        let frames = set.frame_count();
        let mut field = Self {
            set,
            space,
            spans: spans(&images, &counts, of_dome, frames),
            images,
            cameras,
            dome,
            has_backs,
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

    /// How many of them are backs.
    pub(super) fn back_count(&self) -> u64 {
        self.spans.iter().map(|span| span.backs).sum()
    }

    /// How many of them are the sky's.
    pub(super) fn dome_count(&self) -> u64 {
        self.dome.len() as u64
    }

    fn camera(&self, image: &LeveledImage) -> &Camera {
        &self.cameras[image.level][image.samples.camera as usize]
    }

    /// The splats of a span, in the order of its images, then their backs, then those of the sky.
    ///
    /// # Errors
    /// `Cancelled`.
    pub(super) fn splats(&self, span: &SpanSplats, job: &Job) -> Result<Vec<Gaussian>> {
        let of_images: Result<Vec<[Vec<Gaussian>; 2]>> = span
            .images
            .par_iter()
            .map(|index| {
                job.check()?;
                let image = &self.images[*index];
                let splats = self.splats_of(image);
                let blocks =
                    if self.has_backs { blocks(&image.samples, self.camera(image)) } else { Vec::new() };
                let backs = blocks.into_iter().map(|block| back(block.map(|nth| splats[nth as usize])));
                let backs = backs.collect();
                job.advance(1);
                Ok([splats, backs])
            })
            .collect();
        let of_images = of_images?;
        let layers = [0, 1].map(|layer| of_images.iter().flat_map(move |layers| &layers[layer]));
        let mut splats: Vec<Gaussian> = layers.into_iter().flatten().copied().collect();
        if span.has_dome {
            splats.extend_from_slice(&self.dome);
        }
        Ok(splats)
    }

    /// The lowest and highest coordinates of the centers of a span's splats, as they are written.
    ///
    /// # Errors
    /// `Cancelled`.
    pub(super) fn bounds(&self, span: &SpanSplats, job: &Job) -> Result<[Vec3; 2]> {
        let none = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        let centers = self.splats(span, job)?.into_iter().map(|splat| splat.center);
        Ok(centers.fold(none, |[low, high], center| [low.min(center), high.max(center)]))
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
            let mut splat = Gaussian::of_sample(&placed, camera, &look, &self.space);
            splat.radii *= if self.has_backs { 1.0 } else { WIDER_ALONE };
            splat
        };
        placed(samples, camera).map(splat).collect()
    }
}

/// The samples of an image that have a place.
fn placed<'a>(image: &'a SampleImage, camera: &'a Camera) -> impl Iterator<Item = PlacedSample> + 'a {
    image.placed(camera).filter(|placed| is_near((1.0 / placed.depth) as f32))
}

/// Of each image the samples that have a place, and the backs.
fn counts(images: &[LeveledImage], cameras: &[Vec<Camera>], has_backs: bool) -> Vec<[u64; 2]> {
    let of_image = |image: &LeveledImage| {
        let camera = &cameras[image.level][image.samples.camera as usize];
        let backs = if has_backs { blocks(&image.samples, camera).len() as u64 } else { 0 };
        [placed_count(&image.samples), backs]
    };
    images.par_iter().map(of_image).collect()
}

/// Images of at most so many splats without the sky's, `fine` where these are no more, else merged where that loses least.
fn fitting(
    set: &SampleSet,
    fine: Vec<LeveledImage>,
    most: u64,
    has_backs: bool,
    job: &Job,
) -> Result<Vec<LeveledImage>> {
    let count_of = |images: &[LeveledImage]| {
        counts(images, &leveled(set, images), has_backs).iter().flatten().sum::<u64>()
    };
    if count_of(&fine) <= most {
        return Ok(fine);
    }
    let mut count = 0;
    let best = Coarsening::new(set, job)?.finest(usize::BITS as usize, |images| {
        job.check()?;
        count = count_of(images);
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
fn spans(images: &[LeveledImage], counts: &[[u64; 2]], of_dome: u64, frames: usize) -> Vec<SpanSplats> {
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
        let sum = |part: usize| of_span.iter().map(|index| counts[*index][part]).sum::<u64>();
        let (placed, backs) = (sum(0), sum(1));
        let count = placed + backs + if has_dome { of_dome } else { 0 };
        SpanSplats { span, images: of_span, has_dome, count, backs }
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

/// Splats of the dome, two degrees apart: as fine as the sky is known.
const SPLATS: usize = 10_000;

/// Radius of a splat over its distance from the next: narrower ones let what is behind them show through between them.
const OVERLAP: f64 = 1.0;

/// The dome is this many times as far off as the farthest sample.
const DISTANCE: f64 = 8.0;

/// A turn by the golden angle, radians: points on a spiral by it lie evenly on the sphere.
const GOLDEN_ANGLE: f64 = 2.399_963_229_728_653;

/// The sky at the first frame, continued into all directions, around the middle of the cameras; nothing where no sample is at infinity.
/// Far from where it was seen, the farthest surfaces lend their colors: viewers fill no hole, and a hole is rarely one to the sky. Samples
/// farther off than `farthest`, in world units, count as at infinity.
///
/// # Errors
/// Those of the sky's map.
pub(super) fn dome(set: &SampleSet, farthest: f64, space: &Space) -> Result<Vec<Gaussian>> {
    let directions: Vec<DVec3> = (0..SPLATS)
        .map(|nth| {
            let z = 1.0 - (2 * nth + 1) as f64 / SPLATS as f64;
            let (sin, cos) = (nth as f64 * GOLDEN_ANGLE).sin_cos();
            let across = (1.0 - z * z).sqrt();
            DVec3::new(across * cos, across * sin, z)
        })
        .collect();
    let looked: Vec<Vec3> =
        directions.iter().map(|direction| direction.as_vec3().normalize_or_zero()).collect();
    let count = set.cameras.len().max(1) as f64;
    let middle = set.cameras.iter().map(|camera| camera.position_in_world() / count).sum::<DVec3>();
    let Some(colors) = surroundings(set, 0, farthest, &looked)? else { return Ok(Vec::new()) };
    let distance = DISTANCE * reach(set, middle, farthest);
    let radius = OVERLAP * distance * (4.0 * std::f64::consts::PI / SPLATS as f64).sqrt();
    let splats = directions.into_iter().zip(colors);
    let splats = splats.map(|(direction, color)| {
        Gaussian::facing(middle + direction * distance, -direction, radius, color, space)
    });
    Ok(splats.collect())
}

/// How far the farthest sample is from a point.
fn reach(set: &SampleSet, middle: DVec3, farthest: f64) -> f64 {
    let points = set.images.iter().flat_map(|image| image.placed(&set.cameras[image.camera as usize]));
    let near = points.filter(|placed| placed.depth < farthest);
    near.map(|placed| placed.point_in_world.distance(middle)).fold(0.0, f64::max)
}

/// Flat Gaussians in world space, one entry of each list a splat.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SplatArrays {
    /// World units.
    pub center_in_world: Vec<[f64; 3]>,
    /// Unit quaternions `w x y z`, `w` not negative, from the axes of the Gaussian to those of the world; its third axis is the normal
    /// of the surface, on the side that was seen.
    pub rotation: Vec<[f32; 4]>,
    /// Standard deviations along its three axes, world units, above 0; the first is the longest, the third is along the normal.
    pub scale: Vec<[f32; 3]>,
    /// Linear Rec.709, 0 to 1.
    pub color: Vec<[f32; 3]>,
    /// 0 to 1.
    pub opacity: Vec<f32>,
}

/// The splats of a frame, by its index, in the order of the samples, then those of the sky; none where no sample has a place.
///
/// # Errors
/// `Invalid` where so few splats cannot be had; `Cancelled`.
pub fn arrays(set: &SampleSet, frame: usize, amount: SplatAmount, job: &Job) -> Result<SplatArrays> {
    let set = of_frame(set, frame);
    let mut arrays = SplatArrays::default();
    let has_place = set.images.iter().any(|image| image.placed_count() > 0);
    if !has_place {
        return Ok(arrays);
    }
    let field = Field::new(&set, Space::of_world(&set), amount, false, job)?;
    for span in &field.spans {
        for splat in field.splats(span, job)? {
            let center = splat.center.as_dvec3() + field.space.origin_in_world;
            let turned = splat.rotation;
            arrays.center_in_world.push(center.to_array());
            arrays.rotation.push([turned.w, turned.x, turned.y, turned.z]);
            arrays.scale.push(splat.radii.to_array());
            arrays.color.push(splat.color);
            arrays.opacity.push(splat.opacity);
        }
    }
    Ok(arrays)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::{Demo, DemoSpec};
    use crate::preprocess::preprocess;
    use crate::settings::Settings;
    use crate::splats::SplatSky;

    #[test]
    fn splats_lie_at_the_samples_of_the_frame_and_fewer_are_had_where_fewer_are_asked_for() {
        let demo = Demo::new(&DemoSpec::new("orrery").size((96, 72)).cameras(2).frames(4)).unwrap();
        let settings = Settings::default();
        let set = preprocess(&demo.capture(&settings.capture), &settings, &Job::new()).unwrap().samples;
        let amount = SplatAmount { at_most: None, sky: SplatSky::Out };
        let found = arrays(&set, 2, amount, &Job::new()).unwrap();
        let images = set.images_at(2).filter(|image| !image.is_empty());
        let expected: Vec<_> =
            images.flat_map(|image| image.placed(&set.cameras[image.camera as usize])).collect();
        assert_eq!(found.center_in_world.len(), expected.len());
        for (center, placed) in found.center_in_world.iter().zip(&expected) {
            assert!((DVec3::from(*center) - placed.point_in_world).length() < 1e-5);
        }
        let lengths = found.rotation.iter().map(|q| q.iter().map(|part| part * part).sum::<f32>());
        assert!(lengths.into_iter().all(|length| (length - 1.0).abs() < 1e-5));
        assert!(found.scale.iter().all(|[longer, shorter, flat]| longer >= shorter && shorter > flat));
        let half = expected.len() as u64 / 2;
        let few = arrays(&set, 2, SplatAmount { at_most: Some(half), ..amount }, &Job::new()).unwrap();
        assert!(few.opacity.len() as u64 <= half && few.opacity.len() > expected.len() / 8);
    }
}
