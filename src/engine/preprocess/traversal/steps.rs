//! The steps of pruning one span: find, settle, pack, each for one group of cameras after the other.

use std::sync::Arc;

use rayon::prelude::*;

use super::groups::{CameraBytes, CameraGroup, chunks_within, groups_within};
use super::recording::Recording;
use super::verdict_store::VerdictStore;
use super::window::LayerWindow;
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::agreement::{Consensus, SmoothDepths};
use crate::preprocess::diagnostics::{LatticeRuns, Residuals, Tally};
use crate::preprocess::layers::RatedSamples;
use crate::preprocess::pruning::{
    self, LevelVerdicts, Masks, Prepared, PruningPass, Resolved, Search, Statuses, Unsettled,
    all_may_be_witnesses, resolve_camera,
};
use crate::preprocess::registration::CameraPairs;
use crate::preprocess::temporal::{ROOT, SpanLevel};
use crate::samples::{ImageBuffer, Span, samples_in_memory};

/// Bytes of a sample while it is worked on: itself, its verdict, and what is known between the parts of a search.
const SAMPLE_BYTES: usize = 38 + 12 + 16;
/// Bytes of a sample with all its candidates, about.
const PREPARED_BYTES: usize = 256;

/// What the steps of pruning share.
pub(super) struct Pruner<'a> {
    pub(super) recording: Recording<'a>,
    pub(super) pairs: &'a CameraPairs<'a>,
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
struct SpanStep<'s, 'a> {
    of: &'s mut Pruner<'a>,
    put: &'s PutSpan,
    groups: Vec<CameraGroup>,
    may_be_witnesses: Vec<bool>,
    verdicts: VerdictStore,
}

impl<'a> Pruner<'a> {
    /// Groups of cameras, each of which takes some memory for what is worked on.
    pub(super) fn groups(&self, samples: &[usize]) -> Vec<CameraGroup> {
        let all: Vec<usize> = (0..self.window.layers.len()).collect();
        if self.window.holds_all {
            return vec![CameraGroup { cameras: all.clone(), parts: vec![all] }];
        }
        let layers: Vec<usize> = all.iter().map(|camera| self.window.bytes(*camera)).collect();
        groups_within(self.pairs, &CameraBytes { layers: &layers, samples, bound: self.recording.bound })
    }

    /// Decides the samples of the span that was entered last, counts them where a `tally` is given, and packs what is kept.
    pub(super) fn prune(
        &mut self,
        put: &PutSpan,
        residuals: &mut Residuals<'_>,
        mut kept: Option<(&mut Tally, &mut ImageBuffer)>,
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
            if let Some((tally, images)) = kept {
                step.pack_all(tally, images)?;
            }
        }
        Ok(())
    }
}

