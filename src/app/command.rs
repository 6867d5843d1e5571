//! Everything a person can ask for. Panels send these; `update` carries them out.

use std::path::PathBuf;

use glam::{DVec2, DVec3};

use super::message::Purpose;
use super::state::Sidebar;
use super::views::live_image::ColorBy;
use super::views::source_image::Overlay;

/// One wish of the person at the window.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Command {
    /// Open a built-in scene by name.
    OpenDemo(String),
    /// Open a capture or a store.
    OpenPath(PathBuf),
    /// Ask for a path by the system's dialog.
    AskPath(Purpose),
    /// Show the field for typing a path.
    TypePath(Purpose),
    /// What is in the field now.
    TypedPath(String),
    /// Take the path in the field.
    TakeTypedPath,
    /// Close the field.
    CloseTypedPath,
    /// Forget the recent files.
    ForgetRecent,
    /// Change a setting.
    Set { path: &'static str, value: toml::Value },
    /// Give a setting its default.
    Reset(&'static str),
    /// Give all settings their defaults.
    ResetAll,
    /// Prune the whole capture again.
    Rerun,
    /// Stop the long work.
    Cancel,
    /// Close the topmost thing: a field, a message; else stop the long work.
    Escape,
    /// Go to a frame.
    Frame(usize),
    /// Go some frames on or back, around the ends.
    Step(i64),
    /// Play or pause.
    TogglePlay,
    /// Frames per second of playback.
    FramesPerSecond(f32),
    /// Show another camera on the left.
    SourceCamera(usize),
    /// Show something else on the left.
    Overlay(Overlay),
    /// Compare sampling rates with this camera, or the best other.
    Against(Option<usize>),
    /// Zoom and shift of the left picture.
    SourceZoom { zoom: f32, center: egui::Vec2 },
    /// Orbit by angles in radians.
    Orbit(DVec2),
    /// Shift the right view by shares of its height.
    Pan(DVec2),
    /// Nearer (below 1) or farther.
    Dolly(f64),
    /// Fly right, down, forward, in pivot distances.
    Fly(DVec3),
    /// Look from where a camera stood.
    JumpTo(usize),
    /// Back to the first vantage, and the left picture back to fit.
    Home,
    /// What colors on the right tell.
    ColorBy(ColorBy),
    /// Whether the cameras are drawn on the right.
    ShowCameras(bool),
    /// Size of the right view in pixels.
    LiveSize([u32; 2]),
    /// Dark or light.
    Dark(bool),
    /// What the side panel shows.
    Sidebar(Sidebar),
    /// Close a message.
    Dismiss(u64),
}
