//! What was measured of one setting, and which points nothing beats.

use serde::{Deserialize, Serialize};

use crate::metrics::{ErrorByClass, Scores};
use crate::rivals::Rival;
use crate::trial::{MeanEstimate, PairedDifference, Trial, TrialResult, ViewAccuracy, kernel_cost};
use overlook_engine::settings::Settings;

/// What a point is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Series {
    /// The settings the sweep started from.
    Reference,
    /// Settings that differ from these.
    Variation,
    /// No pruning.
    NoPruning,
    /// The first camera that saw a point keeps it: a layered depth image.
    FirstCamera,
    /// The same with its tolerance lowered until as many samples stay as under the reference.
    FirstCameraAtCount,
    /// As many samples as under the reference, chosen at random.
    Random,
    /// As many samples as under the reference, from a grid of cubes.
    VoxelGrid,
    /// The best camera alone.
    SingleCamera,
    /// The paper's settings.
    Paper,
    /// See [`Rival::TriangleMesh`].
    TriangleMesh,
    /// See [`Rival::Tsdf`].
    Tsdf,
    /// See [`Rival::NearestCamera`].
    NearestCamera,
    /// See [`Rival::LayeredDepthImage`].
    LayeredDepthImage,
    /// Figures of another program, which were given.
    External,
}

impl Series {
    /// Every series, the reference first.
    pub const ALL: [Self; 14] = [
        Self::Reference,
        Self::Variation,
        Self::NoPruning,
        Self::FirstCamera,
        Self::FirstCameraAtCount,
        Self::Random,
        Self::VoxelGrid,
        Self::SingleCamera,
        Self::Paper,
        Self::TriangleMesh,
        Self::Tsdf,
        Self::NearestCamera,
        Self::LayeredDepthImage,
        Self::External,
    ];

    /// Name for legends.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Reference => "default settings",
            Self::Variation => "other settings",
            Self::NoPruning => "no pruning",
            Self::FirstCamera => "first camera wins",
            Self::FirstCameraAtCount => "first camera wins, as many samples",
            Self::Random => "random, as many samples",
            Self::VoxelGrid => "voxel grid, as many samples",
            Self::SingleCamera => "one camera alone",
            Self::Paper => "the paper's settings",
            Self::TriangleMesh => Rival::TriangleMesh.name(),
            Self::Tsdf => Rival::Tsdf(1).name(),
            Self::NearestCamera => Rival::NearestCamera.name(),
            Self::LayeredDepthImage => Rival::LayeredDepthImage.name(),
            Self::External => "another program",
        }
    }

    /// The series of a rival.
    #[must_use]
    pub fn of(rival: Rival) -> Self {
        match rival {
            Rival::TriangleMesh => Self::TriangleMesh,
            Rival::Tsdf(_) => Self::Tsdf,
            Rival::NearestCamera => Self::NearestCamera,
            Rival::LayeredDepthImage => Self::LayeredDepthImage,
        }
    }

    /// Whether its pictures are not made by our renderer, so that its settings mean nothing.
    #[must_use]
    pub fn is_rival(self) -> bool {
        matches!(
            self,
            Self::TriangleMesh | Self::Tsdf | Self::NearestCamera | Self::LayeredDepthImage | Self::External
        )
    }

    /// Whether this is what others do.
    #[must_use]
    pub fn is_baseline(self) -> bool {
        !matches!(self, Self::Reference | Self::Variation)
    }
}

/// The share of a machine that other programs may use before times on it are marked: more of them than this shows in a median.
const QUIET_LOAD: f64 = 0.1;

