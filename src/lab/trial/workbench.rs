//! One setting: preprocessed, stored, rendered and scored against the truth of every fold.
//!
//! ```text
//! Trial ─ scan ─▶ prune ─▶ thin ─▶ store (bytes) ─▶ read ─▶ paint every view ─▶ TrialResult
//!        └─ kept between trials that agree so far ─┘
//! ```
//!
//! Rendered samples are read back from the file, so that its precision shows in the pictures. Holes are filled for every trial: a
//! method must neither profit from leaving out difficult pixels nor lose to gaps of one pixel.

use std::collections::BTreeSet;
use std::collections::hash_map::{Entry, HashMap};
use std::sync::Arc;

use super::baselines;
use super::machine_load::MachineLoad;
use super::paired::MeanEstimate;
use super::rival_trial;
use super::trial_result::{TrialResult, scores_by_vantage};
use super::trial_setting::{ModelKey, Thinning, Trial};
use crate::metrics::{ClassErrors, ClassMap};
use crate::rivals::Rival;
use crate::scoring::{Evaluation, Scoreboard, render_view};
use crate::truth::{Fold, Recorded, Truth, views_as_taken};
use overlook_engine::capture::TruthView;
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::median::median;
use overlook_engine::preprocess::diagnostics::Report;
use overlook_engine::preprocess::{self, PreparedScan};
use overlook_engine::render::Renderer;
use overlook_engine::samples::SampleSet;
use overlook_engine::settings::{
    AlignSettings, Backend, Fill, NormalSettings, PruningMethod, RenderSettings, Settings, SpanSettings,
};

/// Samples of one fold under one trial.
pub(crate) struct FoldSamples {
    pub(crate) samples: Arc<SampleSet>,
    report: Report,
    pub(crate) bytes: u64,
    bytes_record: u64,
    seconds: f64,
}

impl FoldSamples {
    /// Samples that were not written to a file yet.
    fn unstored(samples: Arc<SampleSet>, report: Report, seconds: f64) -> Self {
        Self { samples, report, bytes: 0, bytes_record: 0, seconds }
    }

    /// The views, corrected as the cameras were.
    fn seen(&self, views: &[TruthView]) -> Vec<TruthView> {
        views_as_taken(self.report.alignment.as_ref(), views)
    }
}

/// A view, and the samples that a trial shows it with.
pub(super) struct ViewModel {
    pub(super) view: TruthView,
    /// Its classes of error.
    pub(super) classes: Option<Arc<ClassMap>>,
    pub(super) samples: Arc<SampleSet>,
}

struct FoldState {
    fold: Fold,
    scans: Vec<(ScanKey, Arc<PreparedScan>, f64)>,
    models: Vec<(ModelKey, Arc<FoldSamples>)>,
}

/// What a scan depends on.
type ScanKey = (AlignSettings, NormalSettings, SpanSettings, Option<Vec<String>>);

/// Scans and models cached per fold: those of the last trials, and the unpruned one that baselines thin.
const KEPT: usize = 3;

/// Measures settings on one capture. Settings that agree share scans and models.
pub struct Workbench {
    folds: Vec<FoldState>,
    reference: Settings,
    /// One renderer per backend.
    renderers: HashMap<Backend, Renderer>,
}

impl Workbench {
    /// Loads the truth. The baselines keep as many samples as `reference` does.
    ///
    /// # Errors
    /// As [`Truth::folds`].
    pub fn new(recorded: &Recorded, truth: &Truth, reference: &Settings, job: &Job) -> Result<Self> {
        Ok(Self::on(truth.folds(recorded, job)?, reference))
    }

    /// As [`Workbench::new`], with the truth loaded.
    pub(crate) fn on(folds: Vec<Fold>, reference: &Settings) -> Self {
        let state = |fold| FoldState { fold, scans: Vec::new(), models: Vec::new() };
        Self {
            folds: folds.into_iter().map(state).collect(),
            reference: reference.clone(),
            renderers: HashMap::new(),
        }
    }

