//! Everything at one frame that no tolerance changes: all samples on all levels with normals, footprints and packed geometry.
//! Each time a threshold changes, these are pruned again. Decisions on one level see nothing of deeper ones: the
//! verdicts are those of the span stack, which goes from level to level.

use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use super::build_lists::build_lists;
use super::candidate_lists::{CandidateLists, ToleranceRange};
use super::replay::{self, FrameLists};
use crate::capture::Capture;
use crate::capture::overlap::OverlapGraph;
use crate::error::Result;
use crate::grid::Grid;
use crate::job::Job;
use crate::preprocess::layers::CameraLayer;
use crate::preprocess::pruning::{self, Masks, Rule, SpanStack, Statuses, Verdict, no_statuses};
use crate::preprocess::temporal::{PixelClass, SpanLevel};
use crate::samples::Span;
use crate::settings::{PruningMethod, Settings};

/// All cameras at one frame, ready to be pruned.
#[derive(Debug)]
pub struct FrameLayers {
    /// The spans that contain the frame, by level.
    pub(crate) path: Vec<Span>,
    /// Every sample at the frame, per camera.
    pub layers: Arc<Vec<CameraLayer>>,
    /// The layers for display, per camera.
    pub(crate) planes: Vec<CameraPlanes>,
    lists: Mutex<CachedLists>,
}

/// The candidate lists of a frame, where they were built.
#[derive(Debug, Default)]
struct CachedLists {
    lists: Option<Arc<CandidateLists>>,
    /// Tolerances whose lists did not fit into this many bytes of memory.
    refused: Option<(ToleranceRange, usize)>,
}

/// What is shown of a layer beside its verdicts.
#[derive(Clone, Debug)]
pub(crate) struct CameraPlanes {
    /// Over how many frames each pixel is the same, in words.
    pub(crate) class: Arc<Grid<PixelClass>>,
    /// The level of each pixel's sample.
    pub(crate) level: Arc<Grid<SpanLevel>>,
    /// World-space normals; zero where the normal is not known.
    pub(crate) normal_in_world: Arc<Grid<[f32; 3]>>,
}

impl FrameLayers {
    /// The layers of `frame`, made without other frames.
    ///
    /// # Errors
    ///
    /// Whatever the capture gives (naming file and frame); `Cancelled`.
    pub fn unscanned(capture: &Capture, settings: &Settings, frame: usize, job: &Job) -> Result<Self> {
        // A background without any sample: every pixel counts as foreground.
        let sizes = capture.cameras.iter().map(|camera| camera.intrinsics.size());
        let channels = capture.value_channels();
        let empty = |(width, height)| CameraLayer::empty_for(width, height, channels);
        let background = sizes.map(empty).collect();
        Self::at(frame, SpanStack::new(capture, None, settings, background), job)
    }

    /// The layers of `frame`, on a stack that holds the span of all frames alone.
    pub(crate) fn at(frame: usize, mut stack: SpanStack<'_>, job: &Job) -> Result<Self> {
        let path = stack.tree().path(frame);
        for (level, &span) in path.iter().enumerate().skip(1) {
            stack.put_span(span, level as SpanLevel, job)?;
        }
        let planes = stack.layers.par_iter().map(|layer| planes(layer, path.len())).collect();
        Ok(Self { path, layers: Arc::new(stack.layers), planes, lists: Mutex::default() })
    }

    /// Decides every sample: from candidate lists that serve the settings, else by searching all pictures.
    ///
    /// # Errors
    ///
    /// `Cancelled`.
    pub fn prune(&self, pairs: &OverlapGraph<'_>, settings: &Settings, job: &Job) -> Result<FrameVerdicts> {
        let lists = self.lists.lock().map_or(None, |cached| cached.serving(settings));
        match lists {
            Some(lists) => self.replay(&lists, pairs, settings, job),
            None => self.search(pairs, settings, job),
        }
    }

