//! Whether the files of a capture are read as they are meant, and another reading beside it.

mod control;
pub(crate) mod state;
pub(crate) mod ui;
pub(crate) mod work;

use crate::app::model::scene::SceneSource;
use crate::app::model::state::State;
use overlook_engine::capture::conventions::ConventionVerdict;

impl State {
    /// Why two readings cannot be compared; `None` where they can.
    pub(crate) fn why_no_readings(&self) -> Option<String> {
        let readings = &self.doc.readings;
        let Some(scene) = &self.doc.scene else { return Some("Open a capture first.".to_owned()) };
        if scene.capture().is_none() {
            return Some("A store holds no source frames that could be read otherwise.".to_owned());
        }
        if matches!(scene.origin, SceneSource::Demo(_)) {
            return Some("A built-in scene is read as it was made.".to_owned());
        }
        if let Some(trouble) = &readings.trouble {
            return Some(trouble.clone());
        }
        match readings.finding.as_ref().map(|finding| &finding.verdict) {
            None => Some("How well the views agree is not known yet.".to_owned()),
            Some(ConventionVerdict::Stands { .. }) => {
                Some("The views agree as the capture is read; no other reading fits better.".to_owned())
            }
            Some(ConventionVerdict::Unknown { why }) => Some(format!("The views cannot tell: {why}.")),
            Some(ConventionVerdict::Other(_)) => None,
        }
    }
}