    /// Opens the renderers of the trials, so that a missing one is reported before anything is measured.
    ///
    /// # Errors
    /// `Gpu` if a trial needs a GPU and the machine has none.
    pub fn open<'a>(&mut self, trials: impl IntoIterator<Item = &'a Trial>) -> Result<()> {
        trials
            .into_iter()
            .try_for_each(|trial| opened(&mut self.renderers, trial.settings.render.backend).map(|_| ()))
    }

    /// Whether some fold that has views has a camera left for the trial.
    pub(crate) fn can_measure(&self, trial: &Trial) -> bool {
        self.folds.iter().any(|fold| fold.has_cameras(trial))
    }

    /// Measures one setting.
    ///
    /// # Errors
    /// Those of preprocessing, the store and rendering; `Invalid` if no fold has a camera left; `Gpu` if the GPU cannot render:
    /// times of the CPU must not pass for its own.
    pub fn measure(&mut self, trial: &Trial, job: &Job) -> Result<TrialResult> {
        let load = MachineLoad::start();
        let measured = match trial.rival {
            Some(rival) => self.measure_rival(rival, trial, job)?,
            None => self.measure_samples(trial, job)?,
        };
        Ok(TrialResult { load_of_others: load.of_others(), ..measured })
    }

    fn measure_samples(&mut self, trial: &Trial, job: &Job) -> Result<TrialResult> {
        let renderer = opened(&mut self.renderers, trial.settings.render.backend)?;
        let (mut models, mut evaluations, mut vantages) = (Vec::new(), Vec::new(), Vec::new());
        let mut class_errors = ClassErrors::default();
        for fold in &mut self.folds {
            if !fold.has_cameras(trial) {
                continue;
            }
            let model = fold.model(trial, &self.reference, job)?;
            let evaluation = score_views(renderer, trial, &fold.fold, &model, &mut class_errors, job)?;
            vantages.extend(scores_by_vantage(&fold.fold.views, &evaluation));
            evaluations.push(evaluation);
            models.push(model);
        }
        if models.is_empty() {
            return Err(Error::invalid(&trial.label, "no camera is left to make a model of"));
        }
        let mean = |value: &dyn Fn(&FoldSamples) -> f64| {
            models.iter().map(|model| value(model)).sum::<f64>() / models.len() as f64
        };
        let views = || evaluations.iter().flat_map(|evaluation| &evaluation.views);
        let mut times: Vec<f64> = views().map(|view| view.milliseconds).collect();
        let flicker: Vec<f64> =
            evaluations.iter().filter_map(|evaluation| evaluation.mean.flicker_steps).collect();
        Ok(TrialResult {
            vantages,
            class_errors,
            flicker_steps: (!flicker.is_empty()).then(|| MeanEstimate::of(&flicker).mean),
            samples: mean(&|model| model.samples.sample_count() as f64).round() as u64,
            bytes: mean(&|model| model.bytes as f64).round() as u64,
            bytes_record: mean(&|model| model.bytes_record as f64).round() as u64,
            bytes_memory: mean(&|model| model.samples.bytes() as f64).round() as u64,
            samples_shared: mean(&|model| shared(&model.samples) as f64).round() as u64,
            spans: mean(&|model| span_count(&model.samples) as f64).round() as u64,
            milliseconds: median(&mut times).unwrap_or_default(),
            load_of_others: None,
            samples_painted: MeanEstimate::of(&views().map(|view| view.samples as f64).collect::<Vec<_>>())
                .mean,
            seconds_preprocess: mean(&|model| model.seconds),
        })
    }
}

impl Workbench {
    /// The view of a name, its classes of error, and the samples that a trial shows it from.
    pub(super) fn view_and_samples(
        &mut self,
        trial: &Trial,
        file_path: &str,
        job: &Job,
    ) -> Result<Option<ViewModel>> {
        for fold in &mut self.folds {
            let Some(index) = fold.fold.views.iter().position(|view| view.file_path == file_path) else {
                continue;
            };
            let classes = fold.fold.classes[index].clone();
            let model = fold.model(trial, &self.reference, job)?;
            let view = model.seen(&fold.fold.views[index..=index]).remove(0);
            let samples = model.samples.clone();
            return Ok(Some(ViewModel { view, classes, samples }));
        }
        Ok(None)
    }

    /// The renderer for a backend.
    pub(super) fn renderer(&mut self, backend: Backend) -> Result<&mut Renderer> {
        opened(&mut self.renderers, backend)
    }

