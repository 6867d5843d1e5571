//! Deciding the samples of a span once the best candidate of each is found.
//!
//! Purpose: where not all layers fit into memory, each look at the others costs reading all of their layers. So samples whose best
//! candidate was dropped, and samples that wait for these, are looked up once, all together. Their other candidates and the votes of
//! other cameras are noted, and all that follows is decided from these notes.
//!
//! ```text
//! no candidate ─▶ others vote                                   (all layers once)
//! best candidate dropped, or undecided ─▶ other candidates, votes (all layers once, again where notes take too much memory)
//!                                      ─▶ decided in order, from the notes alone
//! ```

use rayon::prelude::*;

use super::groups::{LAYERS_AT_A_TIME, parts_beside};
use super::steps::{SAMPLE_BYTES, SpanStep};
use crate::error::Result;
use crate::preprocess::layers::RatedSamples;
use crate::preprocess::pruning::{
    self, Prepared, Preparing, PruningPass, Resolved, Rule, Search, Unsettled, Verdict, resolve_camera,
};

/// Bytes of a sample while its candidates are looked up, with some of them.
const PREPARED_BYTES: usize = 160;

/// Samples that are asked about or prepared together, at least: for each such batch all layers are gone through.
const LEAST_TOGETHER: usize = 1 << 12;

/// Some samples of one camera that are worked on together.
struct SomeSamples {
    camera: usize,
    /// Among the camera's samples, ascending.
    indices: Vec<u32>,
    samples: RatedSamples,
}

impl SpanStep<'_, '_> {
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

    /// Some samples of each camera, as many as are worked on together: `indices` keeps the others.
    fn some_of(&mut self, indices: &mut [Vec<u32>], mut room: usize) -> Result<Vec<SomeSamples>> {
        let mut some = Vec::new();
        for (camera, indices) in indices.iter_mut().enumerate().filter(|(_, indices)| !indices.is_empty()) {
            if room == 0 {
                break;
            }
            let rest = indices.split_off(room.min(indices.len()));
            let indices = std::mem::replace(indices, rest);
            room -= indices.len();
            let samples = self.of.window.samples(camera)?.at(&indices);
            some.push(SomeSamples { camera, indices, samples });
        }
        Ok(some)
    }

    /// Lets all other cameras vote on some samples of each camera, and gives the verdicts on these.
    fn ask(&mut self, mut asked: Vec<Vec<u32>>) -> Result<()> {
        let job = self.of.job;
        while asked.iter().any(|asked| !asked.is_empty()) {
            let room = (self.of.recording.bound / 2 / SAMPLE_BYTES).max(LEAST_TOGETHER);
            let count: usize = asked.iter().map(Vec::len).sum();
            self.of.window.reserve(count.min(room) * SAMPLE_BYTES);
            let some = self.some_of(&mut asked, room)?;
            let mut searches = Vec::new();
            for SomeSamples { camera, indices, samples } in &some {
                let decided = self.verdicts.take(*camera)?;
                let verdicts = indices.iter().map(|index| decided.verdicts[*index as usize]).collect();
                self.verdicts.put_back(*camera, decided);
                searches.push(Search::of_asked(*camera, samples, verdicts));
            }
            self.look_at_own(&mut searches)?;
            self.part_by_part(&some, |pass, part| pruning::ask_others(pass, &mut searches, part, job))?;
            pruning::conclude_all(&self.pass(), &mut searches, true, job)?;
            for (SomeSamples { camera, indices, .. }, search) in some.iter().zip(searches) {
                let mut decided = self.verdicts.take(*camera)?;
                for (index, verdict) in indices.iter().zip(&search.decided.verdicts) {
                    decided.verdicts[*index as usize] = *verdict;
                }
                self.verdicts.put(*camera, decided)?;
            }
        }
        self.of.window.reserve(0);
        Ok(())
    }

