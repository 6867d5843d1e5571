//! Settings from a Python dictionary, `{"pruning.depth_tolerance": 2, "render.kernel": "block"}`; edit lists by path or as text.

use std::path::PathBuf;

use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict};

use super::exceptions::to_exception;
use overlook_engine::edits::EditList;
use overlook_engine::error::Result;
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

/// The list at a path, or the text of one, which has lines; empty without any.
///
/// # Errors
/// As [`EditList::load`].
pub(super) fn edit_list(edits: Option<PathBuf>) -> Result<EditList> {
    let Some(edits) = edits else { return Ok(EditList::default()) };
    match edits.to_str().filter(|text| text.contains('\n')) {
        Some(text) => EditList::from_toml(text, "edits"),
        None => EditList::load(&edits),
    }
}