    /// Measures a method of others on the same corrected capture as ours. A method that keeps all recorded pictures counts as large as our
    /// store of them.
    fn measure_rival(&mut self, rival: Rival, trial: &Trial, job: &Job) -> Result<TrialResult> {
        let mut parts = Vec::new();
        for fold in &mut self.folds {
            let aligned = fold.aligned(trial, job)?;
            let pictures = rival_trial::measure(rival, &aligned, &trial.settings.render, job)?;
            let (bytes, bytes_record) = if let Some(bytes) = pictures.bytes {
                (bytes, 0)
            } else {
                let mut all = Trial::new("all samples", trial.settings.clone());
                all.settings.pruning.method = PruningMethod::Off;
                let all = fold.model(&all, &self.reference, job)?;
                (all.bytes, all.bytes_record)
            };
            parts.push(TrialResult { bytes, bytes_record, ..pictures.result });
        }
        Ok(rival_trial::over_folds(parts))
    }
}

/// Renders and scores all views of a fold, and adds to the errors by class.
fn score_views(
    renderer: &mut Renderer,
    trial: &Trial,
    fold: &Fold,
    model: &FoldSamples,
    class_errors: &mut ClassErrors,
    job: &Job,
) -> Result<Evaluation> {
    let filling = RenderSettings { fill: Fill::PushPull, ..trial.settings.render.clone() };
    job.start("Scoring views", fold.views.len());
    let mut scores = Scoreboard::default();
    for (view, classes) in model.seen(&fold.views).iter().zip(&fold.classes) {
        job.check()?;
        let classes = classes.as_deref();
        let mut painted = render_view(renderer, &model.samples, view, classes, &filling, job)?;
        if let (Backend::Gpu, Some(why)) = (filling.backend, &painted.notice) {
            return Err(Error::Gpu { what: format!("'{}' asks for the GPU, but {why}", trial.label) });
        }
        if trial.settings.render.fill == Fill::None {
            painted.score.milliseconds -= painted.fill_ms;
        }
        class_errors.add(&painted.class_errors.unwrap_or_default());
        scores.add(view, painted);
        job.advance(1);
    }
    Ok(scores.finish())
}

/// The renderer for a backend, opened at its first use.
fn opened(renderers: &mut HashMap<Backend, Renderer>, backend: Backend) -> Result<&mut Renderer> {
    Ok(match renderers.entry(backend) {
        Entry::Occupied(known) => known.into_mut(),
        Entry::Vacant(new) => new.insert(Renderer::strict(backend)?),
    })
}

/// Samples that live longer than one frame.
fn shared(samples: &SampleSet) -> u64 {
    samples.images.iter().filter(|image| image.span.len() > 1).map(|image| image.len() as u64).sum()
}

/// Different spans that hold a sample.
fn span_count(samples: &SampleSet) -> usize {
    samples.images.iter().map(|image| image.span).collect::<BTreeSet<_>>().len()
}

impl FoldState {
    fn keeps(trial: &Trial, camera: &str) -> bool {
        trial.cameras.as_ref().is_none_or(|names| names.iter().any(|name| name == camera))
    }

    fn has_cameras(&self, trial: &Trial) -> bool {
        self.fold.capture.cameras.iter().any(|camera| Self::keeps(trial, &camera.name))
    }

    fn scan(&mut self, trial: &Trial, job: &Job) -> Result<(Arc<PreparedScan>, f64)> {
        let Settings { align, normals, spans, .. } = &trial.settings;
        let key = (align.clone(), normals.clone(), spans.clone(), trial.cameras.clone());
        if let Some((_, scan, seconds)) = self.scans.iter().find(|(known, ..)| *known == key) {
            return Ok((scan.clone(), *seconds));
        }
        let started = std::time::Instant::now();
        let capture = self.fold.capture.with_cameras(|_, camera| Self::keeps(trial, &camera.name));
        let scan = preprocess::scan(&capture, &trial.settings, job)?;
        let seconds = started.elapsed().as_secs_f64();
        self.scans.truncate(KEPT - 1);
        self.scans.insert(0, (key, scan.clone(), seconds));
        Ok((scan, seconds))
    }

    /// The fold with its capture and views corrected.
    fn aligned(&mut self, trial: &Trial, job: &Job) -> Result<Fold> {
        let (scan, _) = self.scan(trial, job)?;
        let views = views_as_taken(scan.alignment(), &self.fold.views);
        Ok(Fold { capture: scan.capture().clone(), views, ..self.fold.clone() })
    }