impl SpanStep<'_, '_> {
    fn pass(&self) -> PruningPass<'_> {
        let Pruner { recording, pairs, window, statuses, .. } = &*self.of;
        let level = self.put.level;
        PruningPass::new(pairs, &window.layers, statuses, level, &self.may_be_witnesses, recording.settings)
    }

    /// Pieces of some cameras whose samples take no more than a share of memory together.
    fn pieces(&self, cameras: &[usize]) -> Vec<Vec<usize>> {
        if self.of.window.holds_all {
            return vec![cameras.to_vec()];
        }
        let bytes: Vec<usize> = self.put.counts.iter().map(|count| count * SAMPLE_BYTES).collect();
        chunks_within(cameras, &bytes, self.of.recording.bound / 2)
    }

    fn samples(&self, cameras: &[usize]) -> Result<Vec<Arc<RatedSamples>>> {
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
            let pieces = if in_parts { vec![group.cameras.clone()] } else { self.pieces(&group.cameras) };
            for cameras in pieces {
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
                    self.ask_in_parts(&group, &mut searches)?;
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
        Ok(())
    }

    fn hold(&mut self, part: &[usize], in_parts: bool) -> Result<()> {
        let Pruner { window, job, .. } = &mut *self.of;
        if in_parts { window.hold_only(part, job) } else { window.hold(part, job) }
    }

    /// Lets all other cameras vote on samples without a candidate, part by part, and ends the search.
    fn ask_in_parts(&mut self, group: &CameraGroup, searches: &mut [Search<'_>]) -> Result<()> {
        let job = self.of.job;
        if self.pass().votes.is_on() {
            for search in searches.iter_mut() {
                self.hold(&[search.camera], true)?;
                pruning::look_at_own(&self.pass(), std::slice::from_mut(search), job)?;
            }
            // The last part that was searched is held yet.
            for part in group.parts.iter().rev() {
                self.hold(part, true)?;
                pruning::ask_others(&self.pass(), searches, job)?;
            }
        }
        pruning::conclude_all(&self.pass(), searches, job)
    }

    /// Decides all samples.
    fn settle_all(&mut self) -> Result<()> {
        if self.of.window.holds_all {
            return self.settle_at_once();
        }
        let mut prepared: Vec<Prepared> = Vec::new();
        loop {
            self.settle_prepared(&mut prepared)?;
            let (waiting, stuck) = self.resolve_all(&prepared)?;
            if waiting == 0 && stuck.iter().all(Vec::is_empty) {
                return Ok(());
            }
            if stuck.iter().any(|stuck| !stuck.is_empty()) {
                self.prepare(stuck, &mut prepared)?;
            }
        }
    }

    /// The same where all layers are there.
    fn settle_at_once(&mut self) -> Result<()> {
        let cameras: Vec<usize> = (0..self.put.counts.len()).collect();
        let samples = self.samples(&cameras)?;
        let mut unsettled = Vec::new();
        for (&camera, samples) in cameras.iter().zip(&samples) {
            unsettled.push(Unsettled::new(camera, self.verdicts.take(camera)?, samples));
        }
        pruning::settle_all(&self.pass(), &mut unsettled, self.of.job)?;
        for (camera, unsettled) in cameras.into_iter().zip(unsettled) {
            self.verdicts.put(camera, unsettled.decided)?;
        }
        Ok(())
    }

    /// Decides all that can be decided without any layer. Gives the number of samples that wait for others to be decided, and by
    /// camera those that need to be prepared.
    fn resolve_all(&mut self, prepared: &[Prepared]) -> Result<(usize, Vec<Vec<u32>>)> {
        let mut before = usize::MAX;
        loop {
            let mut all = (0, Vec::new());
            for camera in 0..self.put.counts.len() {
                self.of.job.check()?;
                let decided = self.verdicts.take(camera)?;
                let Resolved { waiting, mut stuck } = resolve_camera(&self.pass(), camera, &decided);
                prepared
                    .iter()
                    .filter(|known| known.camera == camera)
                    .for_each(|known| known.leave_out(&mut stuck));
                self.verdicts.put_back(camera, decided);
                all.0 += waiting;
                all.1.push(stuck);
            }
            let left = all.0 + all.1.iter().map(Vec::len).sum::<usize>();
            if all.0 == 0 || left == before {
                return Ok(all);
            }
            before = left;
        }
    }

    /// Decides the samples that are prepared, as far as possible.
    fn settle_prepared(&mut self, prepared: &mut Vec<Prepared>) -> Result<()> {
        let mut before = usize::MAX;
        loop {
            for known in prepared.iter_mut() {
                self.of.job.check()?;
                let mut decided = self.verdicts.take(known.camera)?;
                known.settle(&self.pass(), &mut decided);
                self.verdicts.put(known.camera, decided)?;
            }
            prepared.retain(|known| known.len() > 0);
            let left = prepared.iter().map(Prepared::len).sum();
            if left == 0 || left == before {
                return Ok(());
            }
            before = left;
        }
    }

    /// Finds all that may be asked for on the way to a decision on some samples of each camera. Where they are very many, some of them.
    fn prepare(&mut self, stuck: Vec<Vec<u32>>, prepared: &mut Vec<Prepared>) -> Result<()> {
        let mut room = self.of.recording.bound / 2 / PREPARED_BYTES;
        let mut new: Vec<Prepared> = Vec::new();
        for (camera, mut indices) in stuck.into_iter().enumerate() {
            indices.truncate(room.max(1));
            room = room.saturating_sub(indices.len());
            if !indices.is_empty() && (room > 0 || new.is_empty()) {
                new.push(Prepared::new(camera, &*self.of.window.samples(camera)?, indices));
            }
        }
        if self.pass().votes.is_on() {
            for prepared in &mut new {
                self.hold(&[prepared.camera], false)?;
                prepared.look_at_own(&self.pass());
            }
        }
        let bytes = vec![0; self.put.counts.len()];
        for group in self.of.groups(&bytes) {
            let mut of_group: Vec<&mut Prepared> =
                new.iter_mut().filter(|prepared| group.cameras.contains(&prepared.camera)).collect();
            let is_any = !of_group.is_empty();
            for part in group.parts.iter().filter(|_| is_any) {
                self.hold(part, group.parts.len() > 1)?;
                let pass = self.pass();
                of_group.par_iter_mut().for_each(|prepared| prepared.compare(&pass, part));
            }
        }
        new.par_iter_mut().for_each(Prepared::end);
        prepared.extend(new);
        Ok(())
    }

    /// Packs what is kept.
    fn pack_all(&mut self, tally: &mut Tally, images: &mut ImageBuffer) -> Result<()> {
        let (settings, put) = (self.of.recording.settings, self.put);
        let refines = Consensus::is_on(settings, self.of.window.most_noise() > 0.0);
        if refines && put.level > ROOT {
            self.of.window.smooth = Arc::new(SmoothDepths::new(self.of.pairs, put.level));
        }
        for group in self.groups.clone() {
            for cameras in self.pieces(&group.cameras) {
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
                    image.map_or(Ok(()), |image| images.push(image))?;
                    if put.level == ROOT {
                        job.advance(1);
                    }
                }
            }
        }
        Ok(())
    }
}
