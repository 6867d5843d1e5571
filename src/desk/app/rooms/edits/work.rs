//! Applies edits and the selection to the samples that the window shows.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::app::model::scene::Content;
use crate::app::model::{Message, Same, State};
use crate::app::rooms::edits::state::{EditKey, EditedScene, SelectionPlace};
use crate::app::theme::Tokens;
use crate::app::work::worker::Wanted;
use overlook_engine::color::linear_from_srgb;
use overlook_engine::edits::{
    Action, CutByHand, Edit, EditList, Region, edit_samples, edit_tinted, selected,
};
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::preprocess::votes_on;
use overlook_engine::samples::{ImageBuffer, SampleImage, SampleSet, SampleVotes};

impl Wanted for EditKey {
    /// Edits applied to the samples, with what is selected of them.
    fn wanted(state: &State) -> Option<Self> {
        let samples = state.samples_to_edit().filter(|_| state.doc.edits.are_in_use())?;
        Some(Self {
            scene: state.doc.scene.clone()?,
            samples: Same(samples.clone()),
            scan: state.doc.scan.clone().map(Same),
            list: state.doc.edits.list.clone(),
            selection: state.doc.edits.shown_selection(),
        })
    }
}

/// What a list leaves of samples, and how many each of its edits took.
type Cut = (Arc<SampleSet>, Vec<i64>);

/// What is kept between edits: what was read, asked and cut last.
#[derive(Default)]
pub(crate) struct SampleEditor {
    /// All samples of a store that plays from disk, by its scene.
    read: Option<(u64, Arc<SampleSet>)>,
    /// The votes on samples.
    votes: Option<(Arc<SampleSet>, Arc<SampleVotes>)>,
    cut: Option<(Arc<SampleSet>, EditList, Cut)>,
}

impl SampleEditor {
    /// What edits leave, and how the selection is shown; the trouble where they ask for what is not there.
    pub(crate) fn answer(&mut self, key: EditKey, job: &Job) -> Result<Message> {
        let edited = match self.edited(&key, job) {
            Err(error) if !job.is_cancelled() => Err(error.to_string()),
            other => Ok(other?),
        };
        Ok(Message::Edited { key: Box::new(key), edited: edited.map(Box::new) })
    }

    fn edited(&mut self, key: &EditKey, job: &Job) -> Result<EditedScene> {
        let base = self.base(key, job)?;
        let done = if let Content::Store { report, .. } = &key.scene.content { &report.cut[..] } else { &[] };
        let list = CutByHand::left_to_do(done, &key.list);
        let asks = list.asks_for_votes() || key.selection.as_ref().is_some_and(Region::asks_for_votes);
        let votes = if asks { self.votes(key, &base, job)? } else { None };
        let (votes, place) = (votes.as_deref(), &key.scene.name);
        let (samples, counts) = self.cut(&base, &list, votes, place, job)?;
        let mut counted = list.edits.iter().zip(counts).peekable();
        let mut count_of =
            |edit: &Edit| counted.next_if(|(left, _)| *left == edit).map_or(0, |(_, count)| count);
        let mut edited = EditedScene {
            counts: key.list.edits.iter().map(&mut count_of).collect(),
            before: base.sample_count(),
            deleted: base.sample_count().saturating_sub(samples.sample_count()),
            selected: 0,
            place: None,
            bytes: samples.bytes(),
            shown: samples.clone(),
            samples,
        };
        if let Some(region) = &key.selection {
            let mark = Tokens::of(true).mark;
            let color =
                [mark.r(), mark.g(), mark.b()].map(|channel| linear_from_srgb(f32::from(channel) / 255.0));
            let (tinted, count) = selected(&base, region, color, votes, place, job)?;
            if list.is_idle() {
                (edited.shown, edited.selected) = (Arc::new(tinted), count);
            } else {
                edited.shown = Arc::new(edit_tinted(&tinted, &base, &list, votes, place, job)?);
                let mut without = list;
                without.edits.push(Edit::new("", Action::Delete, region.clone()));
                let (rest, _) = edit_samples(&base, &without, votes, place, job)?;
                edited.selected = edited.samples.sample_count().saturating_sub(rest.sample_count());
            }
            job.check()?;
            edited.place = place_of_selection(&edited.shown, &edited.samples);
        }
        Ok(edited)
    }

