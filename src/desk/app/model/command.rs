//! Everything that a person can do. Panels send commands; `control` carries them out.

use std::path::PathBuf;

use glam::{DVec2, DVec3};

use crate::app::rooms::charts::model::axis::ShownAxis;
use crate::app::rooms::charts::model::charts::ChartCommand;
use crate::app::rooms::charts::model::study::Study;
use crate::app::rooms::colors::model::display::Display;
use crate::app::rooms::compare::model::comparison::CompareLook;
use crate::app::rooms::edits::model::command::EditCommand;
use crate::app::rooms::files::model::purpose::Purpose;
use crate::app::rooms::frame::model::view::{Area, DockView};
use crate::app::rooms::frame::model::workspace::Workspace;
use crate::app::rooms::live::model::picture::{ColorBy, HoleDisplay};
use crate::app::rooms::live::model::view_look::ViewCommand;
use crate::app::rooms::pixel::model::pixel::Spot;
use crate::app::rooms::report::model::table::{Table, TableForm};
use crate::app::rooms::share::model::share::ShareCommand;
use crate::app::rooms::source::model::picture::Overlay;
use crate::app::rooms::source::model::picture_zoom::PictureZoom;
use overlook_engine::settings::Settings;

/// One wish of the person at the window.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Command {
    OpenDemo(String),
    /// Open the room that comes with the program.
    OpenRoom,
    OpenPath(PathBuf),
    /// Ask for a path by the system's dialog.
    AskPath(Purpose),
    /// Show the field for typing a path.
    TypePath(Purpose),
    /// What is in the field now.
    TypedPath(String),
    /// Take the path in the field.
    TakeTypedPath,
    CloseTypedPath,
    ForgetRecent,
    Set {
        path: &'static str,
        value: toml::Value,
    },
    Reset(&'static str),
    ResetAll,
    /// Take the settings of a built-in preset, by its index.
    Preset(usize),
    /// Take the settings of the person's own preset, by its index.
    OwnPreset(usize),
    /// What a new preset is named so far; `None` closes the field.
    NamePreset(Option<String>),
    SavePreset(String),
    /// Forget the person's own preset of an index.
    RemovePreset(usize),
    Undo,
    Redo,
    /// Switch to the other of settings A and B.
    SwitchSettings,
    /// Prune the whole capture again.
    Recompute,
    /// Stop the work that the line at the bottom names.
    Cancel,
    /// Close the topmost thing: a field, a message; else as `Cancel`.
    Escape,
    Frame(usize),
    /// Step forward or back, around the ends.
    Step(i64),
    TogglePlay,
    FramesPerSecond(f32),
    /// Show another camera on the left.
    SourceCamera(usize),
    Overlay(Overlay),
    /// Compare sampling rates with this camera, or the best other.
    Against(Option<usize>),
    SourceZoom(PictureZoom),
    /// Orbit by angles in radians.
    Orbit(DVec2),
    /// Shift the right view by shares of its height.
    Pan(DVec2),
    /// Nearer (below 1) or farther.
    Dolly(f64),
    /// Nearer to a point (below 1) or farther from it, which stays where it is on the screen.
    DollyTo {
        factor: f64,
        point_in_world: DVec3,
    },
    /// Fly right, down, forward, in pivot distances.
    Fly(DVec3),
    /// Look from where a camera stood.
    JumpTo(usize),
    /// Back to the first vantage, and the left picture back to fit.
    Home,
    ColorBy(ColorBy),
    Holes(HoleDisplay),
    ShowCameras(bool),
    LiveSize([u32; 2]),
    Dark(bool),
    OpenView(DockView),
    ResetLayout,
    Workspace(Workspace),
    /// What concerns the live view's camera and what surrounds its picture.
    View(ViewCommand),
    /// What concerns edits of the samples.
    Edit(EditCommand),
    /// What concerns the dialog of all ways out.
    Share(ShareCommand),
    /// Show colors otherwise in both views.
    Display(Display),
    /// The area of the live view and its legend in the window, points.
    LiveArea(egui::Rect),
    /// First and last frame of what is played; all frames by `None`.
    LoopRange(Option<[usize; 2]>),
    /// Whether playback turns back at either end.
    PingPong(bool),
    /// Mark this frame, or take its marker away.
    ToggleMarker,
    /// Go to the next marker (true), or to the one before.
    ToMarker(bool),
    /// Take every key out of the camera path.
    ClearPath,
    /// Let a view fill the window, or put it back where it fills it already; `None` for the view under the pointer.
    Maximize(Option<DockView>),
    ShowArea(Area, bool),
    ShowTotals(bool),
    /// Take the whole screen, or give it back.
    FullScreen,
    /// Point at a pixel, or at nothing.
    Probe(Option<Spot>),
    /// Pin the selected pixel, or unpin it.
    Pin(bool),
    /// Show the selected point in a camera's picture.
    ShowPointIn(usize),
    Compare(Box<CompareLook>),
    /// Close the pictures of another program, by their folder's number.
    ClosePictures(u64),
    CopyExplanation,
    CopyPicture,
    /// Center the live view on the selected pixel.
    FramePoint,
    /// Open, change or close the command palette.
    Palette(Option<CommandPalette>),
    /// Open a page of help, or close it.
    Help(Option<HelpPage>),
    /// Show one camera alone in its color where colors are those of cameras, or all of them.
    Isolate(Option<usize>),
    CopyTable(Table, TableForm),
    /// Everything larger (1), smaller (−1) or as at first (0).
    InterfaceSize(i8),
    /// Show a setting in its panel, by its path.
    FindSetting(&'static str),
    /// It is in view.
    FoundSetting,
    /// The introduction of the first run was read.
    Introduced,
    /// Close the sentence about the room that comes with the program.
    RoomExplained,
    /// Cancel the question before closing or opening.
    Stay,
    /// Close or open in spite of what is lost.
    GoOnAnyway,
    AddKey,
    RemoveKey(usize),
    /// Set a key of the camera path to the current view.
    ReplaceKey(usize),
    GoToKey(usize),
    /// Moves a key of the path to another frame, no farther than its neighbors.
    MoveKey {
        index: usize,
        frame: usize,
    },
    /// Pictures from one key of the camera path to the next.
    PicturesPerLeg(usize),
    PictureSize([u32; 2]),
    /// Play the camera path from its beginning, or stop.
    PlayPath(bool),
    Study(Study),
    Chart(ChartCommand),
    ChartAxes([ShownAxis; 2]),
    Disturbance(String),
    /// Put these settings on.
    TakeSettings(Box<Settings>),
    /// Write frame times into the program's log, and count them anew.
    LogFrameTimes,
    /// Open or close the comparison of two readings of the capture.
    CompareReadings(bool),
    /// Open the capture again, under the other reading (true) or under the one of its files.
    OpenReading(bool),
    /// Copy the keys of the manifest that express the other reading.
    CopyKeys,
    Dismiss(u64),
}

impl Command {
    /// Whether it moves the live view, and nothing else.
    pub(crate) fn moves_view(&self) -> bool {
        matches!(self, Self::Orbit(_) | Self::Pan(_) | Self::Dolly(_) | Self::DollyTo { .. } | Self::Fly(_))
    }
}

/// A page of help.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HelpPage {
    Guide,
    /// What a capture is known by.
    Sources,
    Shortcuts,
    About,
}

/// Commands of one frame, in the order in which they are carried out.
pub(crate) type Commands = Vec<Command>;

/// What is typed into the palette, and which entry is chosen.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct CommandPalette {
    pub text: String,
    /// Index of the chosen entry among those that match.
    pub chosen: usize,
}
