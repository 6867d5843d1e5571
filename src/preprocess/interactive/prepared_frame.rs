//! Everything at one frame that no tolerance touches: all samples on all levels with normals, footprints and facets. Whoever
//! turns a threshold prunes these again and again; whatever is decided on one level sees nothing of the deeper ones, so that
//! the verdicts are those of the way down from level to level.

use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use super::build_lists::make_docket;
use super::candidate_lists::{CandidateLists, ToleranceRange};
use super::replay;
use crate::capture::Capture;
use crate::error::Result;
use crate::grid::Grid;
use crate::job::Job;
use crate::preprocess::inspect::PixelClass;
use crate::preprocess::layers::CameraLayer;
use crate::preprocess::pruning::{
    self, Dispute, Masks, PrunedBackground, Rule, SpanStack, Statuses, Verdict, no_statuses,
};
use crate::preprocess::registration::CameraPairs;
use crate::preprocess::temporal::{NO_SAMPLE, ROOT, SpanLevel};
use crate::samples::Span;
use crate::settings::{PruningMethod, Settings};

/// All cameras at one frame, ready to be pruned.
#[derive(Debug)]
pub struct FrameLayers {
    /// The spans that contain the frame, by level.
    pub path: Vec<Span>,
    /// Every sample at the frame, per camera.
    pub layers: Arc<Vec<CameraLayer>>,
    /// The same for the eye, per camera.
    pub planes: Vec<CameraPlanes>,
    docket: Mutex<Kept>,
}

/// The docket of a frame, for whoever turns a tolerance.
#[derive(Debug, Default)]
struct Kept {
    docket: Option<Arc<CandidateLists>>,
    /// Tolerances for which so many bytes of memory were too few.
    refused: Option<(ToleranceRange, usize)>,
}

/// What is shown of a layer beside its verdicts.
#[derive(Clone, Debug)]
pub struct CameraPlanes {
    /// Over how many frames each pixel is the same, in words.
    pub class: Arc<Grid<PixelClass>>,
    /// The level of each pixel's sample.
    pub level: Arc<Grid<SpanLevel>>,
    /// World-space normals; zero where there is none.
    pub normal_in_world: Arc<Grid<[f32; 3]>>,
    /// Footprint of each pixel; infinite where there is no sample.
    pub footprint: Arc<Grid<f32>>,
}

impl FrameLayers {
    /// The layers of `frame` where nothing is known of other frames.
    ///
    /// # Errors
    /// As [`SpanStack::enter`].
    pub fn unscanned(
        capture: &Capture,
        rig: &CameraPairs<'_>,
        settings: &Settings,
        frame: usize,
        job: &Job,
    ) -> Result<Self> {
        Self::at(frame, SpanStack::new(capture, None, rig, settings, PrunedBackground::none(capture)), job)
    }

    /// The layers of `frame`, on a way down that is at its beginning.
    ///
    /// # Errors
    /// As [`SpanStack::enter`].
    pub fn at(frame: usize, mut descent: SpanStack<'_>, job: &Job) -> Result<Self> {
        let path = descent.tree().path(frame);
        for (level, &span) in path.iter().enumerate().skip(1) {
            descent.put_span(span, level as SpanLevel, job)?;
        }
        let planes = descent.layers.par_iter().map(|layer| planes(layer, path.len())).collect();
        Ok(Self { path, layers: Arc::new(descent.layers), planes, docket: Mutex::default() })
    }

    /// Decides every sample: from the docket where one serves the settings, else by searching all pictures.
    ///
    /// # Errors
    /// `Cancelled`.
    pub fn prune(&self, rig: &CameraPairs<'_>, settings: &Settings, job: &Job) -> Result<FrameVerdicts> {
        let docket = self.docket.lock().map_or(None, |kept| kept.serving(settings));
        match docket {
            Some(docket) => self.walk(&docket, rig, settings, job),
            None => self.search(rig, settings, job),
        }
    }

