//! What follows on a painted picture, on the adapter: holes that hide a surface are found, and holes are filled.
//!
//! ```text
//! samples ─ seen: carry ─ free depths, once a frame ─────┐
//!         ─ sky: sum ─ halve ─ fill, once a frame ───────┤
//! picture ─ square ranges ─ lines of sight ─ enclosed ─ open holes ─ rims ─ holes ─ sky ─ ray masks ─ open sky      free space
//!         ─ kinds ─ ray masks ─ pull, once a level ─ fill ─ around ─ put over ─▶ picture                                   fill
//! ```
//!
//! What differs from the CPU: stages run over all pixels, and the first ones tell by counts on the adapter what later ones may skip,
//! because the CPU does not wait for them. Rays across holes pass over 32 pixels at a step, by masks of sources, instead of being
//! swept.

mod painted;
mod planes;
mod seen;
mod sky;
mod stages;

use std::sync::Arc;

use super::commands::Commands;
use super::context::Context;
use super::layout::GpuCellView;
use super::pipelines::Pipelines;
use crate::error::Result;
use crate::render::finish::{has_sky, tests_free_space};
use crate::samples::SampleSet;
use crate::settings::Fill;
use painted::{Known, Recording};
use planes::{FinishLayout, FinishPlanes};
use seen::SeenCells;
use sky::Sky;
use stages::FinishStages;

pub(super) use painted::Painted;
#[cfg(test)]
pub(super) use sky::SKY_SIDE;

/// Finishes pictures on the adapter, and keeps what cameras saw at the last frame there.
#[derive(Debug)]
pub(super) struct CardFinisher {
    stages: FinishStages,
    seen: SeenCells,
    sky: Sky,
    planes: Option<FinishPlanes>,
    /// What was seen according to the images of the background, and of the frame.
    background: Option<SeenImages>,
    frame: Option<SeenImages>,
}

/// The images with something found.
#[derive(Debug)]
struct SeenImages {
    samples: Arc<SampleSet>,
    images: Vec<usize>,
}

impl SeenImages {
    /// Whether these are the images of such samples.
    fn is_of(&self, samples: &SampleSet, images: &[usize]) -> bool {
        self.images == images && self.samples.shares(samples, images)
    }
}

impl CardFinisher {
    /// Compiles the stages.
    pub(super) fn new(context: &Context, pipelines: &Pipelines) -> Self {
        Self {
            stages: FinishStages::new(context),
            seen: SeenCells::new(context, pipelines),
            sky: Sky::new(context, pipelines),
            planes: None,
            background: None,
            frame: None,
        }
    }

    /// Forgets what was seen, after a failure that may have left it unfinished.
    pub(super) fn forget(&mut self) {
        self.background = None;
        self.frame = None;
    }

    /// Forgets what was seen and its buffers, after a failure that may have left them unusable.
    pub(super) fn drop_buffers(&mut self) {
        self.forget();
        self.planes = None;
        self.seen.drop_buffers();
        self.sky.drop_buffers();
    }

    /// Records the stages that the settings demand. Where commands are not submitted after all, [`CardFinisher::forget`] must be called.
    ///
    /// # Errors
    /// `Gpu` where what was seen, or the picture, is more than the adapter takes.
    pub(super) fn record(
        &mut self,
        context: &Context,
        commands: &mut Commands<'_>,
        painted: Painted<'_>,
    ) -> Result<()> {
        let Painted { samples, frame, settings, target, .. } = painted;
        let tests_lines = tests_free_space(settings) && has_sky(samples, &frame.images);
        let fills = settings.fill != Fill::None;
        if !tests_lines && !fills {
            return Ok(());
        }
        let (width, height) = target.picture_size();
        let has_coverage = target.layout.has_coverage();
        let layout = FinishLayout { width, height, tests_lines, fills, has_coverage };
        let planes = match self.planes.take().filter(|planes| planes.layout == layout) {
            Some(planes) => planes,
            None => FinishPlanes::new(context, layout)?,
        };
        let seeing = Recording { context, commands, painted };
        let views = if tests_lines { self.see(seeing)? } else { Vec::new() };
        let (seen, sky) = (&self.seen, &self.sky);
        let known = tests_lines.then(|| (seen.free_depths(), sky.environment()));
        let group = planes.bind(context, &self.stages.layout, painted, &views, known)?;
        if tests_lines {
            self.stages.mark_holes(commands, &planes, &group);
        }
        if fills {
            self.stages.fill(commands, &planes, &group);
        }
        self.planes = Some(planes);
        Ok(())
    }

    /// Finds what cameras saw, as far as it is not known from the last frame. Returns the views of the cameras asked.
    fn see(&mut self, mut recording: Recording<'_, '_>) -> Result<Vec<GpuCellView>> {
        let Painted { samples, frame, .. } = recording.painted;
        let background_images = &frame.images[..frame.background_images];
        let is_known = |seen: &Option<SeenImages>, images: &[usize]| {
            seen.as_ref().is_some_and(|seen| seen.is_of(samples, images))
        };
        let background = is_known(&self.background, background_images);
        let known = Known { background, frame: background && is_known(&self.frame, &frame.images) };
        self.sky.record(&mut recording, known)?;
        let views = self.seen.record(&mut recording, known)?;
        let seen = |images: &[usize]| Some(SeenImages { samples: samples.clone(), images: images.to_vec() });
        (self.background, self.frame) = (seen(background_images), seen(&frame.images));
        Ok(views)
    }
}
