//! Compares ways to prune on one capture.

use serde::Serialize;

use super::workbench::{FoldSamples, stored};
use crate::scoring::{Evaluation, OnPicture, add_aligned, evaluate_each, frame_of, with_truth};
use crate::truth;
use overlook_engine::capture::{Capture, TruthView};
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::preprocess;
use overlook_engine::render::Renderer;
use overlook_engine::settings::{PruningMethod, Settings};

/// One way to prune: what it costs and how close to the truth it stays.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MethodScore {
    /// Name of the pruning method.
    pub method: PruningMethod,
    /// Samples kept.
    pub samples_kept: u64,
    /// Bytes of the kept samples in memory.
    pub bytes_memory: u64,
    /// Bytes of the store.
    pub bytes_store: u64,
    /// How close to the truth.
    #[serde(flatten)]
    pub evaluation: Evaluation,
}

/// The given settings and the two extremes to compare them with.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MethodComparison {
    /// As the settings say.
    pub as_set: MethodScore,
    /// Every sample kept: the most accurate, and the largest.
    pub no_pruning: MethodScore,
    /// The first camera that saw a point keeps it, whatever its sampling rate: what a layered depth image does.
    pub first_camera: MethodScore,
}

/// Scores the given settings, no pruning, and first camera wins. The frames are scanned once. Samples are read back from a file,
/// so that its precision shows in the scores. With `align_views`, views are also scored once they are aligned by their own true
/// pictures.
///
/// # Errors
/// Those of preprocessing, the store and [`evaluate`](crate); a view at a frame that the capture lacks is
/// refused first.
pub fn compare(
    capture: &Capture,
    views: &[TruthView],
    settings: &Settings,
    align_views: bool,
    job: &Job,
) -> Result<MethodComparison> {
    compare_each(capture, views, settings, align_views, job, &mut |_, _, _| Ok(()))
}

/// As [`compare`]; `on_picture` takes each picture of the given settings.
///
/// # Errors
///
/// Those of [`compare`], and of `on_picture`.
pub fn compare_each(
    capture: &Capture,
    views: &[TruthView],
    settings: &Settings,
    align_views: bool,
    job: &Job,
    on_picture: &mut OnPicture<'_>,
) -> Result<MethodComparison> {
    let mut renderer = Renderer::strict(settings.render.backend)?;
    for view in with_truth(views, job) {
        frame_of(view, &capture.name, &capture.frame_numbers)?;
    }
    let scan = preprocess::scan(capture, settings, job)?;
    let views = truth::views_as_taken(scan.alignment(), views);
    let views = views.as_slice();
    let classes = truth::class_maps(scan.capture(), views, job)?;
    let mut compared = |method, on_picture: &mut OnPicture<'_>| {
        let mut settings = settings.clone();
        settings.pruning.method = method;
        let pruned = preprocess::prune(capture, &scan, &settings, job)?;
        let FoldSamples { samples, bytes: bytes_store, .. } = stored(&pruned.samples, &pruned.report, job)?;
        let mut evaluation =
            evaluate_each(&mut renderer, &samples, views, &classes, &settings.render, job, on_picture)?;
        if align_views {
            let views = with_truth(views, job);
            add_aligned(
                &mut evaluation,
                &mut renderer,
                &views,
                &settings.render,
                |_, _| Ok(samples.clone()),
                job,
            )?;
        }
        let (samples_kept, bytes_memory) = (samples.sample_count(), samples.bytes());
        Ok(MethodScore { method, samples_kept, bytes_memory, bytes_store, evaluation })
    };
    let unseen: &mut OnPicture<'_> = &mut |_, _, _| Ok(());
    Ok(MethodComparison {
        as_set: compared(settings.pruning.method, on_picture)?,
        no_pruning: compared(PruningMethod::Off, unseen)?,
        first_camera: compared(PruningMethod::FirstCamera, unseen)?,
    })
}
