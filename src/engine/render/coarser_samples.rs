//! Samples as coarse as a picture: of a pyramid over those of a frame, the level whose resolution is nearest to the picture's.
//!
//! Purpose: the time of a picture that is coarser than the recording depends on the picture, not on the recording.
//!
//! Source: Lance Williams, *Pyramidal Parametrics*, SIGGRAPH 1983. What differs: one level serves the whole picture, so that it is a set of
//! samples like any other, which every kernel renders on the CPU and the GPU. It is chosen by what the finer parts of the picture need.
//!
//! How finely the cameras recorded what a picture shows.
//!
//! Rates are recorded pixels along a pixel of the picture: above 1 the picture is the coarser one, below 1 it magnifies.

use std::sync::Arc;

use rayon::prelude::*;

use super::geometry::Projector;
use super::supersample::filters;
use super::vantage::Vantage;
use crate::samples::{DepthTile, SampleImage, SampleSet, SampleTile, TILE, halved_camera};
use crate::settings::{Coarse, RenderSettings};

/// A coarser level begins where a pixel of the picture is at least this many recorded pixels wide.
const LEAST_RATE: f32 = 1.75;

/// A pixel of the picture is at least this many samples of the chosen level wide, and less than twice that.
const REMAINING_RATE: f32 = 0.75;

/// The level is chosen by the rate that this share of a picture reaches: it serves the finer recorded parts as well.
const SHARE: f64 = 0.75;

/// Coarsest level: 64 recorded pixels along one of its samples.
const COARSEST: usize = 6;

/// The level for a picture whose pixels are this many recorded pixels wide; 0 are the samples themselves.
fn level_of(rate: f32) -> usize {
    if rate < LEAST_RATE { 0 } else { ((rate / REMAINING_RATE).log2() as usize).clamp(1, COARSEST) }
}

/// The levels that were used last, kept while the samples of the frame stay the same.
#[derive(Debug, Default)]
pub(super) struct CoarserSamples {
    /// From the first coarser one on.
    levels: Vec<HalvedSet>,
}

/// Samples, and what they become at half the resolution.
#[derive(Debug)]
struct HalvedSet {
    finer: Arc<SampleSet>,
    frame: usize,
    coarser: Arc<SampleSet>,
}

impl CoarserSamples {
    /// The samples from which the settings ask for a picture to be rendered, if these are coarser ones.
    pub(super) fn for_picture(
        &mut self,
        samples: &Arc<SampleSet>,
        rates: &RecordedRates,
        vantage: &Vantage,
        settings: &RenderSettings,
    ) -> Option<Arc<SampleSet>> {
        let is_asked_for = settings.coarse == Coarse::Pyramid && filters(settings);
        let level = if is_asked_for { level_of(rates.of_share(SHARE)) } else { 0 };
        (level > 0).then(|| self.at(samples, vantage.frame, level))
    }

    /// The samples of a frame at a level, which is not 0. Images of other frames are in their places without samples.
    fn at(&mut self, samples: &Arc<SampleSet>, frame: usize, level: usize) -> Arc<SampleSet> {
        let mut finer = samples.clone();
        for nth in 0..level {
            let known = self.levels.get(nth);
            if !known.is_some_and(|known| known.is_of(&finer, frame)) {
                let made = HalvedSet::new(&finer, frame, known);
                match self.levels.get_mut(nth) {
                    Some(level) => *level = made,
                    None => self.levels.push(made),
                }
            }
            finer = self.levels[nth].coarser.clone();
        }
        finer
    }
}

