//! Everything that a person can do. Panels send commands; `control` carries them out.

use crate::app::rooms::charts::model::command::ChartCommand;
use crate::app::rooms::colors::model::display::Display;
use crate::app::rooms::compare::model::command::CompareCommand;
use crate::app::rooms::edits::model::command::EditCommand;
use crate::app::rooms::files::model::command::FileCommand;
use crate::app::rooms::frame::model::command::WindowCommand;
use crate::app::rooms::live::model::command::ViewCommand;
use crate::app::rooms::path::model::PathCommand;
use crate::app::rooms::pixel::model::command::PixelCommand;
use crate::app::rooms::readings::model::command::ReadingCommand;
use crate::app::rooms::report::model::table::{Table, TableForm};
use crate::app::rooms::settings::model::command::SettingsCommand;
use crate::app::rooms::share::model::share::ShareCommand;
use crate::app::rooms::source::model::command::SourceCommand;
use crate::app::rooms::timeline::model::TimeCommand;

/// One wish of the person at the window.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Command {
    /// What concerns files: opening, and the paths that are chosen or typed.
    File(FileCommand),
    /// What concerns the settings.
    Settings(SettingsCommand),
    /// What concerns time.
    Time(TimeCommand),
    /// What concerns the source view.
    Source(SourceCommand),
    /// What concerns the selected pixel.
    Pixel(PixelCommand),
    /// What concerns the camera path.
    Path(PathCommand),
    /// What concerns the comparison of two pictures.
    Compare(CompareCommand),
    /// What concerns sweeps and stress tests.
    Chart(ChartCommand),
    /// What concerns the readings of a capture.
    Reading(ReadingCommand),
    /// What concerns the window around the views.
    Window(WindowCommand),
    Undo,
    Redo,
    /// Prune the whole capture again.
    Recompute,
    /// Stop the work that the line at the bottom names.
    Cancel,
    /// Close the topmost thing: a field, a message; else as `Cancel`.
    Escape,
    /// What concerns the live view's camera and what surrounds its picture.
    View(ViewCommand),
    /// What concerns edits of the samples.
    Edit(EditCommand),
    /// What concerns the dialog of all ways out.
    Share(ShareCommand),
    /// Show colors otherwise in both views.
    Display(Display),
    CopyTable(Table, TableForm),
    /// Write frame times into the program's log, and count them anew.
    LogFrameTimes,
}

impl Command {
    /// Whether it moves the live view by hand, and nothing else.
    pub(crate) fn moves_view(&self) -> bool {
        matches!(self, Self::View(command) if command.moves_view())
    }
}

/// Commands of one frame, in the order in which they are carried out.
pub(crate) type Commands = Vec<Command>;
