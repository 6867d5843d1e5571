//! What the open scene's comparison is made from now.

use super::comparison::CompareKey;
use super::figure::ComparisonFigure;
use crate::app::model::Same;
use crate::app::model::state::State;
use crate::app::model::undo::SettingsSlot;
use std::sync::Arc;

impl State {
    /// What a figure of the comparison shows; `None` where there is none, or where its sides cannot be compared.
    pub(crate) fn compared_figure(&self) -> Option<ComparisonFigure> {
        let compared = self.doc.compared.as_ref().filter(|_| self.doc.compare_error.is_none())?;
        Some(ComparisonFigure::of(compared, &self.inspector.compare, self.dark))
    }

    /// At the viewpoint, and with the samples, of the last live picture; `None` without one.
    pub(crate) fn compare_key(&self) -> Option<CompareKey> {
        let (scene, shown) = (self.doc.scene.as_ref()?, self.doc.live_shown.as_ref()?);
        let (history, now) = (&self.inspector.history, &self.settings);
        Some(CompareKey {
            scene: scene.clone(),
            choice: self.inspector.compare.choice,
            vantage: shown.key.vantage.clone(),
            // Of a store played from disk only the picture knows the samples.
            samples: Same(shown.picture.samples.clone()),
            whole: self.current_whole().is_some_and(|whole| Arc::ptr_eq(whole, &shown.picture.samples)),
            scan: self.doc.scan.clone().map(Same),
            settings: [
                now.clone(),
                history.of(SettingsSlot::A, now).clone(),
                history.of(SettingsSlot::B, now).clone(),
            ],
            pictures: self.doc.pictures.clone(),
            dark: self.dark,
        })
    }
}