    /// All samples before edits.
    fn base(&mut self, key: &EditKey, job: &Job) -> Result<Arc<SampleSet>> {
        let Some(playback) = key.scene.playback() else { return Ok(key.samples.0.clone()) };
        if let Some((_, samples)) = self.read.as_ref().filter(|(scene, _)| *scene == key.scene.id) {
            return Ok(samples.clone());
        }
        let samples = Arc::new(playback.store().read_all(job)?);
        self.read = Some((key.scene.id, samples.clone()));
        Ok(samples)
    }

    fn votes(&mut self, key: &EditKey, base: &Arc<SampleSet>, job: &Job) -> Result<Option<Arc<SampleVotes>>> {
        if let Some((_, votes)) = self.votes.as_ref().filter(|(of, _)| Arc::ptr_eq(of, base)) {
            return Ok(Some(votes.clone()));
        }
        let Some(capture) = key.scan.as_ref().map(|scan| scan.capture()).or(key.scene.capture()) else {
            return Ok(None);
        };
        let votes = votes_on(&ImageBuffer::of(&base.images), &base.cameras, capture, job)?;
        let votes = Arc::new(votes);
        self.votes = Some((base.clone(), votes.clone()));
        Ok(Some(votes))
    }

    fn cut(
        &mut self,
        base: &Arc<SampleSet>,
        list: &EditList,
        votes: Option<&SampleVotes>,
        place: &str,
        job: &Job,
    ) -> Result<Cut> {
        if list.is_idle() {
            return Ok((base.clone(), vec![0; list.edits.len()]));
        }
        if let Some((_, _, cut)) = self.cut.as_ref().filter(|(of, by, _)| Arc::ptr_eq(of, base) && by == list)
        {
            return Ok(cut.clone());
        }
        let (left, taken) = edit_samples(base, list, votes, place, job)?;
        let cut = (Arc::new(left), taken);
        self.cut = Some((base.clone(), list.clone(), cut.clone()));
        Ok(cut)
    }
}

/// Count, mean and summed squared distance from the mean of some points.
type Spread = (f64, DVec3, f64);

/// The spread of all points together (T. F. Chan et al., 1979), which loses nothing far from the origin.
fn joined((count, mean, squares): Spread, (more, of_more, of_their_squares): Spread) -> Spread {
    let (all, apart) = (count + more, of_more - mean);
    if all == 0.0 {
        return Spread::default();
    }
    let between = apart.length_squared() * count * more / all;
    (all, mean + apart * (more / all), squares + of_their_squares + between)
}

/// Where the samples lie that are `shown` in another color than their own.
fn place_of_selection(shown: &SampleSet, samples: &SampleSet) -> Option<SelectionPlace> {
    let of_image = |(shown, own): (&Arc<SampleImage>, &Arc<SampleImage>)| {
        // Images without any are shared, and of others only tiles with some are placed: every selection waits for this.
        if Arc::ptr_eq(shown, own) {
            return Spread::default();
        }
        let camera = &samples.cameras[own.camera as usize];
        let is_selected = |index: usize| shown.color.get(index) != own.color.get(index);
        let mut known = Spread::default();
        for (nth, tile) in own.tiles.iter().enumerate() {
            let (first, count) = (tile.first as usize, tile.count());
            if !(first..first + count).any(is_selected) {
                continue;
            }
            let depths = own.depth.tile(nth, tile.first, count);
            for sample in tile.samples().filter(|sample| is_selected(sample.index)) {
                let inverse_depth = depths.get(sample.index - first);
                if inverse_depth > 0.0 {
                    let center = DVec2::new(sample.x as f64 + 0.5, sample.y as f64 + 0.5);
                    let point = camera.unproject(center, 1.0 / f64::from(inverse_depth));
                    known = joined(known, (1.0, point, 0.0));
                }
            }
        }
        known
    };
    let of_images: Vec<Spread> = shown.images.par_iter().zip(&samples.images).map(of_image).collect();
    let (count, mean, squares) = of_images.into_iter().fold(Spread::default(), joined);
    (count > 0.0).then(|| SelectionPlace { mean, spread: (squares / count).sqrt() })
}
