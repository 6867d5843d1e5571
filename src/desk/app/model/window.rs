//! What the window around the pictures speaks of: views, workspaces, notices, and the pages of help.

use std::time::Instant;

use crate::app::views::views;

macro_rules! dock_view {
    ($($view:ident, $name:literal, $help:literal, $($ui:ident)::+;)*) => {
        /// Something to look at.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
        pub(crate) enum DockView {
            $($view,)*
        }

        impl DockView {
            /// Every view in the order of the menu: its name on its tab, and what it shows.
            pub(crate) const ALL: [(Self, &'static str, &'static str); [$($name),*].len()] =
                [$((Self::$view, $name, $help)),*];
        }
    };
}
views!(dock_view);

impl DockView {
    /// Its name on its tab, and what it shows.
    pub(crate) fn name_and_help(self) -> (&'static str, &'static str) {
        Self::ALL.iter().find(|(of, ..)| *of == self).map_or(("", ""), |(_, name, help)| (*name, *help))
    }

    /// The area that it is hidden and shown with; `None` for those in the middle.
    pub(crate) fn area(self) -> Option<Area> {
        match self {
            Self::Source => Some(Area::Source),
            Self::Live | Self::Compare | Self::Tradeoff | Self::Stability | Self::Tuning => None,
            Self::Thresholds | Self::Report | Self::View | Self::Color | Self::Edits => Some(Area::Side),
            _ => Some(Area::Lower),
        }
    }

    /// The view beside which it opens.
    pub(crate) fn neighbor(self) -> Self {
        match self.area() {
            Some(Area::Source) | None => Self::Live,
            Some(Area::Side) => Self::Thresholds,
            Some(Area::Lower) => Self::Pixel,
        }
    }
}

/// Views that are hidden and shown together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
pub(crate) enum Area {
    /// The picture of a camera.
    Source,
    /// Settings and the report.
    Side,
    /// The views about pixels, cameras, time and memory.
    Lower,
}

impl Area {
    /// Every area in the order of the menu: its name, and the keys that hide and show it.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 3] = [
        (Self::Source, "Source picture", ""),
        (Self::Side, "Side panel", "Ctrl+B"),
        (Self::Lower, "Lower panel", "Ctrl+J"),
    ];
}

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
        (Self::Measure, "Benchmark", "What each setting costs in size, time and accuracy."),
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

/// How loud a message is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoticeKind {
    Error,
    Warning,
    Done,
}

/// A line of the log.
pub(crate) struct LogLine {
    pub at: Instant,
    pub kind: NoticeKind,
    pub text: String,
}

/// One line for many.
pub(crate) fn and_others(first: &str, others: usize) -> String {
    match others {
        0 => first.to_owned(),
        others => format!("{first} (and {others} more places: see Help > Log)"),
    }
}

/// A page of help.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HelpPage {
    /// The guide, or a page that it leads to: an index into those.
    Guide(usize),
    /// What a capture is known by.
    Sources,
    Shortcuts,
    /// What happened, in order.
    Log,
    About,
}

/// What is typed into the palette, and which entry is chosen.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct CommandPalette {
    pub text: String,
    /// Index of the chosen entry among those that match.
    pub chosen: usize,
}

/// Keys and mouse actions, each with what it does, for the help: in groups with a heading, an empty line between them.
pub(crate) const SHORTCUTS: &str = "\
Anywhere
Ctrl + P: find any command by name
?: keyboard and mouse shortcuts
Ctrl + O: open a file
Ctrl + S, Ctrl + E: save the session, share
Ctrl + Z, Ctrl + Y: undo, redo
Shift + Space: maximize the view under the pointer, or restore it
F11: full screen
Ctrl + 1 – 4: workspaces
Ctrl + B, Ctrl + J: hide or show the side panel, the lower panel
Ctrl + +, −, 0: interface size: larger, smaller, normal
Esc: close a message, cancel, or unpin the pixel
Ctrl + Q: quit

Time and cameras
Space: play or pause
, and . or the arrows: step back and forward; arrows with Shift ten frames
Ctrl + Home, Ctrl + End: first and last frame
I, O, Shift + I: loop from here, loop to here, loop over all frames
Shift + M: mark this frame, or take its marker away
Ctrl + arrows: previous and next marker
1 – 9: show a camera
Shift + 1 – 9: view from a camera
K: add a key to the camera path

Pixel
Click: pin the pixel under the pointer
P: pin or unpin the pixel
F: center view on what is selected for edits, or on the pixel
Ctrl + Shift + C, F: copy the explanation, or a figure
Right click: copy a picture, copy or save a figure of it

Live view
Drag: orbit
Right drag, middle drag, Shift + drag: pan
Wheel: zoom to the pointer
W A S D, Q E: fly, down and up; faster with Shift
[ and ]: fly slower, faster
Alt + X, Y, Z: view along an axis; from the other side with Shift
M: measure a distance between two points
Ctrl + C, V, D: copy the view, go to a copied one, keep it
Double-click: orbit about a point; beside all surfaces as Home
Home: reset to the start view
H: hatch holes, or fill them

Edits
R, L, B, T, C: select: rectangle, lasso, brush, surface, color
[ and ], Shift + B: size of the brush, mask
G, Shift + G, Ctrl + I: grow, shrink, invert
Delete: delete what is selected

Source and Compare
Wheel: zoom to the pointer
Drag: pan; in a wipe, move the line
Double-click: fit the picture
X: show the other side of a comparison

Cameras
Click on a picture: show the camera in the source view
Click on a camera in the live view: the same; double-click and right-click too
Double-click: view from the camera";
