//! Everything at one frame that no tolerance touches: all samples on all levels with normals, footprints and facets. Whoever
//! turns a threshold prunes these again and again; whatever is decided on one level sees nothing of the deeper ones, so that
//! the verdicts are those of the way down from level to level.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

use super::background::{Background, remember, remembered};
use super::descent::Descent;
use super::docket::{Docket, Reach};
use super::layer::{Layer, Level, NO_SAMPLE, ROOT};
use super::pruning::{self, Decided, Rig};
use super::{PixelClass, Span, TemporalScan};
use crate::capture::Capture;
use crate::error::Result;
use crate::grid::Grid;
use crate::job::Job;
use crate::settings::{MixedPixels, NormalSettings, PruningMethod, RateModel, Settings, SpanSettings};

/// What the layers of a frame depend on.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FrameKey {
    frame: usize,
    normals: NormalSettings,
    spans: SpanSettings,
    rate: RateModel,
    cosine_floor: f32,
    first_camera: bool,
    mixed_pixels: MixedPixels,
}

/// All cameras at one frame, ready to be pruned.
#[derive(Debug)]
pub struct FrameLayers {
    /// The spans that contain the frame, by level.
    pub path: Vec<Span>,
    /// Every sample at the frame, per camera.
    pub layers: Arc<Vec<Layer>>,
    /// The same for the eye, per camera.
    pub planes: Vec<CameraPlanes>,
    docket: Mutex<Kept>,
}

/// Whether a frame was pruned before, and the docket that comes of pruning it again.
#[derive(Debug, Default)]
struct Kept {
    was_pruned: bool,
    /// Tolerances for which there was too little memory.
    refused: Option<Reach>,
    docket: Option<Arc<Docket>>,
}

/// What is shown of a layer beside its verdicts.
#[derive(Clone, Debug)]
pub struct CameraPlanes {
    /// Over how many frames each pixel is the same, in words.
    pub class: Arc<Grid<PixelClass>>,
    /// The level of each pixel's sample.
    pub level: Arc<Grid<Level>>,
    /// World-space normals; zero where there is none.
    pub normal_in_world: Arc<Grid<[f32; 3]>>,
    /// Footprint of each pixel; infinite where there is no sample.
    pub footprint: Arc<Grid<f32>>,
}

impl FrameLayers {
    /// The layers of `frame`; with a `scan`, made once for as long as the settings that touch them and the frame stay.
    ///
    /// # Errors
    /// As [`Descent::enter`].
    pub fn of(
        capture: &Capture,
        scan: Option<&TemporalScan>,
        rig: &Rig<'_>,
        settings: &Settings,
        frame: usize,
        job: &Job,
    ) -> Result<Arc<Self>> {
        let key = FrameKey {
            frame,
            normals: settings.normals.clone(),
            spans: settings.spans.clone(),
            rate: settings.pruning.rate,
            cosine_floor: settings.pruning.cosine_floor,
            first_camera: settings.pruning.method == PruningMethod::FirstCamera,
            mixed_pixels: settings.pruning.mixed_pixels,
        };
        if let Some(layers) = scan.and_then(|scan| remembered(&scan.memo.frame, &key)) {
            return Ok(layers);
        }
        let background = match scan {
            Some(scan) => Background::undecided(scan.rated_layers(capture, settings, job)?),
            None => Background::none(capture),
        };
        let mut descent = Descent::new(capture, scan, rig, settings, background);
        let path = descent.tree().path(frame);
        for (level, &span) in path.iter().enumerate().skip(1) {
            descent.put_span(span, level as Level, job)?;
        }
        let planes = descent.layers.par_iter().map(|layer| planes(layer, path.len())).collect();
        let layers = Self { path, layers: Arc::new(descent.layers), planes, docket: Mutex::default() };
        let layers = Arc::new(layers);
        if let Some(scan) = scan {
            remember(&scan.memo.frame, key, layers.clone());
        }
        Ok(layers)
    }

    /// Decides every sample. Gives the verdicts per level, per camera. Who does so again with other tolerances pays once for a
    /// docket, and little from then on.
    ///
    /// # Errors
    /// `Cancelled`.
    pub fn prune(&self, rig: &Rig<'_>, settings: &Settings, job: &Job) -> Result<Vec<Vec<Decided>>> {
        let docket = self.docket(rig, settings, job)?;
        let statuses = pruning::no_statuses(&self.layers);
        let decided = (0..self.path.len()).map(|level| {
            let (docket, level) = (docket.as_deref(), level as Level);
            pruning::prune_from(docket, rig, &self.layers, &statuses, level, settings, job)
        });
        let decided = decided.collect::<Result<_>>()?;
        self.kept().was_pruned = true;
        Ok(decided)
    }

