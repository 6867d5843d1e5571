//! Samples as coarse as a picture: of a pyramid over those of a frame, the level whose resolution is nearest to the picture's.
//!
//! Purpose: the time of a picture that is coarser than the recording depends on the picture, not on the recording.
//!
//! Source: Lance Williams, *Pyramidal Parametrics*, SIGGRAPH 1983. What differs: one level serves the whole picture, so that it is a set of
//! samples like any other, which every kernel renders on the CPU and the GPU. It is chosen by what the finer parts of the picture need.

use std::sync::Arc;

use rayon::prelude::*;

use super::recorded_rates::RecordedRates;
use super::supersample::filters;
use super::vantage::Vantage;
use crate::samples::{SampleImage, SampleSet, halved_camera};
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
}
