//! Everything that a person can do. Panels send commands; `control` carries them out.

use std::path::PathBuf;

use glam::{DVec2, DVec3};

use crate::app::model::camera::OrbitCamera;
use crate::app::model::look::Display;
use crate::app::model::picture::HoleDisplay;
use crate::app::model::purpose::{Purpose, ShareCommand, Table, TableForm};
use crate::app::model::window::{Area, CommandPalette, DockView, HelpPage, Workspace};
use crate::app::rooms::charts::state::axis::ShownAxis;
use crate::app::rooms::charts::state::{Study, StudyChoice};
use crate::app::rooms::compare::state::CompareLook;
use crate::app::rooms::live::state::{KeptView, LiveLook};
use crate::app::rooms::path::CameraPath;
use crate::app::rooms::pixel::state::Spot;
use crate::app::rooms::source::SourceLook;
use crate::app::rooms::timeline::TimeCommand;
use overlook_engine::edits::{Action, EditList, Region, Stroke};
use overlook_engine::settings::Settings;
use overlook_lab::chart::Scale;

/// One wish of the person at the window.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Command {
    File(FileCommand),
    Settings(SettingsCommand),
    Time(TimeCommand),
    Source(SourceCommand),
    Pixel(PixelCommand),
    Path(PathCommand),
    Compare(CompareCommand),
    Chart(ChartCommand),
    Reading(ReadingCommand),
    Window(WindowCommand),
    View(ViewCommand),
    Edit(EditCommand),
    Share(ShareCommand),
    Undo,
    Redo,
    /// Prune the whole capture again.
    Recompute,
    /// Stop the work that the line at the bottom names.
    Cancel,
    /// Close the topmost thing: a field, a message; else as `Cancel`.
    Escape,
    /// Show colors otherwise in both views.
    Display(Display),
    CopyTable(Table, TableForm),
}

impl Command {
    /// Whether it takes the view elsewhere at once. Views that are moved by hand stay under the hand.
    pub(crate) fn is_jump(&self) -> bool {
        use ViewCommand::{Focus, FramePoint, GoToAddress, Home, JumpTo, Kept, LookAlong, Pasted};
        match self {
            Self::Path(PathCommand::GoToKey(_)) => true,
            Self::View(command) => matches!(
                command,
                JumpTo(_)
                    | Home
                    | FramePoint
                    | Focus(_)
                    | LookAlong(_)
                    | GoToAddress(_)
                    | Pasted(_)
                    | Kept(KeptViewCommand::GoTo(_))
            ),
            _ => false,
        }
    }

    /// Whether it moves the live view by hand, and nothing else.
    pub(crate) fn moves_view(&self) -> bool {
        use ViewCommand::{Dolly, Fly, Orbit, Pan};
        matches!(self, Self::View(Orbit(_) | Pan(_) | Dolly(..) | Fly(_)))
    }
}

/// Commands of one frame, in the order in which they are carried out.
pub(crate) type Commands = Vec<Command>;

/// What concerns files: opening, and the paths that are chosen or typed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum FileCommand {
    /// Open something, after a question where something is lost by it.
    Open(Opening),
    /// Ask for a path by the system's dialog.
    AskPath(Purpose),
    /// Save the session where it was saved last, or ask where.
    SaveSession,
    /// What is in the field for typing a path now.
    TypedPath(String),
    /// Take the path in the field.
    TakeTypedPath,
    CloseTypedPath,
    /// Copy the command that prunes what is open without a window.
    CopyCommandLine,
    ForgetRecent,
    /// Cancel the question before closing or opening.
    Stay,
    /// Close or open in spite of what is lost.
    GoOnAnyway,
    /// Close the sentence about the room that comes with the program.
    RoomExplained,
    /// The introduction of the first run was read.
    Introduced,
}

/// What can be opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Opening {
    /// A built-in scene, by its name.
    Demo(String),
    /// The room that comes with the program.
    Room,
    /// A capture or a store, perhaps with the address of a view.
    Path(PathBuf),
    /// What is open, under the other reading (true) or under the one of its files.
    Reading(bool),
}

/// What concerns the settings.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum SettingsCommand {
    /// Give a setting a value.
    Set { path: &'static str, value: toml::Value },
    /// Give every setting its default.
    ResetAll,
    /// Take the settings of a preset.
    Preset(Box<Settings>),
    /// Switch to the other of settings A and B.
    Switch,
    /// Put these settings on.
    Take(Box<Settings>),
    /// Show a setting in its panel, by its path; `None` once it is in view.
    Find(Option<&'static str>),
}

/// What concerns the source view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SourceCommand {
    /// Show another camera on the left.
    Camera(usize),
    /// Let the view look otherwise, but for its camera.
    Look(SourceLook),
    /// Show one camera alone in its color where colors are those of cameras, or all of them.
    Isolate(Option<usize>),
}