    /// Builds the lists for tolerances around those of `settings`, unless there are some: from then on pruning again takes a
    /// fraction of the time. Gives their size in bytes; `None` where half of the memory setting does not hold them.
    pub(crate) fn prepare(
        &self,
        pairs: &OverlapGraph<'_>,
        settings: &Settings,
        job: &Job,
    ) -> Result<Option<usize>> {
        let lock = || self.lists.lock().unwrap_or_else(PoisonError::into_inner);
        if settings.pruning.method == PruningMethod::Off || lock().refused(settings) {
            return Ok(None);
        }
        let cached = lock().serving(settings);
        if let Some(lists) = cached {
            return Ok(Some(lists.bytes()));
        }
        let bound = lists_bound(settings);
        let made = build_lists(pairs, &self.layers, self.path.len(), settings, bound, job)?.map(Arc::new);
        let bytes = made.as_ref().map(|lists| lists.bytes());
        let refused = made.is_none().then(|| (ToleranceRange::around(&settings.pruning), bound));
        *lock() = CachedLists { lists: made, refused };
        Ok(bytes)
    }

    fn replay(
        &self,
        lists: &CandidateLists,
        pairs: &OverlapGraph<'_>,
        settings: &Settings,
        job: &Job,
    ) -> Result<FrameVerdicts> {
        let mut all = FrameVerdicts::none(&self.layers);
        for level in 0..self.path.len() as SpanLevel {
            let FrameVerdicts { verdicts, statuses } = &mut all;
            let frame = FrameLists { lists, pairs, layers: &self.layers };
            replay::prune(frame, statuses, level, settings, verdicts, job)?;
        }
        Ok(all)
    }

    fn search(&self, pairs: &OverlapGraph<'_>, settings: &Settings, job: &Job) -> Result<FrameVerdicts> {
        let mut all = FrameVerdicts::none(&self.layers);
        for level in 0..self.path.len() as SpanLevel {
            let decided = pruning::prune(pairs, &self.layers, &all.statuses, level, settings, job)?;
            all.verdicts.par_iter_mut().zip(&decided).for_each(|(verdicts, decided)| {
                for (&pixel, &verdict) in decided.pixels.iter().zip(&decided.verdicts) {
                    verdicts[pixel as usize] = verdict;
                }
            });
        }
        Ok(all)
    }
}

/// Bytes that the lists may take: half of the memory setting.
fn lists_bound(settings: &Settings) -> usize {
    settings.capture.memory_bytes() / 2
}

impl CachedLists {
    fn serving(&self, settings: &Settings) -> Option<Arc<CandidateLists>> {
        let serves = |lists: &&Arc<CandidateLists>| {
            settings.pruning.method != PruningMethod::Off && lists.range.serves(&settings.pruning)
        };
        self.lists.as_ref().filter(serves).cloned()
    }

    fn refused(&self, settings: &Settings) -> bool {
        let still = |(range, bound): &(ToleranceRange, usize)| {
            range.serves(&settings.pruning) && lists_bound(settings) <= *bound
        };
        self.refused.as_ref().is_some_and(still)
    }
}

/// The verdicts on every pixel of every camera at one frame.
#[derive(Debug)]
pub struct FrameVerdicts {
    /// Per camera, row by row.
    pub(crate) verdicts: Vec<Vec<Verdict>>,
    statuses: Statuses,
}

impl FrameVerdicts {
    fn none(layers: &[CameraLayer]) -> Self {
        let no_sample = Verdict::without_witness(Rule::NoSample);
        Self {
            verdicts: layers.par_iter().map(|layer| vec![no_sample; layer.level.len()]).collect(),
            statuses: no_statuses(layers.iter().map(|layer| layer.level.len())),
        }
    }

    /// Which samples of a level are kept, of a camera with that layer.
    pub fn masks(&self, camera: usize, layer: &CameraLayer, level: SpanLevel) -> Masks {
        Masks::at_level(layer, level, &self.statuses[camera])
    }
}

