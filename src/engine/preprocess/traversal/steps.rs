//! The steps of pruning one span: find, settle, pack, each for one group of cameras after the other.

use std::sync::Arc;

use rayon::prelude::*;

use super::groups::{CameraBytes, CameraGroup, Recording, chunks_within, groups_within};
use super::verdict_store::VerdictStore;
use super::window::LayerWindow;
use crate::capture::overlap::OverlapGraph;
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::agreement::{Consensus, SmoothDepths};
use crate::preprocess::diagnostics::{LatticeRuns, Residuals, Tally};
use crate::preprocess::layers::RatedSamples;
use crate::preprocess::pruning::{
    self, LevelVerdicts, Masks, PruningPass, Search, Statuses, all_may_be_witnesses,
};
use crate::preprocess::temporal::{ROOT, SpanLevel};
use crate::samples::{ImageBuffer, Span, VerdictBuffer, samples_in_memory};
use crate::settings::Settings;

/// Bytes of a sample while it is worked on: itself, its verdict, and what is known between the parts of a search.
pub(super) const SAMPLE_BYTES: usize = 38 + 12 + 16;

/// What is kept of a run of frames, and what became of the rest.
#[derive(Debug)]
pub(crate) struct KeptSamples {
    pub(crate) images: ImageBuffer,
    /// `None` where nobody asks.
    pub(crate) verdicts: Option<VerdictBuffer>,
}

impl KeptSamples {
    /// Nothing is kept yet; samples stay in memory, and nobody asks for verdicts.
    pub(crate) fn in_memory() -> Self {
        Self { images: ImageBuffer::new(usize::MAX), verdicts: None }
    }

    /// Nothing is kept yet of what a store is to hold. Images and verdicts each take a share of the memory setting at most.
    pub(crate) fn for_store(settings: &Settings) -> Self {
        let bound = samples_in_memory(settings);
        let verdicts = (settings.store.verdicts > 0.0).then(|| VerdictBuffer::new(bound));
        Self { images: ImageBuffer::new(bound), verdicts }
    }

    /// Puts images and verdicts into their order.
    pub(crate) fn sort(&mut self) {
        self.images.sort();
        if let Some(verdicts) = &mut self.verdicts {
            verdicts.sort();
        }
    }
}

/// What the steps of pruning share.
pub(super) struct Pruner<'a> {
    pub(super) recording: Recording<'a>,
    pub(super) pairs: &'a OverlapGraph<'a>,
    pub(super) window: LayerWindow<'a>,
    pub(super) statuses: Statuses,
    pub(super) job: &'a Job,
}

/// A span that is decided: where it is, and what was looked at when its samples were put.
pub(super) struct PutSpan {
    pub(super) span: Span,
    pub(super) level: SpanLevel,
    /// Per camera: samples that the span has.
    pub(super) counts: Vec<usize>,
    /// Per camera: the samples whose residuals are read, if any are.
    pub(super) lattice: Option<Vec<LatticeRuns>>,
}

/// One span while its samples are decided.
pub(super) struct SpanStep<'s, 'a> {
    pub(super) of: &'s mut Pruner<'a>,
    pub(super) put: &'s PutSpan,
    pub(super) groups: Vec<CameraGroup>,
    may_be_witnesses: Vec<bool>,
    pub(super) verdicts: VerdictStore,
}

impl Pruner<'_> {
    /// Groups of cameras, each of which takes some memory for what is worked on.
    pub(super) fn groups(&self, samples: &[usize]) -> Vec<CameraGroup> {
        let all: Vec<usize> = (0..self.window.layers.len()).collect();
        if self.window.holds_all {
            return vec![CameraGroup { cameras: all.clone(), parts: vec![all] }];
        }
        let layers = self.layer_bytes();
        groups_within(self.pairs, &CameraBytes { layers: &layers, samples, bound: self.recording.bound })
    }

    /// Bytes of each camera's layer.
    pub(super) fn layer_bytes(&self) -> Vec<usize> {
        (0..self.window.layers.len()).map(|camera| self.window.bytes(camera)).collect()
    }

    /// Decides the samples of the span that was entered last, counts them where a `tally` is given, and packs what is kept.
    pub(super) fn prune(
        &mut self,
        put: &PutSpan,
        residuals: &mut Residuals<'_>,
        mut kept: Option<(&mut Tally, &mut KeptSamples)>,
    ) -> Result<()> {
        let settings = self.recording.settings;
        let samples: Vec<usize> = put.counts.iter().map(|count| count * SAMPLE_BYTES).collect();
        let bound = if self.window.holds_all { usize::MAX } else { samples_in_memory(settings) };
        let mut step = SpanStep {
            groups: self.groups(&samples),
            may_be_witnesses: all_may_be_witnesses(
                &self.statuses,
                put.level,
                put.counts.iter().sum(),
                settings,
            ),
            put,
            verdicts: VerdictStore::new(bound),
            of: self,
        };
        step.find_all(residuals, kept.as_mut().map(|(tally, _)| &mut **tally))?;
        if put.counts.iter().any(|count| *count > 0) {
            step.settle_all()?;
            if let Some((tally, kept)) = kept {
                step.pack_all(tally, kept)?;
            }
        }
        Ok(())
    }
}

