//! What paints, in one place: a further backend is one more [`Backend`] and one more [`Paint`].

use std::sync::Arc;

use serde::Serialize;

use crate::error::Result;
use crate::job::Job;
use crate::preprocess::SampleSet;
use crate::render::{AdapterChoice, CpuRenderer, GpuRenderer, Picture, Vantage};
use crate::settings::{self, RenderSettings};

/// What paints.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Backend {
    /// The processor's threads.
    Cpu,
    /// A graphics adapter.
    Gpu,
}

impl Backend {
    /// The backends to measure. The CPU always is; besides, the adapter that is asked for by name, or with `auto` a graphics
    /// card where there is one.
    ///
    /// # Errors
    /// `Gpu` where an adapter is asked for by name and there is none.
    pub fn wanted(choice: settings::Backend) -> Result<Vec<Self>> {
        let mut wanted = vec![Self::Cpu];
        let has_adapter = match choice {
            settings::Backend::Cpu => false,
            settings::Backend::Auto => GpuRenderer::new(AdapterChoice::Hardware).is_ok(),
            settings::Backend::Gpu => GpuRenderer::new(AdapterChoice::Any).map(|_| true)?,
        };
        wanted.extend(has_adapter.then_some(Self::Gpu));
        Ok(wanted)
    }

    /// The name in stages and JSON.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Cpu => "cpu",
            Self::Gpu => "gpu",
        }
    }

    /// Something that paints and has nothing cached.
    ///
    /// # Errors
    /// Whatever keeps the backend from starting.
    pub fn start(self) -> Result<Box<dyn Paint>> {
        match self {
            Self::Cpu => Ok(Box::new(CpuRenderer::new())),
            Self::Gpu => Ok(Box::new(GpuRenderer::new(AdapterChoice::Any)?)),
        }
    }
}

/// A painted picture and what is known about it.
#[derive(Debug)]
pub struct Painted {
    /// Pixels that no sample reached.
    pub holes: u64,
    /// Whether the samples that outlast the frame were taken from a cache.
    pub background_reused: bool,
    /// Held so that giving its memory back is not measured.
    pub picture: Arc<Picture>,
}

/// Paints one vantage after another and may keep what helps with the next.
pub trait Paint {
    /// Paints the set's samples at the vantage's frame.
    ///
    /// # Errors
    /// `Cancelled`, and whatever painting gives.
    fn paint(
        &mut self,
        samples: &Arc<SampleSet>,
        vantage: &Vantage,
        settings: &RenderSettings,
        job: &Job,
    ) -> Result<Painted>;
}

impl Paint for CpuRenderer {
    fn paint(
        &mut self,
        samples: &Arc<SampleSet>,
        vantage: &Vantage,
        settings: &RenderSettings,
        job: &Job,
    ) -> Result<Painted> {
        let (picture, stats) = self.render(samples, vantage, settings, job)?;
        Ok(Painted { holes: stats.holes, background_reused: stats.background_reused, picture })
    }
}

impl Paint for GpuRenderer {
    fn paint(
        &mut self,
        samples: &Arc<SampleSet>,
        vantage: &Vantage,
        settings: &RenderSettings,
        job: &Job,
    ) -> Result<Painted> {
        let (picture, stats) = self.render(samples, vantage, settings, job)?;
        Ok(Painted { holes: stats.holes, background_reused: stats.background_reused, picture })
    }
}
