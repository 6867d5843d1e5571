//! Settings from a Python dictionary: `{"pruning.depth_tolerance": 2, "render.kernel": "block"}`.

use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict};

use super::exceptions::to_exception;
use overlook_engine::settings::Settings;

/// These settings over `base`, named as `overlook settings` names them.
///
/// # Errors
/// `Error` naming the setting that is unknown or out of range.
pub(super) fn settings_over(base: Settings, settings: Option<&Bound<'_, PyDict>>) -> PyResult<Settings> {
    let mut all = base;
    for (name, value) in settings.into_iter().flatten() {
        // Python writes True where the settings write true.
        let text = match value.cast::<PyBool>() {
            Ok(switch) => switch.is_true().to_string(),
            Err(_) => value.str()?.to_string(),
        };
        all.set_text(&format!("{}={text}", name.str()?)).map_err(|error| to_exception(&error))?;
    }
    Ok(all)
}