fn planes(layer: &CameraLayer, levels: usize) -> CameraPlanes {
    let (width, height) = (layer.width, layer.height());
    let class = layer.level.iter().map(|&level| PixelClass::of(level, levels)).collect();
    let normals = layer.normal.iter().map(glam::Vec3::to_array).collect();
    CameraPlanes {
        class: Arc::new(Grid::from_vec(width, height, class)),
        level: Arc::new(Grid::from_vec(width, height, layer.level.clone())),
        normal_in_world: Arc::new(Grid::from_vec(width, height, normals)),
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
    fn a_frame_that_is_pruned_again_from_its_candidate_lists_gets_the_verdicts_of_a_new_search() {
        let cases = [
            ("nine-cameras", 0.4, MixedPixels::Yield, true),
            ("nine-cameras", 1.0, MixedPixels::Drop, true),
            ("orrery", 3.0, MixedPixels::Yield, false),
        ];
        for (scene, factor_of_normals, mixed_pixels, overlap) in cases {
            let spec = DemoSpec::new(scene).cameras(4).frames(5).size((70, 45));
            let capture = Demo::new(&spec).unwrap().capture(&CaptureSettings::default());
            let mut settings = Settings::default();
            settings.pruning.mixed_pixels = mixed_pixels;
            settings.pruning.overlap = overlap;
            let scan = scan(&capture, &settings, &Job::new()).unwrap();
            let pairs = OverlapGraph::complete(&capture.cameras);
            let complete = scan.frame_layers(&settings, 2, &Job::new()).unwrap();
            assert!(complete.path.len() > 2);
            let original = complete.prune(&pairs, &settings, &Job::new()).unwrap();
            let bytes = complete.prepare(&pairs, &settings, &Job::new()).unwrap();
            assert!(bytes.is_some_and(|bytes| bytes < 200 * 4 * 70 * 45));
            let mut rules = std::collections::BTreeSet::new();
            let factors = [1.0, 0.7, 1.9, 0.26, 3.9, 1.000_01];
            for (index, factor) in factors.into_iter().enumerate() {
                let pruning = &mut settings.pruning;
                pruning.depth_tolerance = factor;
                pruning.color_tolerance = 48.0 * factors[(index + 1) % 6].min(2.0);
                pruning.normal_tolerance = (30.0 * factor_of_normals * factor).clamp(7.6, 90.0);
                pruning.across_spans = index % 4 != 1;
                assert!(complete.lists.lock().unwrap().serving(&settings).is_some());
                let walked = complete.prune(&pairs, &settings, &Job::new()).unwrap();
                let searched = complete.search(&pairs, &settings, &Job::new()).unwrap();
                let mut changed = 0;
                for camera in 0..4 {
                    let [a, b, first] = [&searched, &walked, &original].map(|all| &all.verdicts[camera]);
                    for (pixel, (a, b)) in a.iter().zip(b).enumerate() {
                        assert_eq!(a, b, "{scene} {factor}, camera {camera}, pixel {pixel}");
                    }
                    rules.extend(a.iter().map(|verdict| verdict.rule));
                    changed += a.iter().zip(first).filter(|(a, b)| a != b).count();
                }
                assert!(index == 0 || changed > 0, "the change of tolerances changes something");
            }
            for rule in [Rule::OnlyWitness, Rule::BestRate, Rule::Coverage, Rule::LowerRate] {
                assert!(rules.contains(&rule), "{scene}: no sample under {rule:?}");
            }
            let drops = rules.contains(&Rule::MixedDropped);
            // Where such samples yield, blended ones of the sky are dropped.
            let may_drop = mixed_pixels == MixedPixels::Drop || capture.antialiased_color;
            assert!(may_drop && drops || mixed_pixels == MixedPixels::Yield && !drops, "{scene}");
        }
    }
}
