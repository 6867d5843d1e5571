//! The inspector: what the window knows beyond its pictures, whatever is open.

use std::collections::VecDeque;
use std::time::Instant;

use crate::app::model::frame_timer::Meter;
use crate::app::model::undo::History;
use crate::app::rooms::compare::model::comparison::CompareLook;
use crate::app::rooms::frame::model::notice::{LogLine, NoticeKind};
use crate::app::rooms::help::model::{CommandPalette, HelpPage};
use crate::app::rooms::settings::model::presets::OwnPreset;

/// Entries the log keeps.
const LOG: usize = 500;

/// What stands between the person and closing the window.
#[derive(Clone, Copy, Default)]
pub(crate) struct Closing {
    /// Whether the question before closing is open.
    pub asks: bool,
    /// Whether the window closes without another question.
    pub anyway: bool,
    /// Whether a file, pictures or a video are being written.
    pub writing: bool,
}

/// What the inspector knows.
#[derive(Default)]
pub(crate) struct Inspector {
    pub history: History,
    /// Presets of the person.
    pub presets: Vec<OwnPreset>,
    /// What a new preset is named so far, while it is named.
    pub naming: Option<String>,
    pub compare: CompareLook,
    /// The command palette, while it is open.
    pub palette: Option<CommandPalette>,
    /// The page of help that is open.
    pub help: Option<HelpPage>,
    /// The setting to scroll to, by its path.
    pub find_setting: Option<&'static str>,
    /// The adapter that draws the window; `None` without one.
    pub graphics: Option<String>,
    /// Bytes that the window's device has allocated on it when *About* was opened, where its driver says.
    pub graphics_memory: Option<u64>,
    /// What the program held in memory when it was asked for, by part, bytes.
    pub held_memory: Vec<(&'static str, u64)>,
    /// Whether the introduction of the first run was read.
    pub introduced: bool,
    /// Whether the sentence about the room that comes with the program was read.
    pub room_explained: bool,
    /// What stands between the person and closing the window.
    pub closing: Closing,
    pub log: VecDeque<LogLine>,
    pub meter: Meter,
}

impl Inspector {
    /// Adds a line to the log.
    pub(crate) fn log(&mut self, kind: NoticeKind, text: String) {
        if self.log.len() == LOG {
            self.log.pop_front();
        }
        self.log.push_back(LogLine { at: Instant::now(), kind, text });
    }
}