/// What can be done to the live view's camera and to what surrounds its picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ViewCommand {
    /// Take a camera whose numbers were changed.
    Camera(Box<OrbitCamera>),
    /// Look at the pivot along a direction in world space.
    LookAlong(DVec3),
    Copy,
    /// Copy the address of the view, which pages and windows open.
    CopyAddress,
    /// Go to the view of an address; opens its scene where another is open.
    GoToAddress(String),
    /// Back to the view before the last jump.
    Back,
    /// To the view that was left by going back.
    Forward,
    Kept(KeptViewCommand),
    /// Ask the system for what was copied.
    Paste,
    /// Take what was copied.
    Pasted(String),
    /// Let the view look otherwise, but for its camera, size and up.
    Look(Box<LiveLook>),
    /// Let a direction of world space be up; `None` takes the one of the capture.
    Up(Option<DVec3>),
    /// Show where it is chosen which way is up.
    FindUp,
    /// Orbit by angles in radians.
    Orbit(DVec2),
    /// Shift the right view by shares of its height.
    Pan(DVec2),
    /// Nearer (below 1) or farther: to what is orbited, or to a point in world space, which stays where it is on the screen.
    Dolly(f64, Option<DVec3>),
    /// Fly right, down, forward, in pivot distances.
    Fly(DVec3),
    /// Look from where a camera stood.
    JumpTo(usize),
    /// Back to the first vantage, and the left picture back to fit.
    Home,
    Holes(HoleDisplay),
    Size([u32; 2]),
    /// Center the live view on the selected pixel.
    FramePoint,
    /// Center the live view on a point in world space, and orbit about it.
    Focus(DVec3),
}

/// What can be done with views that are kept; one is named by its place in the list.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum KeptViewCommand {
    Keep,
    GoTo(usize),
    /// Put a changed list in the place of the one that is there.
    Change(Vec<KeptView>),
}

impl ViewCommand {
    /// The command that lets the view look as a change makes it.
    pub(crate) fn look(look: &LiveLook, change: impl FnOnce(&mut LiveLook)) -> Self {
        let mut look = Box::new(look.clone());
        change(&mut look);
        Self::Look(look)
    }
}

/// What concerns the camera path.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum PathCommand {
    /// Adds the view as a key behind the selected one.
    AddKey,
    GoToKey(usize),
    /// Takes a changed path in the place of the one that is there, perhaps with the key that is changed bit by bit.
    Change(Box<CameraPath>, Option<usize>),
    /// Turn once around the pivot of the view, in place of the keys that are there.
    TurnAround,
}

impl PathCommand {
    /// The command that takes a path as a change makes it.
    pub(crate) fn change(
        path: &CameraPath,
        key: Option<usize>,
        change: impl FnOnce(&mut CameraPath),
    ) -> Self {
        let mut path = Box::new(path.clone());
        change(&mut path);
        Self::Change(path, key)
    }
}

/// What concerns the comparison of two pictures.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum CompareCommand {
    Look(Box<CompareLook>),
    /// Close the pictures of another program, by their folder's number.
    ClosePictures(u64),
}

/// What concerns sweeps, stress tests, tuning and the ranking of cameras.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ChartCommand {
    /// Measure what is chosen.
    Study(Study),
    Axes([ShownAxis; 2]),
    Disturbance(String),
    /// Ask what to measure and for how long; `None` closes the question.
    Ask(Option<Study>),
    Choose(Study, Box<StudyChoice>),
    /// Leave a series of a chart out, by its name, or show it again.
    Toggle(Study, String),
    /// Copy a chart as a picture.
    Copy(Study),
    /// How the sizes of disturbances are spread.
    DialScale(Scale),
    /// Close the ranking of cameras; it is shown again once cameras are ranked.
    CloseRanking,
}

/// What concerns the readings of a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ReadingCommand {
    /// Open or close the comparison of two readings of the capture.
    Compare(bool),
    /// Copy the keys of the manifest that express the other reading.
    CopyKeys,
}

/// What concerns the selected pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PixelCommand {
    /// Point at a pixel, or at nothing.
    Probe(Option<Spot>),
    /// Pin the selected pixel, or unpin it.
    Pin(bool),
    /// Show the selected point in a camera's picture.
    ShowPointIn(usize),
    CopyExplanation,
}

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
    /// Radius of the brush, points.
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
    /// Select nothing, and lay the tool down.
    SelectNothing,
    /// Select what was drawn in a picture, or show the selection while it is being drawn.
    Draw { region: Region, combine: Combine, is_done: bool },
    /// Leave what is under a stroke in a camera's picture out.
    Mask { camera: String, stroke: Stroke },
    /// Edit with other tools.
    Tools(EditTools),
    /// Delete or keep what is selected, or bring it back.
    Act(Action),
    /// Leave cameras out of everything, by their indices, in one edit.
    LeaveOut(Vec<usize>),
    /// Put a changed list in the place of the one that is there, perhaps with the edit whose name is typed.
    List(EditList, Option<usize>),
}

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
