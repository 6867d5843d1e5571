//! A setting to measure.

use serde::{Deserialize, Serialize};

use crate::rivals::Rival;
use overlook_engine::settings::{CaptureSettings, RenderSettings, Settings};

/// What is done to the samples after pruning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Thinning {
    /// Nothing.
    None,
    /// As many as the reference keeps, chosen at random.
    Random,
    /// As many as the reference keeps, one for each cube of a grid.
    VoxelGrid,
    /// Tolerances are lowered until at least as many stay as the reference keeps; of these, as many at random.
    Tolerance,
}

/// A setting to measure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// A short name of what is special about it.
    pub label: String,
    /// Everything that can be set.
    pub settings: Settings,
    /// What is done after pruning.
    pub thinning: Thinning,
    /// Names of the cameras that a model is made of; `None` for all.
    pub cameras: Option<Vec<String>>,
    /// A method of others that is measured instead; of the settings, it uses only the filling of holes.
    pub rival: Option<Rival>,
}

impl Trial {
    /// Settings as they are, on all cameras.
    #[must_use]
    pub fn new(label: impl Into<String>, settings: Settings) -> Self {
        Self { label: label.into(), settings, thinning: Thinning::None, cameras: None, rival: None }
    }

    /// What the trial's samples depend on: all but the painting.
    pub(super) fn model_key(&self) -> ModelKey {
        let settings = Settings {
            render: RenderSettings::default(),
            capture: CaptureSettings::default(),
            ..self.settings.clone()
        };
        (settings, self.thinning, self.cameras.clone())
    }
}

/// See [`Trial::model_key`].
pub(super) type ModelKey = (Settings, Thinning, Option<Vec<String>>);
