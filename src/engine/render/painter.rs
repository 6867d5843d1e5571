//! Who painted a picture.

use super::gpu::GpuRenderer;
use crate::settings::Backend;

/// What painted a picture.
#[serde_with::skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Eq, Hash, serde::Serialize)]
pub struct Painter {
    /// `Cpu` or `Gpu`.
    pub backend: Backend,
    /// Name of the graphics adapter, where one painted.
    pub adapter: Option<String>,
}

impl Painter {
    /// The processor.
    #[must_use]
    pub fn cpu() -> Self {
        Self { backend: Backend::Cpu, adapter: None }
    }

    /// A graphics adapter.
    pub(super) fn gpu(gpu: &GpuRenderer) -> Self {
        Self { backend: Backend::Gpu, adapter: Some(gpu.adapter_name().to_owned()) }
    }
}

impl std::fmt::Display for Painter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match &self.adapter {
            Some(adapter) => write!(f, "GPU ({adapter})"),
            None => write!(f, "CPU"),
        }
    }
}
