//! What a person does to edits, and with which tools.

use overlook_engine::edits::{Action, EditList, Region, Stroke};

/// How a region that is chosen joins what is selected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Combine {
    #[default]
    Replace,
    Add,
    Subtract,
    Intersect,
}

impl Combine {
    /// Every choice in the order of the panel: its name, and what it does.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 4] = [
        (Self::Replace, "New", "What is chosen next is the selection."),
        (Self::Add, "Add", "What is chosen next is selected too."),
        (Self::Subtract, "Subtract", "What is chosen next is selected no longer."),
        (Self::Intersect, "Intersect", "Of what is selected, what is also chosen next stays selected."),
    ];
}

/// When an edit acts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum EditTime {
    #[default]
    AllFrames,
    /// All frames of the samples that hold at the frame that is shown.
    Spans,
    ThisFrame,
    /// From a frame to another one.
    Range,
}

impl EditTime {
    /// Every choice in the order of the panel: its name, and what it means.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 4] = [
        (Self::AllFrames, "All frames", "The edit acts at every frame."),
        (
            Self::Spans,
            "Spans",
            "The edit takes the samples of the frame that is shown, at all frames for which each of them is stored.",
        ),
        (
            Self::ThisFrame,
            "This frame",
            "The edit acts at the frame that is shown; other frames keep what they show.",
        ),
        (Self::Range, "Range", "The edit acts from one frame to another; other frames keep what they show."),
    ];
}

/// How far behind what a picture shows a drawn selection reaches.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum DrawnDepth {
    #[default]
    Seen,
    Through,
}

impl DrawnDepth {
    /// Both choices in the order of the panel: the name, and what it means.
    pub(crate) const ALL: [(Self, &'static str, &'static str); 2] = [
        (
            Self::Seen,
            "What is seen",
            "Drawing selects what the picture shows there, in the samples of all cameras, and nothing behind it.",
        ),
        (Self::Through, "All behind", "Drawing selects all that lies there, at any depth."),
    ];
}

/// A tool that is used in pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EditTool {
    Rectangle,
    Lasso,
    Brush,
    /// Selects the surface that is clicked on.
    Surface,
    /// Selects all that has about the color that is clicked on.
    Color,
    /// A brush in source pictures that leaves their pixels out of pruning.
    Mask,
}

impl EditTool {
    /// Every tool in the order of the panel: its name, its key, and what it does.
    pub(crate) const ALL: [(Self, &'static str, &'static str, &'static str); 6] = [
        (
            Self::Rectangle,
            "Rectangle",
            "R",
            "Drag a rectangle in the live view or in a source picture. With Shift it is added, with Alt taken away.",
        ),
        (
            Self::Lasso,
            "Lasso",
            "L",
            "Draw around something in the live view or in a source picture. With Shift it is added, with Alt taken away.",
        ),
        (
            Self::Brush,
            "Brush",
            "B",
            "Brush over something in the live view or in a source picture. With Shift it is added, with Alt taken away.",
        ),
        (
            Self::Surface,
            "Same surface",
            "T",
            "Click on a surface: all of it, in the samples of all cameras, as far as its edges. With Shift it is added, with Alt taken away.",
        ),
        (
            Self::Color,
            "Same color",
            "C",
            "Click on a color: all samples that have about this color, wherever they are. With Shift it is added, with Alt taken away.",
        ),
        (
            Self::Mask,
            "Mask",
            "Shift+B",
            "Brush over pixels of a source picture that are not to be used: that camera is pruned without them, and others show what they showed.",
        ),
    ];

    /// Whether it draws with a round brush.
    pub(crate) fn has_radius(self) -> bool {
        matches!(self, Self::Brush | Self::Mask)
    }
}

/// What a person edits with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct EditTools {
    pub combine: Combine,
    pub depth: DrawnDepth,
    pub tool: Option<EditTool>,
    /// Of the brush, points.
    pub radius: f32,
    /// By how many footprints the selection is grown and shrunk.
    pub grow_by: f64,
    pub time: EditTime,
    /// The frames of [`EditTime::Range`] and of masks, by their numbers; `None` for all.
    pub range: Option<[i64; 2]>,
}

impl EditTools {
    /// With a tool taken up, or laid down where it is in use.
    pub(crate) fn with(self, tool: EditTool) -> Self {
        Self { tool: (self.tool != Some(tool)).then_some(tool), ..self }
    }
}

impl Default for EditTools {
    fn default() -> Self {
        Self {
            combine: Combine::default(),
            depth: DrawnDepth::default(),
            tool: None,
            radius: 16.0,
            grow_by: 2.0,
            time: EditTime::default(),
            range: None,
        }
    }
}

/// What a person does to edits.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum EditCommand {
    /// Select a region, as [`Combine`] says.
    Select(Region),
    /// Put another selection in the place of the one that is there.
    Reshape(Option<Region>),
    SelectNothing,
    /// Select what was drawn in a picture, or show what that would be as long as it is being drawn.
    Draw {
        region: Region,
        combine: Combine,
        is_done: bool,
    },
    /// Leave what is under a stroke in a camera's picture out.
    Mask {
        camera: String,
        stroke: Stroke,
    },
    /// Edit with other tools.
    Tools(EditTools),
    /// Delete or keep what is selected, or bring it back.
    Act(Action),
    /// Leave cameras out of everything, by their indices, in one edit.
    LeaveOut(Vec<usize>),
    /// Put a changed list in the place of the one that is there, perhaps with the edit whose name is typed.
    List(EditList, Option<usize>),
}