impl HalvedSet {
    /// A level of the samples of a frame; images that another level has are taken from there.
    fn new(finer: &Arc<SampleSet>, frame: usize, before: Option<&Self>) -> Self {
        let halved = |(nth, image): (usize, &Arc<SampleImage>)| {
            if !image.span.contains(frame) {
                return Arc::new(image.without_samples());
            }
            let known = before.and_then(|before| before.image_of(image, nth));
            known.unwrap_or_else(|| Arc::new(image.halved(&finer.cameras[image.camera as usize].intrinsics)))
        };
        let coarser = SampleSet {
            cameras: finer.cameras.iter().map(halved_camera).collect(),
            images: finer.images.par_iter().enumerate().map(halved).collect(),
            ..(**finer).clone()
        };
        Self { finer: finer.clone(), frame, coarser: Arc::new(coarser) }
    }

    fn is_of(&self, finer: &Arc<SampleSet>, frame: usize) -> bool {
        Arc::ptr_eq(&self.finer, finer) && self.frame == frame
    }

    /// What the `nth` image became, if it is this one and was not left out.
    fn image_of(&self, image: &Arc<SampleImage>, nth: usize) -> Option<Arc<SampleImage>> {
        let is_same = self.finer.images.get(nth).is_some_and(|known| Arc::ptr_eq(known, image));
        (is_same && image.span.contains(self.frame)).then(|| self.coarser.images[nth].clone())
    }
}

/// Rates over a picture.
#[derive(Clone, Debug, Default)]
pub(super) struct RecordedRates {
    /// Rates, largest first, and the pixels of the picture that each holds for: of all that it shows, and of what is not at infinity.
    descending: [Vec<(f32, f32)>; 2],
}

/// A tile of samples in the picture.
struct SeenTile {
    rate: f32,
    /// Pixels of the picture that its samples cover.
    area: f32,
    is_finite: bool,
}

impl RecordedRates {
    /// At a vantage.
    pub(super) fn of(samples: &SampleSet, vantage: &Vantage) -> Self {
        let images = || samples.images_at(vantage.frame);
        // Longer spans count if there are any, so that the resolution does not change from frame to frame.
        let has_longer = images().any(|image| image.span.len() > 1 && !image.is_empty());
        let chosen: Vec<_> = images().filter(|image| !has_longer || image.span.len() > 1).collect();
        let seen: Vec<SeenTile> =
            chosen.par_iter().flat_map_iter(|image| seen_tiles(image, samples, vantage)).collect();
        let sorted = |tiles: &mut dyn Iterator<Item = &SeenTile>| {
            let mut rates: Vec<(f32, f32)> = tiles.map(|tile| (tile.rate, tile.area)).collect();
            rates.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
            rates
        };
        let surfaces = sorted(&mut seen.iter().filter(|tile| tile.is_finite));
        Self { descending: [sorted(&mut seen.iter()), surfaces] }
    }

    /// The rate that a share of the picture, 0 to 1, reaches or exceeds, or of the surfaces in it, if that is more: things before a
    /// wide sky are not lost. 0 if it shows nothing.
    pub(super) fn of_share(&self, share: f64) -> f32 {
        self.descending.iter().map(|rates| rate_of_share(rates, share)).fold(0.0, f32::max)
    }
}

/// The rate that a share of the pixels reaches or exceeds; 0 if there are none.
fn rate_of_share(descending: &[(f32, f32)], share: f64) -> f32 {
    let all: f64 = descending.iter().map(|(_, area)| f64::from(*area)).sum();
    let mut covered = 0.0;
    let found = descending.iter().find(|(_, area)| {
        covered += f64::from(*area);
        covered >= share * all
    });
    found.map_or(0.0, |(rate, _)| *rate)
}

