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
const PREPARED_BYTES: usize = 160;

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

impl Pruner<'_> {
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

    /// Pieces of some cameras whose samples, and `more` of each, take no more than a share of memory together.
    fn pieces(&self, cameras: &[usize], more: impl Fn(usize) -> usize) -> Vec<Vec<usize>> {
        if self.of.window.holds_all {
            return vec![cameras.to_vec()];
        }
        let counts = self.put.counts.iter().enumerate();
        let bytes: Vec<usize> = counts.map(|(camera, count)| count * SAMPLE_BYTES + more(camera)).collect();
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
            let pieces =
                if in_parts { vec![group.cameras.clone()] } else { self.pieces(&group.cameras, |_| 0) };
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
        Ok(())
    }

    fn hold(&mut self, part: &[usize], in_parts: bool) -> Result<()> {
        let Pruner { window, job, .. } = &mut *self.of;
        if in_parts { window.hold_only(part, job) } else { window.hold(part, job) }
    }

    /// The samples of all cameras without a candidate that others are to vote on: where they were not asked yet.
    fn without_candidate(&mut self) -> Result<Vec<Vec<u32>>> {
        let mut all = Vec::new();
        for camera in 0..self.put.counts.len() {
            let decided = self.verdicts.take(camera)?;
            all.push(pruning::left_open(&self.pass(), camera, &decided));
            self.verdicts.put_back(camera, decided);
        }
        Ok(all)
    }

    /// Lets all other cameras vote on some samples of each camera, and gives the verdicts on these.
    fn ask(&mut self, mut asked: Vec<Vec<u32>>) -> Result<()> {
        let job = self.of.job;
        while asked.iter().any(|asked| !asked.is_empty()) {
            let mut room = self.of.recording.bound / 2 / SAMPLE_BYTES;
            let mut samples: Vec<(usize, Vec<u32>, RatedSamples)> = Vec::new();
            for (camera, asked) in asked.iter_mut().enumerate().filter(|(_, asked)| !asked.is_empty()) {
                if room > 0 || samples.is_empty() {
                    let rest = asked.split_off(room.max(1).min(asked.len()));
                    let now = std::mem::replace(asked, rest);
                    room = room.saturating_sub(now.len());
                    let of_camera = self.of.window.samples(camera)?.at(&now);
                    samples.push((camera, now, of_camera));
                }
            }
            let mut searches = Vec::new();
            for (camera, indices, samples) in &samples {
                let decided = self.verdicts.take(*camera)?;
                let verdicts = indices.iter().map(|index| decided.verdicts[*index as usize]).collect();
                self.verdicts.put_back(*camera, decided);
                searches.push(Search::of_asked(*camera, samples, verdicts));
            }
            if self.pass().votes.is_on() {
                for search in &mut searches {
                    self.hold(&[search.camera], false)?;
                    pruning::look_at_own(&self.pass(), std::slice::from_mut(search), job)?;
                }
                self.ask_part_by_part(&mut searches)?;
            }
            pruning::conclude_all(&self.pass(), &mut searches, true, job)?;
            for ((camera, indices, _), search) in samples.iter().zip(searches) {
                let mut decided = self.verdicts.take(*camera)?;
                for (index, verdict) in indices.iter().zip(&search.decided.verdicts) {
                    decided.verdicts[*index as usize] = *verdict;
                }
                self.verdicts.put(*camera, decided)?;
            }
        }
        Ok(())
    }

    fn ask_part_by_part(&mut self, searches: &mut [Search<'_>]) -> Result<()> {
        for group in self.of.groups(&vec![0; self.put.counts.len()]) {
            let is_of_group = |search: &&mut Search<'_>| group.cameras.contains(&search.camera);
            // The searches are in the order of the cameras, and so are groups of all of them.
            let mut of_group: Vec<&mut Search<'_>> = searches.iter_mut().filter(is_of_group).collect();
            let is_any = !of_group.is_empty();
            for part in group.parts.iter().filter(|_| is_any) {
                self.hold(part, group.parts.len() > 1)?;
                pruning::ask_others(&self.pass(), &mut of_group, self.of.job)?;
            }
        }
        Ok(())
    }

    /// Decides all samples.
    fn settle_all(&mut self) -> Result<()> {
        if self.of.window.holds_all {
            return self.settle_at_once();
        }
        if self.pass().votes.is_on() && self.groups.iter().any(|group| group.parts.len() > 1) {
            let asked = self.without_candidate()?;
            self.ask(asked)?;
        }
        let mut prepared: Vec<Prepared> = Vec::new();
        let mut asked = vec![Vec::new(); self.put.counts.len()];
        loop {
            self.settle_prepared(&mut prepared, &mut asked)?;
            let resolved = self.resolve_all(&prepared)?;
            if resolved.iter().any(|resolved| !resolved.stuck.is_empty()) {
                self.prepare(resolved, &mut prepared)?;
            } else if asked.iter().any(|asked| !asked.is_empty()) {
                // Layers are loaded for this, so that it comes only when nothing else goes on.
                self.ask(std::mem::replace(&mut asked, vec![Vec::new(); self.put.counts.len()]))?;
            } else if prepared.is_empty() && resolved.iter().all(|resolved| resolved.waiting.is_empty()) {
                return Ok(());
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

    /// Decides all that can be decided without any layer. Gives what is left by camera, but for samples that are prepared.
    fn resolve_all(&mut self, prepared: &[Prepared]) -> Result<Vec<Resolved>> {
        let mut before = usize::MAX;
        loop {
            let mut all = Vec::new();
            for camera in 0..self.put.counts.len() {
                self.of.job.check()?;
                let decided = self.verdicts.take(camera)?;
                let mut resolved = resolve_camera(&self.pass(), camera, &decided);
                for known in prepared.iter().filter(|known| known.camera == camera) {
                    known.leave_out(&mut resolved.stuck);
                    known.leave_out(&mut resolved.waiting);
                }
                self.verdicts.put_back(camera, decided);
                all.push(resolved);
            }
            let left = all.iter().map(|resolved| resolved.waiting.len() + resolved.stuck.len()).sum();
            if left == 0 || left == before {
                return Ok(all);
            }
            before = left;
        }
    }

    /// Decides the samples that are prepared, as far as possible. Those that are kept if others do not contradict them are `asked` about
    /// later.
    fn settle_prepared(&mut self, prepared: &mut Vec<Prepared>, asked: &mut [Vec<u32>]) -> Result<()> {
        let mut before = usize::MAX;
        loop {
            for known in prepared.iter_mut() {
                self.of.job.check()?;
                let mut decided = self.verdicts.take(known.camera)?;
                asked[known.camera].extend(known.settle(&self.pass(), &mut decided));
                self.verdicts.put(known.camera, decided)?;
            }
            prepared.retain(|known| known.len() > 0);
            let left = prepared.iter().map(Prepared::len).sum();
            if left == 0 || left == before {
                for asked in asked.iter_mut() {
                    asked.sort_unstable();
                }
                return Ok(());
            }
            before = left;
        }
    }

    /// Finds all candidates of some samples of each camera. Where they are very many, of some of them.
    fn prepare(&mut self, resolved: Vec<Resolved>, prepared: &mut Vec<Prepared>) -> Result<()> {
        let mut room = self.of.recording.bound / 4 * 3 / PREPARED_BYTES;
        let stuck: usize = resolved.iter().map(|resolved| resolved.stuck.len()).sum();
        // Samples that wait may be stuck later, when layers would be loaded for them again.
        let mut room_for_waiting = room.saturating_sub(stuck);
        let mut new: Vec<Prepared> = Vec::new();
        for (camera, Resolved { mut waiting, stuck: mut indices }) in resolved.into_iter().enumerate() {
            waiting.truncate(room_for_waiting);
            room_for_waiting -= waiting.len();
            indices.extend(waiting);
            indices.truncate(room.max(usize::from(new.is_empty())));
            room = room.saturating_sub(indices.len());
            indices.sort_unstable();
            if !indices.is_empty() {
                new.push(Prepared::new(camera, &*self.of.window.samples(camera)?, indices));
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
