//! The CPU renderer: the reference.

use std::sync::Arc;

use super::{Picture, RenderStats, Vantage};
use crate::error::Result;
use crate::job::Job;
use crate::preprocess::SampleSet;
use crate::settings::RenderSettings;

/// Renders vantages, and keeps what may be used again while the vantage is still.
#[derive(Debug, Default)]
pub struct CpuRenderer {}

impl CpuRenderer {
    /// A renderer with nothing cached.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Paints the samples of the vantage's frame.
    ///
    /// # Errors
    /// `Cancelled`; `Invalid` where the frame does not exist or the picture would be absurdly large.
    pub fn render(
        &mut self,
        samples: &Arc<SampleSet>,
        vantage: &Vantage,
        settings: &RenderSettings,
        job: &Job,
    ) -> Result<(Picture, RenderStats)> {
        let _ = (samples, vantage, settings, job);
        todo!()
    }
}
