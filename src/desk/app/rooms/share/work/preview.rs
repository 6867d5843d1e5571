//! What the live view looks like within the budget of what is shared, beside all samples.

use std::sync::Arc;

use egui::ColorImage;
use half::f16;

use super::facts::samples_of_frame;
use crate::app::colormap::recorded;
use crate::app::model::{Message, State};
use crate::app::rooms::share::model::{SharePreview, SharePreviewKey};
use crate::app::work::slot::Wanted;
use overlook_engine::color::srgb_from_linear;
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::page::coarsened;
use overlook_engine::render::{CpuRenderer, Picture, Vantage};
use overlook_engine::samples::SampleSet;
use overlook_lab::metrics::psnr_db;

impl Wanted for SharePreviewKey {
    fn wanted(state: &State) -> Option<Self> {
        state.share_preview_key()
    }
}

/// Paints the view of all samples and of those within the budget.
pub(crate) fn preview(key: SharePreviewKey, job: &Job) -> Result<Message> {
    let here = samples_of_frame(&key.scene, &key.samples, key.vantage.frame, job)?;
    let images = here.images_at(key.vantage.frame).cloned().collect();
    let all = SampleSet { images, ..(*here).clone() };
    let most = (key.share * all.sample_count() as f64) as u64;
    let Some(some) = coarsened(&all, most, job)? else {
        return Ok(Message::SharePreviewed { preview: None, key });
    };
    let settings = &key.settings;
    let painted = |set: SampleSet, vantage: &Vantage| -> Result<Arc<Picture>> {
        Ok(CpuRenderer::new().render(&Arc::new(set), vantage, settings, job)?.0)
    };
    let [whole, within] = [painted(all, &key.vantage)?, painted(some, &key.vantage)?];
    let shown = |picture: &Picture| {
        picture.color.as_slice().iter().map(|color| color.map(srgb_from_linear)).collect::<Vec<_>>()
    };
    let decibels = psnr_db(&shown(&whole), &shown(&within), 0..whole.color.as_slice().len());
    let (width, height) = within.color.size();
    let pixels = within.color.as_slice().iter().map(|color| recorded(color.map(f16::from_f32))).collect();
    let preview = SharePreview { image: Arc::new(ColorImage::new([width, height], pixels)), decibels };
    Ok(Message::SharePreviewed { preview: Some(preview), key })
}