    /// The docket for `settings`: none the first time that anybody asks, as most frames are looked at once.
    fn docket(&self, rig: &Rig<'_>, settings: &Settings, job: &Job) -> Result<Option<Arc<Docket>>> {
        let pruning = &settings.pruning;
        let serves = |reach: &Reach| reach.serves(pruning);
        {
            let kept = self.kept();
            if let Some(docket) = kept.docket.as_ref().filter(|docket| serves(&docket.reach)) {
                return Ok(Some(docket.clone()));
            }
            let refused = kept.refused.as_ref().is_some_and(serves);
            if !kept.was_pruned || refused || pruning.method == PruningMethod::Off {
                return Ok(None);
            }
        }
        let bytes = (settings.capture.cache as usize) << 19;
        let made = Docket::new(rig, &self.layers, self.path.len(), settings, bytes, job)?.map(Arc::new);
        let mut kept = self.kept();
        kept.refused = made.is_none().then(|| Reach::around(pruning));
        kept.docket.clone_from(&made);
        Ok(made)
    }

    fn kept(&self) -> MutexGuard<'_, Kept> {
        // What it holds is replaced as a whole, so that it is whole even after a panic elsewhere.
        self.docket.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn planes(layer: &Layer, levels: usize) -> CameraPlanes {
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

fn class_of(level: Level, levels: usize) -> PixelClass {
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
    use crate::capture::demo::{Demo, DemoSpec};
    use crate::preprocess::{Rule, scan};
    use crate::settings::CaptureSettings;

    /// With the docket and without.
    fn both_ways(complete: &FrameLayers, rig: &Rig<'_>, settings: &Settings) -> [Vec<Vec<Decided>>; 2] {
        let job = Job::new();
        let statuses = pruning::no_statuses(&complete.layers);
        let searched = (0..complete.path.len())
            .map(|level| pruning::prune(rig, &complete.layers, &statuses, level as Level, settings, &job))
            .collect::<Result<_>>()
            .unwrap();
        [searched, complete.prune(rig, settings, &job).unwrap()]
    }

    #[test]
    fn a_frame_that_is_pruned_again_from_its_docket_gets_the_verdicts_of_a_new_search() {
        for (scene, turned) in [("nine-cameras", 0.4), ("orrery", 3.0)] {
            let spec = DemoSpec {
                scene: scene.to_owned(),
                cameras: Some(4),
                frames: Some(5),
                size: Some((70, 45)),
                noise: None,
            };
            let capture = Demo::new(&spec).unwrap().capture(&CaptureSettings::default());
            let mut settings = Settings::default();
            let scan = scan(&capture, &settings, &Job::new()).unwrap();
            let rig = Rig::new(&capture.cameras);
            let complete = FrameLayers::of(&capture, Some(&scan), &rig, &settings, 2, &Job::new()).unwrap();
            assert!(complete.path.len() > 2);
            let original = complete.prune(&rig, &settings, &Job::new()).unwrap();
            assert!(complete.kept().docket.is_none(), "one look is no reason for a docket");
            let mut rules = std::collections::BTreeSet::new();
            let factors = [1.0, 0.7, 1.9, 0.26, 3.9, 1.000_01];
            for (index, factor) in factors.into_iter().enumerate() {
                let pruning = &mut settings.pruning;
                pruning.depth_tolerance = factor;
                pruning.color_tolerance = 24.0 * factors[(index + 1) % 6].min(2.0);
                pruning.normal_tolerance = (30.0 * turned * factor).clamp(7.6, 90.0);
                pruning.across_spans = index % 4 != 1;
                let [searched, walked] = both_ways(&complete, &rig, &settings);
                assert!(complete.kept().docket.is_some());
                let mut changed = 0;
                let all = searched.iter().flatten().zip(walked.iter().flatten());
                for ((a, b), first) in all.zip(original.iter().flatten()) {
                    assert!(a.pixels == b.pixels && a.mixed == b.mixed);
                    for ((pixel, a), b) in a.pixels.iter().zip(&a.verdicts).zip(&b.verdicts) {
                        assert_eq!(a, b, "{scene} {factor}, pixel {pixel}");
                    }
                    assert!(a.disputes == b.disputes, "{scene} {factor}");
                    rules.extend(a.verdicts.iter().map(|verdict| verdict.rule));
                    changed += a.verdicts.iter().zip(&first.verdicts).filter(|(a, b)| a != b).count();
                }
                assert!(index == 0 || changed > 0, "the turn changes something");
            }
            for rule in [Rule::OnlyWitness, Rule::BestRate, Rule::Coverage, Rule::LowerRate] {
                assert!(rules.contains(&rule), "{scene}: no sample under {rule:?}");
            }
        }
    }
}
