//! How colors and values are shown in both views.

pub(crate) mod ui;
pub(crate) mod work;

use crate::app::model::scene::Content;
use crate::app::model::state::State;
use overlook_engine::capture::ValueChannel;

impl State {
    /// The scalar values of what is open; none as a rule.
    pub(crate) fn value_channels(&self) -> &[ValueChannel] {
        match self.content() {
            Some(Content::Store { samples, .. }) => &samples.values,
            Some(Content::Capture { capture, .. }) => capture.value_channels(),
            None => &[],
        }
    }
}