/// One setting and everything measured of it. Accuracy is over pixels that some camera saw, with holes filled; see [`Scores`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// A short name of what is special about it.
    pub label: String,
    /// What it is: our default, a variation, or a baseline.
    pub series: Series,
    /// Everything that was set.
    pub settings: Settings,
    /// See [`Scores::psnr_db`].
    pub psnr_db: f64,
    /// Its standard error over vantages, see [`MeanEstimate::over_vantages`].
    pub psnr_db_se: f64,
    /// PSNR over all of these pixels, with holes always filled by `pushpull`: neither leaving holes nor being good at easy pixels
    /// improves it. Points are ranked by it.
    pub psnr_filled_db: f64,
    /// Its standard error over vantages, which is mostly their own difference. Compare points by `behind_best_db_se` instead.
    pub psnr_filled_db_se: f64,
    /// Loss against the most accurate point, dB: the mean of the differences at the vantages that both were scored at.
    /// See [`mark_behind_best`]; 0 until then.
    pub behind_best_db: f64,
    /// Its standard error.
    pub behind_best_db_se: f64,
    /// See [`Scores::ssim`].
    pub ssim: f64,
    /// Its standard error.
    pub ssim_se: f64,
    /// See [`Scores::ms_ssim`].
    pub ms_ssim: f64,
    /// See [`Scores::flip`].
    pub flip: f64,
    /// Its standard error.
    pub flip_se: f64,
    /// See [`Scores::silhouette_steps`].
    pub silhouette_steps: Option<f64>,
    /// Root mean square change of error from frame to frame at a still vantage, 8-bit steps.
    pub flicker_steps: Option<f64>,
    /// Error by class, over all pixels of all views that show a surface; `None` if no truth has depth.
    pub error_by_class: Option<ErrorByClass>,
    /// See [`Scores::coverage`].
    pub coverage: f64,
    /// Samples kept.
    pub samples: u64,
    /// Bytes of the store.
    pub bytes: u64,
    /// Bytes of the store's record of its settings, see [`Point::bytes_of_samples`].
    pub bytes_record: u64,
    /// Bytes of the samples in memory.
    pub bytes_memory: u64,
    /// Samples that live longer than one frame.
    pub samples_shared: u64,
    /// Different spans that hold a sample.
    pub spans: u64,
    /// Milliseconds of rendering one view with these settings, median; as noisy as the machine.
    pub milliseconds: f64,
    /// The share of the machine's time that other programs used meanwhile, 0 to 1; `None` where the system does not say it.
    #[serde(default)]
    pub load_of_others: Option<f64>,
    /// Work of painting one view that is the same on every machine: samples times the kernel's cost.
    pub work: f64,
    /// Seconds of preprocessing.
    pub seconds_preprocess: f64,
    /// Vantages it was scored at; a single camera is not scored at its own.
    pub vantages: usize,
    /// Whether no other point is both more accurate (`psnr_filled_db`) and smaller, see [`mark_pareto`]; in a stress test, among
    /// the methods at the same value of the dial.
    pub pareto: bool,
    /// Accuracy view by view.
    pub views: Vec<ViewAccuracy>,
}

impl Point {
    /// Whether its times are of a machine that other programs used as well.
    #[must_use]
    pub fn is_timed_under_load(&self) -> bool {
        self.load_of_others.is_some_and(|load| load > QUIET_LOAD)
    }

    /// Milliseconds of rendering one view, for tables; after a tilde where they were timed under load.
    #[must_use]
    pub fn milliseconds_text(&self) -> String {
        format!("{}{:.1}", if self.is_timed_under_load() { "~" } else { "" }, self.milliseconds)
    }

    /// Whether it is what a trial gave.
    pub(crate) fn is_of(&self, trial: &Trial) -> bool {
        self.label == trial.label && self.settings == trial.settings
    }

    /// Bytes of the store without the record of its settings: longer names of settings must not make it larger.
    #[must_use]
    pub fn bytes_of_samples(&self) -> u64 {
        self.bytes - self.bytes_record
    }

    /// See [`Point::bytes_of_samples`].
    pub(crate) fn megabytes_of_samples(&self) -> f64 {
        self.bytes_of_samples() as f64 / 1e6
    }

