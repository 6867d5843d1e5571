//! The samples that the live view shows: those of the cameras that are on.

use std::sync::Arc;

use crate::app::model::look::ShownCameras;
use overlook_engine::samples::SampleSet;

/// The samples of the cameras that are on, kept while they stay the same: renderers know samples by where they are.
#[derive(Default)]
pub(crate) struct CameraFilter {
    kept: Option<(Arc<SampleSet>, ShownCameras, Arc<SampleSet>)>,
}

impl CameraFilter {
    /// The samples of the cameras that are on; images of others stay in their place, without samples.
    pub(crate) fn of(&mut self, samples: Arc<SampleSet>, cameras: &ShownCameras) -> Arc<SampleSet> {
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
}
