//! The steps of pruning, each for one group of views after the other.

use rayon::prelude::*;

use super::neighborhoods::{ViewGroup, neighborhood_order};
use super::recording::Views;
use super::verdict_store::VerdictStore;
use super::window::LayerWindow;
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::agreement::Consensus;
use crate::preprocess::diagnostics::{Residuals, Tally};
use crate::preprocess::pruning::{
    self, Masks, PruningPass, Statuses, Waiting, find, pass_over_views, settle,
};
use crate::preprocess::registration::CameraPairs;
use crate::preprocess::temporal::all_frames;
use crate::samples::ImageBuffer;
use crate::settings::MixedPixels;

/// The verdicts of this many views are held in memory at once by steps that do not need those of a whole group.
const VERDICTS_TOGETHER: usize = 16;
/// Samples that wait before some of them are decided, each with all its candidates: some 150 bytes.
const MOST_WAITING: usize = 1 << 19;

fn samples_of(waiting: &[Waiting]) -> usize {
    waiting.iter().map(Waiting::len).sum()
}

/// What the steps of pruning share.
pub(super) struct Pruning<'a> {
    views: Views<'a>,
    pairs: &'a CameraPairs<'a>,
    groups: Vec<ViewGroup>,
    window: LayerWindow<'a>,
    statuses: Statuses,
    verdicts: VerdictStore,
    job: &'a Job,
}

impl<'a> Pruning<'a> {
    /// Before the first step.
    pub(super) fn new(
        views: Views<'a>,
        pairs: &'a CameraPairs<'a>,
        mut window: LayerWindow<'a>,
        job: &'a Job,
    ) -> Self {
        let others = |camera: usize| pairs.others(camera).map(|(other, _)| other);
        let groups = window.groups(&neighborhood_order(pairs), others);
        let (statuses, verdicts) = (views.no_statuses(), VerdictStore::new(views.settings));
        Self { views, pairs, groups, window, statuses, verdicts, job }
    }

    fn pass(&self) -> PruningPass<'_> {
        pass_over_views(self.pairs, &self.window.layers, &self.statuses, self.views.settings)
    }

    /// Finds the best candidate of every sample.
    pub(super) fn find_all(&mut self, tally: &mut Tally, residuals: &mut Residuals<'_>) -> Result<()> {
        for group in self.groups.clone() {
            self.window.hold(&group.held, self.job)?;
            for cameras in group.cameras.chunks(VERDICTS_TOGETHER) {
                let found = find(&self.pass(), cameras, self.job)?;
                for (&camera, decided) in cameras.iter().zip(found) {
                    tally.add_noise_of(camera, &self.window.layers[camera]);
                    residuals.add_lasting_of(camera, &self.window.layers);
                    self.verdicts.put(camera, &decided)?;
                    self.job.advance(1);
                }
            }
        }
        Ok(())
    }

    /// Decides all samples. Of those that wait for views of other groups all is found that a decision takes; nothing is compared
    /// after that.
    pub(super) fn settle_all(&mut self) -> Result<()> {
        let mut waiting: Vec<Waiting> = Vec::new();
        waiting.resize_with(self.views.capture.cameras.len(), Waiting::default);
        let mut most = MOST_WAITING;
        for group in self.groups.clone() {
            self.window.hold(&group.held, self.job)?;
            let settled = self.settle(&group.cameras, None)?;
            for (camera, waits) in settled {
                waiting[camera] = waits;
            }
            // Most of what waits does so for the group that comes next: it is decided before more of it piles up.
            if samples_of(&waiting) > most {
                self.go_on(&mut waiting)?;
                most = MOST_WAITING.max(2 * samples_of(&waiting));
            }
        }
        while samples_of(&waiting) > 0 {
            self.go_on(&mut waiting)?;
        }
        Ok(())
    }

    /// Decides what waits for something that is decided by now.
    fn go_on(&mut self, waiting: &mut Vec<Waiting>) -> Result<()> {
        let pass = self.pass();
        let may_go_on = |camera: &usize| waiting[*camera].may_go_on(&pass);
        let cameras: Vec<usize> = (0..waiting.len()).filter(may_go_on).collect();
        for cameras in cameras.chunks(VERDICTS_TOGETHER) {
            for (camera, waits) in self.settle(cameras, Some(waiting))? {
                waiting[camera] = waits;
            }
        }
        Ok(())
    }

    /// Decides the samples of some views as far as possible: all for the first time, or those that are `waiting`. Gives those that still
    /// wait.
    fn settle(
        &mut self,
        cameras: &[usize],
        mut waiting: Option<&mut Vec<Waiting>>,
    ) -> Result<Vec<(usize, Waiting)>> {
        let is_first = waiting.is_none();
        let mut decided = Vec::new();
        for &camera in cameras {
            let waits = waiting.as_mut().map(|waiting| std::mem::take(&mut waiting[camera]));
            decided.push((camera, self.verdicts.get(camera)?, waits));
        }
        let pass = self.pass();
        let mut before = usize::MAX;
        loop {
            self.job.check()?;
            decided.par_iter_mut().for_each(|(camera, decided, waits)| {
                *waits = Some(settle(&pass, *camera, decided, waits.take()));
            });
            let after = decided.iter().filter_map(|(.., waits)| waits.as_ref()).map(Waiting::len).sum();
            if after == 0 || after == before {
                break;
            }
            before = after;
        }
        let mut settled = Vec::new();
        for (camera, decided, waits) in decided {
            let mut waits = waits.unwrap_or_default();
            if is_first {
                waits.prepare(&self.pass(), camera, &decided.pixels);
            }
            self.verdicts.replace(camera, &decided)?;
            settled.push((camera, waits));
        }
        Ok(settled)
    }

    /// Packs what is kept.
    pub(super) fn pack_all(&mut self, tally: &mut Tally, images: &mut ImageBuffer) -> Result<()> {
        let settings = self.views.settings;
        let refines = Consensus::is_on(settings, self.window.most_noise() > 0.0);
        let order: Vec<usize> = self.groups.iter().flat_map(|group| group.cameras.iter().copied()).collect();
        let alone = |_: usize| std::iter::empty();
        let groups = if refines { self.groups.clone() } else { self.window.groups(&order, alone) };
        for group in groups {
            self.window.hold(&group.held, self.job)?;
            let layers = &self.window.layers;
            let consensus =
                refines.then(|| Consensus::smoothed(self.pairs, layers, &self.window.smooth, settings));
            let (verdicts, job) = (&self.verdicts, self.job);
            let pack = |&camera: &usize| {
                job.check()?;
                let mut decided = verdicts.get(camera)?;
                if settings.pruning.mixed_pixels != MixedPixels::Keep {
                    decided.count_mixed(&layers[camera]);
                }
                let masks = Masks::decided(&layers[camera], &decided);
                let span = all_frames(self.views.scan.frames);
                let (layer, normals) = (&layers[camera], settings.store.normals);
                let image = pruning::pack(camera, span, layer, masks, consensus.as_ref(), normals);
                Ok((decided, image))
            };
            for cameras in group.cameras.chunks(VERDICTS_TOGETHER) {
                let packed: Vec<_> = cameras.par_iter().map(pack).collect::<Result<_>>()?;
                for (&camera, (decided, image)) in cameras.iter().zip(packed) {
                    tally.add_view(camera, &decided);
                    image.map_or(Ok(()), |image| images.push(image))?;
                    self.job.advance(1);
                }
            }
        }
        Ok(())
    }
}