impl SpanStep<'_, '_> {
    pub(super) fn pass(&self) -> PruningPass<'_> {
        let Pruner { recording, pairs, window, statuses, .. } = &*self.of;
        let level = self.put.level;
        PruningPass::new(pairs, &window.layers, statuses, level, &self.may_be_witnesses, recording.settings)
    }

    /// Pieces of some cameras whose samples, and `more` of each, take no more than a share of memory together.
    fn pieces(&self, cameras: &[usize], more: impl Fn(usize) -> usize) -> Vec<Vec<usize>> {
        if self.of.window.holds_all {
            return vec![cameras.to_vec()];
        }
        let counts = self.put.counts.iter().enumerate();
        let bytes: Vec<usize> = counts.map(|(camera, count)| count * SAMPLE_BYTES + more(camera)).collect();
        chunks_within(cameras, &bytes, self.of.recording.bound / 2)
    }

    pub(super) fn samples(&self, cameras: &[usize]) -> Result<Vec<Arc<RatedSamples>>> {
        cameras.par_iter().map(|camera| self.of.window.samples(*camera)).collect()
    }

    /// Finds the best candidate of every sample, and reads residuals.
    fn find_all(&mut self, residuals: &mut Residuals<'_>, mut tally: Option<&mut Tally>) -> Result<()> {
        let is_empty = self.put.counts.iter().all(|count| *count == 0);
        if is_empty && self.put.lattice.is_none() {
            return Ok(());
        }
        for group in self.groups.clone() {
            let in_parts = group.parts.len() > 1;
            let pieces =
                if in_parts { vec![group.cameras.clone()] } else { self.pieces(&group.cameras, |_| 0) };
            for cameras in pieces {
                let count: usize = cameras.iter().map(|camera| self.put.counts[*camera]).sum();
                self.of.window.reserve(count * SAMPLE_BYTES);
                let samples = self.samples(&cameras)?;
                let searches = cameras.iter().zip(&samples);
                let mut searches: Vec<Search<'_>> =
                    searches.map(|(camera, samples)| Search::new(*camera, samples, in_parts)).collect();
                for (nth, part) in group.parts.iter().enumerate() {
                    self.hold(part, in_parts)?;
                    let pass = self.pass();
                    pruning::find(&pass, &mut searches, nth == 0, self.of.job)?;
                    if let Some(lattice) = &self.put.lattice {
                        let kind = usize::from(self.put.level > ROOT);
                        residuals.compare(kind, lattice, &cameras, part, &self.of.window.layers);
                    }
                }
                if in_parts {
                    pruning::conclude_all(&self.pass(), &mut searches, false, self.of.job)?;
                }
                for (search, samples) in searches.into_iter().zip(&samples) {
                    if let Some(tally) = tally.as_mut().filter(|_| self.put.level == ROOT) {
                        let noise = self.of.window.layers[search.camera].noise_between.as_deref();
                        tally.add_noise_of(search.camera, noise, samples);
                        self.of.job.advance(1);
                    }
                    self.verdicts.put(search.camera, search.decided)?;
                }
            }
        }
        self.of.window.reserve(0);
        Ok(())
    }

    pub(super) fn hold(&mut self, part: &[usize], in_parts: bool) -> Result<()> {
        let Pruner { window, job, .. } = &mut *self.of;
        if in_parts { window.hold_only(part, job) } else { window.hold(part, job) }
    }

    /// Packs what is kept.
    fn pack_all(&mut self, tally: &mut Tally, kept: &mut KeptSamples) -> Result<()> {
        let (settings, put) = (self.of.recording.settings, self.put);
        let refines = Consensus::is_on(settings, self.of.window.most_noise() > 0.0);
        if refines && put.level > ROOT {
            self.of.window.smooth = Arc::new(SmoothDepths::new(self.of.pairs, put.level));
        }
        for group in self.groups.clone() {
            for cameras in self.pieces(&group.cameras, |camera| self.of.window.bytes(camera)) {
                // What is refined needs all that see it at once.
                let held = if refines { group.parts.concat() } else { cameras.clone() };
                self.hold(&held, false)?;
                let mut decided: Vec<LevelVerdicts> = Vec::new();
                for &camera in &cameras {
                    let mut of_camera = self.verdicts.take(camera)?;
                    let ranks = &self.of.window.samples(camera)?.ranks;
                    of_camera.count_mixed(ranks, settings.pruning.mixed_pixels);
                    decided.push(of_camera);
                }
                let Pruner { pairs, window, job, .. } = &*self.of;
                let consensus =
                    refines.then(|| Consensus::smoothed(pairs, &window.layers, &window.smooth, settings));
                let pack = |(&camera, decided): (&usize, &LevelVerdicts)| {
                    job.check()?;
                    let layer = &window.layers[camera];
                    let masks = Masks::decided(layer, decided);
                    let normals = settings.store.normals;
                    Ok(pruning::pack(camera, put.span, layer, masks, consensus.as_ref(), normals))
                };
                let packed: Vec<_> = cameras.par_iter().zip(&decided).map(pack).collect::<Result<_>>()?;
                drop(consensus);
                for ((&camera, decided), image) in cameras.iter().zip(&decided).zip(packed) {
                    tally.add(put.span, put.level == ROOT, camera, decided);
                    image.map_or(Ok(()), |image| kept.images.push(image))?;
                    if let Some(verdicts) = &mut kept.verdicts {
                        verdicts.push(decided.stored(camera, put.span))?;
                    }
                    if put.level == ROOT {
                        job.advance(1);
                    }
                }
            }
        }
        Ok(())
    }
}