    /// Makes the docket for tolerances around those of `settings`, unless there is one: from then on pruning again takes a
    /// fraction of the time. Gives its size in bytes; `None` where half of the memory setting does not hold it.
    ///
    /// # Errors
    /// `Cancelled`.
    pub fn prepare(&self, rig: &CameraPairs<'_>, settings: &Settings, job: &Job) -> Result<Option<usize>> {
        let lock = || self.docket.lock().unwrap_or_else(PoisonError::into_inner);
        if settings.pruning.method == PruningMethod::Off || lock().refused(settings) {
            return Ok(None);
        }
        let kept = lock().serving(settings);
        if let Some(docket) = kept {
            return Ok(Some(docket.bytes()));
        }
        let bound = docket_bound(settings);
        let made = make_docket(rig, &self.layers, self.path.len(), settings, bound, job)?.map(Arc::new);
        let bytes = made.as_ref().map(|docket| docket.bytes());
        let refused = made.is_none().then(|| (ToleranceRange::around(&settings.pruning), bound));
        *lock() = Kept { docket: made, refused };
        Ok(bytes)
    }

    fn walk(
        &self,
        docket: &CandidateLists,
        rig: &CameraPairs<'_>,
        settings: &Settings,
        job: &Job,
    ) -> Result<FrameVerdicts> {
        let mut all = FrameVerdicts::none(&self.layers);
        for level in 0..self.path.len() as SpanLevel {
            let FrameVerdicts { verdicts, statuses, .. } = &mut all;
            let disputes =
                replay::prune((docket, rig), &self.layers, statuses, level, settings, verdicts, job)?;
            all.add_disputes(disputes);
        }
        Ok(all)
    }

    fn search(&self, rig: &CameraPairs<'_>, settings: &Settings, job: &Job) -> Result<FrameVerdicts> {
        let mut all = FrameVerdicts::none(&self.layers);
        for level in 0..self.path.len() as SpanLevel {
            let decided = pruning::prune(rig, &self.layers, &all.statuses, level, settings, job)?;
            all.verdicts.par_iter_mut().zip(&decided).for_each(|(verdicts, decided)| {
                for (&pixel, &verdict) in decided.pixels.iter().zip(&decided.verdicts) {
                    verdicts[pixel as usize] = verdict;
                }
            });
            all.add_disputes(decided.into_iter().map(|decided| decided.disputes));
        }
        Ok(all)
    }
}

/// Bytes that a docket may take: half of the memory setting.
fn docket_bound(settings: &Settings) -> usize {
    (settings.capture.cache as usize) << 19
}

impl Kept {
    fn serving(&self, settings: &Settings) -> Option<Arc<CandidateLists>> {
        let serves = |docket: &&Arc<CandidateLists>| {
            settings.pruning.method != PruningMethod::Off && docket.reach.serves(&settings.pruning)
        };
        self.docket.as_ref().filter(serves).cloned()
    }

    fn refused(&self, settings: &Settings) -> bool {
        let still = |(reach, bound): &(ToleranceRange, usize)| {
            reach.serves(&settings.pruning) && docket_bound(settings) <= *bound
        };
        self.refused.as_ref().is_some_and(still)
    }
}

/// The verdicts on every pixel of every camera at one frame.
#[derive(Debug)]
pub struct FrameVerdicts {
    /// Per camera, row by row.
    pub verdicts: Vec<Vec<Verdict>>,
    /// Per camera, where the other rate model would have named another winner, by pixel.
    pub disputes: Vec<Vec<Dispute>>,
    statuses: Statuses,
}

impl FrameVerdicts {
    fn none(layers: &[CameraLayer]) -> Self {
        let no_sample = Verdict::without_witness(Rule::NoSample);
        Self {
            verdicts: layers.par_iter().map(|layer| vec![no_sample; layer.level.len()]).collect(),
            disputes: vec![Vec::new(); layers.len()],
            statuses: no_statuses(layers),
        }
    }

    fn add_disputes(&mut self, disputes: impl IntoIterator<Item = Vec<Dispute>>) {
        for (all, of_level) in self.disputes.iter_mut().zip(disputes) {
            all.extend(of_level);
            all.sort_unstable_by_key(|dispute| dispute.pixel);
        }
    }

    /// Which samples of a level are kept, of a camera with that layer.
    #[must_use]
    pub fn masks(&self, camera: usize, layer: &CameraLayer, level: SpanLevel) -> Masks {
        Masks::at_level(layer, level, &self.statuses[camera])
    }
}

