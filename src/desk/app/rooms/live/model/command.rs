//! What can be done in the live view.

use glam::{DVec2, DVec3};

use super::picture::{ColorBy, HoleDisplay};
use super::pose::ViewAngles;
use super::view_look::{Guides, Unit};

/// What can be done to the live view's camera and to what surrounds its picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ViewCommand {
    /// Horizontal, radians.
    AngleOfView(f64),
    /// World space.
    Position(DVec3),
    Angles(ViewAngles),
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
    /// What concerns views that are kept.
    Kept(KeptViewCommand),
    /// Ask the system for what was copied.
    Paste,
    /// Take what was copied.
    Pasted(String),
    Guides(Guides),
    FlySpeed(f64),
    Unit(Unit),
    /// Let a direction of world space be up; `None` takes the one of the capture.
    Up(Option<DVec3>),
    /// Show where it is chosen which way is up.
    FindUp,
    /// Show or leave out the samples of a camera.
    CameraOn(usize, bool),
    /// Show the samples of one camera alone; of all that are on by `None`.
    Solo(Option<usize>),
    AllCameras(bool),
    /// Whether clicks pick points to measure between.
    Measure(bool),
    /// World space.
    PickPoint(DVec3),
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
    Size([u32; 2]),
    /// The area of the live view and its legend in the window, points.
    Area(egui::Rect),
    CopyPicture,
    /// Center the live view on the selected pixel.
    FramePoint,
    /// Center the live view on a point in world space, and orbit about it.
    Focus(DVec3),
}

/// What can be done with views that are kept, by their index in the list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum KeptViewCommand {
    /// Put the view into the list of those that are kept.
    Keep,
    /// Go to a kept view, by its place in the list.
    GoTo(usize),
    Rename(usize, String),
    Remove(usize),
}

impl ViewCommand {
    /// Whether it moves the view by hand, and nothing else.
    pub(crate) fn moves_view(&self) -> bool {
        matches!(self, Self::Orbit(_) | Self::Pan(_) | Self::Dolly(_) | Self::DollyTo { .. } | Self::Fly(_))
    }
}