/// The tiles whose centers are visible.
fn seen_tiles<'a>(
    image: &'a SampleImage,
    samples: &SampleSet,
    vantage: &Vantage,
) -> impl Iterator<Item = SeenTile> + 'a {
    let target = &vantage.camera;
    let projector = samples.cameras.get(image.camera as usize).map(|camera| Projector::new(camera, target));
    let (width, height) = target.intrinsics.size();
    let seen = move |(tile, depth): (&SampleTile, &DepthTile)| {
        let projector = projector?;
        let middle = |tile: u16| f32::from(tile) * TILE as f32 + 0.5 * TILE as f32;
        let inverse_depth = 0.5 * (f32::from_bits(depth.farthest) + f32::from_bits(depth.nearest));
        let point = projector.point_of_any(middle(tile.tile_x), middle(tile.tile_y), inverse_depth);
        let [u, v] = projector.position(point, inverse_depth);
        let is_seen = point.z > 0.0 && (0.0..width as f32).contains(&u) && (0.0..height as f32).contains(&v);
        let rate = if projector.source_is_orthographic {
            projector.magnification(inverse_depth, point.z.recip()).recip()
        } else {
            point.z / projector.focal_ratio
        };
        let area = tile.count() as f32 / (rate * rate);
        is_seen.then_some(SeenTile { rate, area, is_finite: depth.nearest != 0 })
    };
    image.tiles.iter().zip(image.depth.tiles()).filter_map(seen)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::DemoSpec;
    use crate::render::tests::scene;

    #[test]
    fn a_level_has_about_as_many_samples_along_a_pixel_as_the_picture_shows() {
        assert_eq!([0.0, 0.5, 1.0, 1.7].map(level_of), [0; 4]);
        for rate in [1.75, 2.0, 2.9, 3.1, 5.0, 8.0, 17.0, 40.0] {
            let remaining = rate / (1 << level_of(rate)) as f32;
            assert!((REMAINING_RATE..2.0 * REMAINING_RATE).contains(&remaining), "{rate}: {remaining}");
        }
        assert_eq!(level_of(1e9), COARSEST);
    }

    #[test]
    fn each_level_has_a_quarter_of_the_samples_and_what_stays_is_the_same_image_at_the_next_frame() {
        let (samples, _) = scene(DemoSpec::new("orrery").size((96, 64)), 0);
        let mut levels = CoarserSamples::default();
        let count =
            |set: &SampleSet, frame: usize| set.images_at(frame).map(|image| image.len()).sum::<usize>();
        let mut before = count(&samples, 0);
        for level in 1..=3 {
            let set = levels.at(&samples, 0, level);
            let share = count(&set, 0) as f64 / before as f64;
            assert!((0.24..0.5).contains(&share), "level {level}: {share}");
            before = count(&set, 0);
            assert!(Arc::ptr_eq(&set, &levels.at(&samples, 0, level)), "kept while it is asked for again");
        }
        let (first, second) = (levels.at(&samples, 0, 2), levels.at(&samples, 1, 2));
        let shared = |(nth, image): (usize, &Arc<SampleImage>)| {
            image.span.len() > 1 && Arc::ptr_eq(image, &second.images[nth])
        };
        let backgrounds = first.images.iter().filter(|image| image.span.len() > 1).count();
        assert!(backgrounds > 0);
        assert_eq!(first.images.iter().enumerate().filter(|image| shared(*image)).count(), backgrounds);
        assert!(second.images.iter().all(|image| image.span.contains(1) != image.is_empty()));
    }

    #[test]
    fn a_picture_of_half_the_size_has_twice_the_rate_everywhere() {
        let (samples, vantage) = scene(DemoSpec::new("orrery").cameras(3).size((96, 64)), 0);
        let mut halved = vantage.clone();
        let lens = &mut halved.camera.intrinsics;
        (lens.width, lens.height) = (lens.width / 2, lens.height / 2);
        for length in [&mut lens.fx, &mut lens.fy, &mut lens.cx, &mut lens.cy] {
            *length *= 0.5;
        }
        let (once, twice) = (RecordedRates::of(&samples, &halved), RecordedRates::of(&samples, &vantage));
        for share in [0.1, 0.5, 0.9] {
            let ratio = once.of_share(share) / twice.of_share(share);
            assert!((ratio - 2.0).abs() < 1e-3, "{share}: {ratio}");
        }
        assert!(once.of_share(0.1) >= once.of_share(0.9));
        assert_eq!(RecordedRates::default().of_share(0.5), 0.0);
    }
}
