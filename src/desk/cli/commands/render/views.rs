//! Views painted, all or a part of them, and what is known of each put together again.

use serde::{Deserialize, Serialize};

use crate::cli::output::PicturePaths;
use overlook_engine::capture::{Camera, TruthView};
use overlook_engine::error::{Error, Result};
use overlook_engine::job::Job;
use overlook_engine::part::Part;
use overlook_engine::render::Renderer;
use overlook_engine::settings::RenderSettings;
use overlook_engine::store::playback::Playback;
use overlook_lab::metrics::FlickerSum;
use overlook_lab::{
    Evaluation, Scoreboard, ViewScore, aligned_score, average_aligned, frame_of, render_view, vantage_order,
};

/// What is known of a view whose pictures are written.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct ViewRecord {
    /// Its index in the manifest.
    view: usize,
    score: ViewScore,
    /// The change of error from the view before, where that has the same vantage.
    flicker: FlickerSum,
    /// CRC-32 of its pictures, where the work is cut into parts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pictures: Option<[u32; 2]>,
    /// That another renderer than requested was used.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    notice: Option<String>,
}

/// Views of a store, and where their pictures go.
pub(super) struct ViewPainting<'a> {
    pub(super) playback: &'a Playback,
    pub(super) views: &'a [TruthView],
    pub(super) paths: &'a [PicturePaths],
    pub(super) settings: &'a RenderSettings,
    /// Whether each view is also scored from where its true picture says that it was taken.
    pub(super) aligns: bool,
}

impl ViewPainting<'_> {
    /// The views in the order in which they are painted: those of one vantage one after the other, so that flicker shows.
    fn order(&self) -> Vec<usize> {
        vantage_order(&self.views.iter().collect::<Vec<_>>())
    }

    /// Index of the frame of each view.
    fn frames(&self) -> Result<Vec<usize>> {
        let info = self.playback.store().info();
        self.views.iter().map(|view| frame_of(view, &info.name, &info.frame_numbers)).collect()
    }

    /// Paints all views.
    pub(super) fn paint_all(&self, job: &Job) -> Result<Evaluation> {
        let records = self.paint(&self.order(), 0, (&[], false), job, &mut |_| ())?;
        self.evaluation(records)
    }

    /// Paints a part of the views but for those that are `known`, and passes the record of each new one to `keep`. Gives the records
    /// of all.
    pub(super) fn paint_part(
        &self,
        part: Part,
        known: &[ViewRecord],
        job: &Job,
        keep: &mut dyn FnMut(&ViewRecord),
    ) -> Result<Vec<ViewRecord>> {
        let order = self.order();
        let range = part.range(order.len());
        self.paint(&order[..range.end], range.start, (known, true), job, keep)
    }

    /// Paints the views of `order` from position `first` on.
    fn paint(
        &self,
        order: &[usize],
        first: usize,
        (known, is_part): (&[ViewRecord], bool),
        job: &Job,
        keep: &mut dyn FnMut(&ViewRecord),
    ) -> Result<Vec<ViewRecord>> {
        let frames = self.frames()?;
        let mut renderer = Renderer::strict(self.settings.backend)?;
        let (mut scores, mut records) = (Scoreboard::default(), Vec::new());
        // The view that `scores` knows the picture of.
        let mut painted_last = None;
        job.start("Rendering views", order.len() - first);
        for (position, &index) in order.iter().enumerate().skip(first) {
            job.check()?;
            let view = &self.views[index];
            let known = known.iter().find(|record| record.view == index);
            if let Some(record) = known.filter(|record| self.has_pictures(record)) {
                records.push(record.clone());
                job.advance(1);
                continue;
            }
            let paint = |renderer: &mut Renderer, index: usize| {
                let view = &self.views[index];
                let samples = self.playback.seen_from(&view.camera, frames[index], job)?;
                render_view(renderer, &samples, view, None, self.settings, job)
            };
            let before = position.checked_sub(1).map(|before| order[before]);
            if let Some(before) = before.filter(|before| self.views[*before].camera == view.camera)
                && painted_last != Some(before)
                && view.truth.is_some()
            {
                scores.precede(&self.views[before], &paint(&mut renderer, before)?);
            }
            let painted = paint(&mut renderer, index)?;
            self.paths[index].write(&painted.picture)?;
            let (mut score, notice) = (painted.score.clone(), painted.notice.clone());
            let flicker = scores.add(view, painted);
            painted_last = Some(index);
            if self.aligns && score.scores.is_some() {
                let mut seen =
                    |_: &TruthView, camera: &Camera| self.playback.seen_from(camera, frames[index], job);
                score.aligned = aligned_score(&mut renderer, view, self.settings, &mut seen, job)?;
            }
            let pictures = if is_part { Some(self.paths[index].checksums()?) } else { None };
            records.push(ViewRecord { view: index, score, flicker, pictures, notice });
            keep(&records[records.len() - 1]);
            job.advance(1);
        }
        Ok(records)
    }

    fn has_pictures(&self, record: &ViewRecord) -> bool {
        let paths = self.paths.get(record.view);
        record.pictures.is_some() && paths.and_then(|paths| paths.checksums().ok()) == record.pictures
    }

    /// Scores and means of all views from their records, in the order in which they were painted.
    ///
    /// # Errors
    /// `Invalid` with the name of a view whose record or pictures are missing or changed.
    pub(super) fn evaluation(&self, records: Vec<ViewRecord>) -> Result<Evaluation> {
        let order = self.order();
        if let Some(nth) =
            (0..order.len()).find(|nth| records.get(*nth).map(|record| record.view) != Some(order[*nth]))
        {
            let view = &self.views[order[nth]].file_path;
            return Err(Error::invalid(format!("view '{view}'"), "is in none of the parts; make them again"));
        }
        let (mut scores, mut notice) = (Scoreboard::default(), None);
        for record in records {
            notice = notice.or(record.notice);
            scores.add_known(record.score, record.flicker);
        }
        let mut evaluation = scores.finish().in_order_of_views(&order);
        average_aligned(&mut evaluation);
        Ok(Evaluation { notice, ..evaluation })
    }

    /// Whether the pictures are those that the parts have written.
    ///
    /// # Errors
    /// `Invalid` with the name of one that is missing or changed.
    pub(super) fn check_pictures(&self, records: &[ViewRecord]) -> Result<()> {
        let changed = records.iter().find(|record| !self.has_pictures(record));
        let Some(paths) = changed.and_then(|record| self.paths.get(record.view)) else { return Ok(()) };
        Err(paths.refused())
    }
}
