//! Workspaces: arrangements of the views, each for one kind of work; and the areas of the window that are shown.

use super::view::{Area, DockView};

/// An arrangement of the views for one kind of work.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize,
)]
pub(crate) enum Workspace {
    Explore,
    #[default]
    Inspect,
    Compare,
    Measure,
}

impl Workspace {
    /// Every workspace in the order of its keys: its name, and what it is for.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 4] = [
        (
            Self::Explore,
            "Explore",
            "The live view as large as it gets, with its camera and colors beside it.",
        ),
        (
            Self::Inspect,
            "Inspect",
            "A camera's picture beside the live view, and why each pixel was kept or dropped.",
        ),
        (
            Self::Compare,
            "Compare",
            "Two pictures of one place, beside the live view that they are taken from.",
        ),
        (Self::Measure, "Measure", "What each setting costs in size, time and accuracy."),
    ];
}

/// What of the window is shown, and how it is arranged.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct WindowLook {
    pub workspace: Workspace,
    /// The view that fills the window, if one does.
    pub maximized: Option<DockView>,
    /// What is hidden of the workspace.
    pub hidden: Vec<Area>,
    /// Whether the summary bar above the views is hidden.
    pub hides_totals: bool,
    /// The views that can be seen.
    pub in_sight: Vec<DockView>,
}

impl WindowLook {
    /// Whether an area is shown.
    pub(crate) fn shows(&self, area: Area) -> bool {
        !self.hidden.contains(&area)
    }
}
