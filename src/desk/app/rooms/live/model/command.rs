//! What can be done in the live view.

use glam::{DVec2, DVec3};

use super::look::LiveLook;
use super::orbit_camera::OrbitCamera;
use super::picture::HoleDisplay;

/// What can be done to the live view's camera and to what surrounds its picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ViewCommand {
    /// Take another camera, whose numbers were changed.
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
    /// What concerns views that are kept.
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
    Holes(HoleDisplay),
    Size([u32; 2]),
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
    /// The command that lets the view look as a change makes it.
    pub(crate) fn look(look: &LiveLook, change: impl FnOnce(&mut LiveLook)) -> Self {
        let mut look = Box::new(look.clone());
        change(&mut look);
        Self::Look(look)
    }

    /// The command that takes a camera as a change makes it.
    pub(crate) fn camera(camera: &OrbitCamera, change: impl FnOnce(&mut OrbitCamera)) -> Self {
        let mut camera = Box::new(camera.clone());
        change(&mut camera);
        Self::Camera(camera)
    }

    /// Whether it moves the view by hand, and nothing else.
    pub(crate) fn moves_view(&self) -> bool {
        matches!(self, Self::Orbit(_) | Self::Pan(_) | Self::Dolly(_) | Self::DollyTo { .. } | Self::Fly(_))
    }
}
