//! What concerns the window around the views.

use super::view::{Area, DockView};
use super::workspace::Workspace;
use crate::app::rooms::help::model::{CommandPalette, HelpPage};

/// What concerns the window around the views.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum WindowCommand {
    OpenView(DockView),
    ResetLayout,
    Workspace(Workspace),
    /// Let a view fill the window, or put it back where it fills it already; `None` for the view under the pointer.
    Maximize(Option<DockView>),
    ShowArea(Area, bool),
    ShowTotals(bool),
    /// Take the whole screen, or give it back.
    FullScreen,
    Dark(bool),
    /// Everything larger (1), smaller (−1) or as at first (0).
    InterfaceSize(i8),
    Dismiss(u64),
    /// Open, change or close the command palette.
    Palette(Option<CommandPalette>),
    /// Open a page of help, or close it.
    Help(Option<HelpPage>),
}