    /// What a trial gave.
    #[must_use]
    pub fn new(trial: &Trial, series: Series, measured: &TrialResult) -> Self {
        let of = |value: &dyn Fn(&Scores) -> f64| {
            let of_vantage =
                |frames: &Vec<(String, Scores)>| frames.iter().map(|(_, scores)| value(scores)).collect();
            MeanEstimate::over_vantages(&measured.vantages.iter().map(of_vantage).collect::<Vec<_>>())
        };
        let (psnr, psnr_filled) = (of(&|scores| scores.psnr_db), of(&|scores| scores.psnr_all_db));
        let (ssim, flip) = (of(&|scores| scores.ssim), of(&|scores| scores.flip));
        let edges_of = |frames: &Vec<(String, Scores)>| {
            frames.iter().filter_map(|(_, scores)| scores.silhouette_steps).collect()
        };
        let edges: Vec<Vec<f64>> = measured.vantages.iter().map(edges_of).collect();
        Self {
            label: trial.label.clone(),
            series,
            settings: trial.settings.clone(),
            psnr_db: psnr.mean,
            psnr_db_se: psnr.standard_error,
            psnr_filled_db: psnr_filled.mean,
            psnr_filled_db_se: psnr_filled.standard_error,
            behind_best_db: 0.0,
            behind_best_db_se: 0.0,
            ssim: ssim.mean,
            ssim_se: ssim.standard_error,
            ms_ssim: of(&|scores| scores.ms_ssim).mean,
            flip: flip.mean,
            flip_se: flip.standard_error,
            silhouette_steps: edges
                .iter()
                .any(|frames| !frames.is_empty())
                .then(|| MeanEstimate::over_vantages(&edges).mean),
            flicker_steps: measured.flicker_steps,
            error_by_class: measured.class_errors.scores(),
            coverage: of(&|scores| scores.coverage).mean,
            samples: measured.samples,
            bytes: measured.bytes,
            bytes_record: measured.bytes_record,
            bytes_memory: measured.bytes_memory,
            samples_shared: measured.samples_shared,
            spans: measured.spans,
            milliseconds: measured.milliseconds,
            load_of_others: measured.load_of_others,
            work: measured.samples_painted * kernel_cost(trial.settings.render.kernel),
            seconds_preprocess: measured.seconds_preprocess,
            vantages: measured.vantages.len(),
            pareto: false,
            views: measured.accuracy_by_view(),
        }
    }
}

/// Sets `behind_best_db` and `behind_best_db_se` of points that were scored at views of one truth. The best point is the most accurate of
/// those with the most vantages; its loss is 0. Figures of other programs are not known view by view, so that their loss is the difference
/// of the means, without a standard error.
pub fn mark_behind_best<'a>(points: impl IntoIterator<Item = &'a mut Point>) {
    let mut points: Vec<&mut Point> = points.into_iter().collect();
    let accuracy = |a: &&mut Point, b: &&mut Point| {
        a.vantages.cmp(&b.vantages).then(a.psnr_filled_db.total_cmp(&b.psnr_filled_db))
    };
    let measured = points.iter().filter(|point| point.series != Series::External);
    let best = measured.max_by(|a, b| accuracy(a, b)).map(|best| (best.views.clone(), best.psnr_filled_db));
    let Some((best, best_db)) = best else { return };
    for point in &mut points {
        let unpaired = MeanEstimate { mean: best_db - point.psnr_filled_db, standard_error: 0.0 };
        let loss = PairedDifference::between(&best, &point.views).map_or(unpaired, |loss| loss.db);
        (point.behind_best_db, point.behind_best_db_se) = (loss.mean, loss.standard_error);
    }
}

/// Marks the points that no other beats in one respect without losing in the other: lower `cost`, higher `gain`. Equal points are
/// all marked. Points scored at fewer vantages than others are not comparable and not marked.
pub fn mark_pareto<'a>(
    points: impl IntoIterator<Item = &'a mut Point>,
    cost: impl Fn(&Point) -> f64,
    gain: impl Fn(&Point) -> f64,
) {
    let mut points: Vec<&mut Point> = points.into_iter().collect();
    let most = points.iter().map(|point| point.vantages).max();
    for point in &mut points {
        point.pareto = false;
    }
    points.retain(|point| Some(point.vantages) == most);
    let values: Vec<_> = points.iter().map(|point| (cost(point), gain(point))).collect();
    for (point, (cost, gain)) in points.into_iter().zip(&values) {
        point.pareto = !values.iter().any(|(other_cost, other_gain)| {
            (other_cost < cost && other_gain >= gain) || (other_cost <= cost && other_gain > gain)
        });
    }
}

/// [`mark_pareto`] by [`Point::bytes_of_samples`] and `psnr_filled_db`.
pub fn mark_pareto_of_stores<'a>(points: impl IntoIterator<Item = &'a mut Point>) {
    mark_pareto(points, |point| point.bytes_of_samples() as f64, |point| point.psnr_filled_db);
}
