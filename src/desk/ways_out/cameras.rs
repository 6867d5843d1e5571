//! Poses and lenses of cameras as a manifest.

use super::shared::{Action, FileKind, Needs, Size, WayOut};
use overlook_engine::plural::counted;

pub(crate) const WAY: WayOut = WayOut {
    name: "Cameras",
    used: "Pose and lens of every camera as a transforms.json, for other programs and for viewpoints of overlook render --views.",
    button: "Save the cameras…",
    command: "",
    about: "",
    kind: |_| &CAMERAS,
    size: |scope, _| Size::about(scope.cameras as f64 * CAMERA, counted(scope.cameras, "camera")),
    write: None,
};

/// The poses and lenses of all cameras.
pub(crate) const CAMERAS: FileKind = FileKind {
    action: Action::Save,
    needs: Needs::Scene,
    ..FileKind::of_samples("Share the cameras", &["json"], "cameras")
};

/// Bytes of a camera in a manifest.
const CAMERA: f64 = 850.0;