    fn model(&mut self, trial: &Trial, reference: &Settings, job: &Job) -> Result<Arc<FoldSamples>> {
        let key = trial.model_key();
        // A store notes its settings: those of painting must not change its size.
        let trial = &Trial { settings: key.0.clone(), ..trial.clone() };
        if let Some(index) = self.models.iter().position(|(known, _)| *known == key) {
            let known = self.models.remove(index);
            self.models.insert(0, known);
            return Ok(self.models[0].1.clone());
        }
        let model = match trial.thinning {
            Thinning::None => self.pruned(trial, job)?,
            thinning => {
                let count = self.model(&Trial::new("reference", reference.clone()), reference, job)?;
                self.thinned(trial, thinning, count.samples.sample_count(), job)?
            }
        };
        let seconds = model.seconds;
        let model = Arc::new(FoldSamples { seconds, ..stored(&model.samples, &model.report, job)? });
        self.models.truncate(KEPT - 1);
        self.models.insert(0, (key, model.clone()));
        Ok(model)
    }

    /// Pruned by the settings; not stored yet.
    fn pruned(&mut self, trial: &Trial, job: &Job) -> Result<FoldSamples> {
        let (scan, seconds_scan) = self.scan(trial, job)?;
        let capture = self.fold.capture.with_cameras(|_, camera| Self::keeps(trial, &camera.name));
        let pruned = preprocess::prune(&capture, &scan, &trial.settings, job)?;
        let seconds = seconds_scan + pruned.report.seconds;
        Ok(FoldSamples::unstored(pruned.samples, pruned.report, seconds))
    }

    fn thinned(&mut self, trial: &Trial, thinning: Thinning, count: u64, job: &Job) -> Result<FoldSamples> {
        let mut trial = trial.clone();
        trial.thinning = Thinning::None;
        if thinning == Thinning::Tolerance {
            return self.pruned_to(trial, count, job);
        }
        trial.settings.pruning.method = PruningMethod::Off;
        let all = self.model(&trial, &trial.settings, job)?;
        let started = std::time::Instant::now();
        let samples = Arc::new(match thinning {
            Thinning::VoxelGrid => baselines::voxel_grid(&all.samples, count),
            _ => baselines::random(&all.samples, count),
        });
        let seconds = all.seconds + started.elapsed().as_secs_f64();
        Ok(FoldSamples::unstored(samples, all.report.clone(), seconds))
    }

    /// Lowers all tolerances together until at least `count` samples stay, and takes as many of them.
    fn pruned_to(&mut self, mut trial: Trial, count: u64, job: &Job) -> Result<FoldSamples> {
        const BISECTIONS: usize = 7;
        let mut best = self.pruned(&trial, job)?;
        if best.samples.sample_count() < count {
            let tolerances = trial.settings.pruning.clone();
            let mut tightened = |share: f64| {
                let between = |from: f32, to: f32| from * (to / from).powf(share as f32);
                let pruning = &mut trial.settings.pruning;
                pruning.depth_tolerance = between(tolerances.depth_tolerance, 0.05);
                pruning.color_tolerance = between(tolerances.color_tolerance, 1.0);
                pruning.normal_tolerance = between(tolerances.normal_tolerance, 1.0);
                self.pruned(&trial, job)
            };
            let (mut low, mut high) = (0.0, 1.0);
            best = tightened(high)?;
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (low + high);
                let pruned = tightened(middle)?;
                if pruned.samples.sample_count() < count {
                    low = middle;
                } else {
                    (high, best) = (middle, pruned);
                }
            }
        }
        let samples = Arc::new(baselines::random(&best.samples, count));
        Ok(FoldSamples { samples, ..best })
    }
}

/// Samples and report as they come back from a file, and the bytes it has.
pub(crate) fn stored(samples: &SampleSet, report: &Report, job: &Job) -> Result<FoldSamples> {
    let folder = tempfile::tempdir().map_err(|error| Error::io(std::env::temp_dir(), error))?;
    let path = folder.path().join("trial.ovl");
    let bytes = overlook_engine::store::file::write(&path, samples, &report.to_json()?, job)?;
    let store = overlook_engine::store::file::Store::open(&path)?;
    let samples = store.read_undamaged(job)?;
    let report = Report { seconds: 0.0, ..report.clone() };
    let bytes_record = store.info().record_bytes;
    Ok(FoldSamples { bytes, bytes_record, ..FoldSamples::unstored(Arc::new(samples), report, 0.0) })
}
