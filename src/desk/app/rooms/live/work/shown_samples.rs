//! The samples that the live view shows: those of the cameras that are on, and their values.

use std::sync::Arc;

use crate::app::rooms::live::model::{ColorBy, FrameValues, LiveKey, ShownCameras};
use overlook_engine::error::Result;
use overlook_engine::job::Job;
use overlook_engine::render::output;
use overlook_engine::samples::SampleSet;

/// The samples of the cameras that are on, kept while they stay the same: renderers know samples by where they are. Their values are
/// kept, too.
#[derive(Default)]
pub(crate) struct CameraFilter {
    kept: Option<(Arc<SampleSet>, ShownCameras, Arc<SampleSet>)>,
    values: Option<(LiveKey, Arc<FrameValues>)>,
}

impl CameraFilter {
    /// The samples of the cameras that are on; images of others stay in their place, without samples.
    pub(super) fn of(&mut self, samples: Arc<SampleSet>, cameras: &ShownCameras) -> Arc<SampleSet> {
        if cameras.shows_all() {
            self.kept = None;
            return samples;
        }
        if let Some((of, by, filtered)) = &self.kept
            && Arc::ptr_eq(of, &samples)
            && by == cameras
        {
            return filtered.clone();
        }
        let images = samples.images.iter().map(|image| {
            if cameras.shows(image.camera as usize) {
                image.clone()
            } else {
                Arc::new(image.without_samples())
            }
        });
        let filtered = Arc::new(SampleSet { images: images.collect(), ..(*samples).clone() });
        self.kept = Some((samples, cameras.clone(), filtered.clone()));
        filtered
    }

    /// The values at the frame that colors show, where they do and the view is at rest.
    pub(super) fn values_of(&mut self, key: &LiveKey, job: &Job) -> Result<Option<Arc<FrameValues>>> {
        let channel = key.display.values.channel_of(&key.samples.values).map(|(channel, _)| channel);
        let is_shown = key.color_by == ColorBy::Value && key.quality.is_none() && !key.in_motion;
        let Some(channel) = channel.filter(|_| is_shown) else { return Ok(None) };
        let known = self.values.as_ref().filter(|(of, values)| {
            Arc::ptr_eq(&of.samples, &key.samples)
                && of.vantage.frame == key.vantage.frame
                && of.cameras == key.cameras
                && values.channel == channel
        });
        if let Some((_, values)) = known {
            return Ok(Some(values.clone()));
        }
        let frame = key.vantage.frame;
        let all = match &key.playback {
            None => key.samples.clone(),
            Some(playback) => playback.at(frame, job)?,
        };
        let ascending = output::kept_values(&self.of(all, &key.cameras), frame, channel);
        let values = Arc::new(FrameValues { channel, ascending });
        self.values = Some((key.clone(), values.clone()));
        Ok(Some(values))
    }
}