fn planes(layer: &CameraLayer, levels: usize) -> CameraPlanes {
    let (width, height) = (layer.width, layer.height());
    let class = layer.level.iter().map(|&level| class_of(level, levels)).collect();
    let normals = layer.normal.iter().map(glam::Vec3::to_array).collect();
    CameraPlanes {
        class: Arc::new(Grid::from_vec(width, height, class)),
        level: Arc::new(Grid::from_vec(width, height, layer.level.clone())),
        normal_in_world: Arc::new(Grid::from_vec(width, height, normals)),
        footprint: Arc::new(Grid::from_vec(width, height, layer.footprint.clone())),
    }
}

fn class_of(level: SpanLevel, levels: usize) -> PixelClass {
    match level {
        NO_SAMPLE => PixelClass::Invalid,
        ROOT => PixelClass::Background,
        level if usize::from(level) + 1 == levels => PixelClass::Foreground,
        _ => PixelClass::Lasting,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::{Demo, DemoSpec};
    use crate::preprocess::pruning::Rule;
    use crate::preprocess::scan;
    use crate::settings::{CaptureSettings, MixedPixels};

    #[test]
    fn a_frame_that_is_pruned_again_from_its_docket_gets_the_verdicts_of_a_new_search() {
        let cases = [
            ("nine-cameras", 0.4, MixedPixels::Yield, true),
            ("nine-cameras", 1.0, MixedPixels::Drop, true),
            ("orrery", 3.0, MixedPixels::Yield, false),
        ];
        for (scene, turned, mixed_pixels, overlap) in cases {
            let spec = DemoSpec::new(scene).cameras(4).frames(5).size((70, 45));
            let capture = Demo::new(&spec).unwrap().capture(&CaptureSettings::default());
            let mut settings = Settings::default();
            settings.pruning.mixed_pixels = mixed_pixels;
            settings.pruning.overlap = overlap;
            let scan = scan(&capture, &settings, &Job::new()).unwrap();
            let rig = CameraPairs::new(&capture.cameras);
            let complete = scan.frame_layers(&capture, &rig, &settings, 2, &Job::new()).unwrap();
            assert!(complete.path.len() > 2);
            let original = complete.prune(&rig, &settings, &Job::new()).unwrap();
            let bytes = complete.prepare(&rig, &settings, &Job::new()).unwrap();
            assert!(bytes.is_some_and(|bytes| bytes < 200 * 4 * 70 * 45));
            let mut rules = std::collections::BTreeSet::new();
            let factors = [1.0, 0.7, 1.9, 0.26, 3.9, 1.000_01];
            for (index, factor) in factors.into_iter().enumerate() {
                let pruning = &mut settings.pruning;
                pruning.depth_tolerance = factor;
                pruning.color_tolerance = 24.0 * factors[(index + 1) % 6].min(2.0);
                pruning.normal_tolerance = (30.0 * turned * factor).clamp(7.6, 90.0);
                pruning.across_spans = index % 4 != 1;
                assert!(complete.docket.lock().unwrap().serving(&settings).is_some());
                let walked = complete.prune(&rig, &settings, &Job::new()).unwrap();
                let searched = complete.search(&rig, &settings, &Job::new()).unwrap();
                let mut changed = 0;
                for camera in 0..4 {
                    let [a, b, first] = [&searched, &walked, &original].map(|all| &all.verdicts[camera]);
                    for (pixel, (a, b)) in a.iter().zip(b).enumerate() {
                        assert_eq!(a, b, "{scene} {factor}, camera {camera}, pixel {pixel}");
                    }
                    assert!(searched.disputes == walked.disputes, "{scene} {factor}");
                    rules.extend(a.iter().map(|verdict| verdict.rule));
                    changed += a.iter().zip(first).filter(|(a, b)| a != b).count();
                }
                assert!(index == 0 || changed > 0, "the turn changes something");
            }
            for rule in [Rule::OnlyWitness, Rule::BestRate, Rule::Coverage, Rule::LowerRate] {
                assert!(rules.contains(&rule), "{scene}: no sample under {rule:?}");
            }
            assert_eq!(rules.contains(&Rule::MixedDropped), mixed_pixels == MixedPixels::Drop);
        }
    }
}