    /// Finds out which samples of some searches are thin, from the layers of their own cameras.
    fn look_at_own(&mut self, searches: &mut [Search<'_>]) -> Result<()> {
        for searches in searches.chunks_mut(LAYERS_AT_A_TIME) {
            let own: Vec<usize> = searches.iter().map(|search| search.camera).collect();
            self.hold(&own, false)?;
            pruning::look_at_own(&self.pass(), searches, self.of.job)?;
        }
        Ok(())
    }

    /// Goes through the layers of the cameras of some samples, and of all that may see these. `look` gets the cameras whose layers are there.
    fn part_by_part(
        &mut self,
        some: &[SomeSamples],
        mut look: impl FnMut(&PruningPass<'_>, &[usize]) -> Result<()>,
    ) -> Result<()> {
        let cameras: Vec<usize> = some.iter().map(|some| some.camera).collect();
        for part in parts_beside(self.of.pairs, &self.of.layer_bytes(), &cameras) {
            self.hold(&part, true)?;
            look(&self.pass(), &part)?;
        }
        Ok(())
    }

    /// Decides all samples.
    ///
    /// # Errors
    /// `Io` where a temporary file cannot be used, and `Cancelled`.
    pub(super) fn settle_all(&mut self) -> Result<()> {
        if self.of.window.holds_all {
            return self.settle_at_once();
        }
        if self.pass().votes.is_on() && self.groups.iter().any(|group| group.parts.len() > 1) {
            let asked = self.without_candidate()?;
            self.ask(asked)?;
        }
        let mut prepared: Vec<Prepared> = self.put.counts.iter().map(|_| Prepared::default()).collect();
        loop {
            self.settle_prepared(&mut prepared)?;
            let resolved = self.resolve_all(&prepared)?;
            if resolved.iter().any(|resolved| !resolved.stuck.is_empty()) {
                self.prepare(resolved, &mut prepared)?;
            } else if prepared.iter().all(|prepared| prepared.len() == 0)
                && resolved.iter().all(|resolved| resolved.waiting.is_empty())
            {
                return Ok(());
            }
        }
    }

    /// Settles everything where all layers are there.
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
                prepared[camera].leave_out(&mut resolved.stuck);
                prepared[camera].leave_out(&mut resolved.waiting);
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

    /// Decides the samples that are prepared, as far as possible.
    fn settle_prepared(&mut self, prepared: &mut [Prepared]) -> Result<()> {
        let mut before = usize::MAX;
        loop {
            for (camera, known) in prepared.iter_mut().enumerate().filter(|(_, known)| known.len() > 0) {
                self.of.job.check()?;
                let mut decided = self.verdicts.take(camera)?;
                known.settle(&self.pass(), camera, &mut decided);
                self.verdicts.put(camera, decided)?;
            }
            let left = prepared.iter().map(Prepared::len).sum();
            if left == 0 || left == before {
                return Ok(());
            }
            before = left;
        }
    }

    /// Finds all candidates of some samples of each camera, and whether the others contradict them, so that they are decided without
    /// any layer. Where they are very many, of some of them.
    fn prepare(&mut self, resolved: Vec<Resolved>, prepared: &mut [Prepared]) -> Result<()> {
        let job = self.of.job;
        let held: usize = prepared.iter().map(Prepared::bytes).sum();
        let room = (self.of.recording.bound / 4 * 3).saturating_sub(held) / PREPARED_BYTES;
        let room = room.max(LEAST_TOGETHER);
        let stuck: usize = resolved.iter().map(|resolved| resolved.stuck.len()).sum();
        // Samples that wait may be stuck later, when layers would be loaded for them again.
        let mut room_for_waiting = room.saturating_sub(stuck);
        let of_camera = |Resolved { mut waiting, stuck }: Resolved| {
            waiting.truncate(room_for_waiting);
            room_for_waiting -= waiting.len();
            waiting.extend(stuck);
            waiting.sort_unstable();
            waiting
        };
        let mut indices: Vec<Vec<u32>> = resolved.into_iter().map(of_camera).collect();
        let asked: usize = indices.iter().map(Vec::len).sum();
        self.of.window.reserve(held + asked.min(room) * PREPARED_BYTES);
        let some = self.some_of(&mut indices, room)?;
        let votes = self.pass().votes.is_on();
        let none_kept =
            |samples: &RatedSamples| vec![Verdict::without_witness(Rule::Coverage); samples.len()];
        let mut searches: Vec<Search<'_>> = some
            .iter()
            .map(|some| Search::of_asked(some.camera, &some.samples, none_kept(&some.samples)))
            .collect();
        if votes {
            self.look_at_own(&mut searches)?;
        }
        let mut preparing: Vec<Preparing<'_>> =
            some.iter().map(|some| Preparing::new(some.camera, &some.samples)).collect();
        self.part_by_part(&some, |pass, part| {
            preparing.par_iter_mut().for_each(|preparing| preparing.compare(pass, part));
            if votes { pruning::ask_others(pass, &mut searches, part, job) } else { Ok(()) }
        })?;
        let both = preparing.into_iter().zip(searches);
        for (SomeSamples { camera, indices, .. }, (preparing, search)) in some.iter().zip(both) {
            prepared[*camera].add(indices, preparing, &search.contradicted(&self.pass()));
        }
        self.of.window.reserve(0);
        Ok(())
    }
}
