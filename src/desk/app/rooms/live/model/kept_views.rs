//! Views that somebody keeps to come back to: where from and when, and a name; and small pictures of views.

use egui::TextureHandle;

use super::orbit_camera::OrbitCamera;
use crate::address::ViewAddress;
use crate::app::model::state::State;

/// A view that is kept.
pub(crate) struct KeptView {
    pub name: String,
    pub view: ViewAddress,
}

/// What views showed, small: of kept views, and of the keys of the camera path. A view has a picture once it was painted.
#[derive(Default)]
pub(crate) struct ViewPictures(Vec<(ViewAddress, TextureHandle)>);

impl ViewPictures {
    /// The picture of a view.
    pub(crate) fn of(&self, view: &ViewAddress) -> Option<&TextureHandle> {
        self.0.iter().find(|(known, _)| known == view).map(|(_, picture)| picture)
    }

    /// Takes the picture of a view; of views that are not `wanted` none stays.
    pub(crate) fn keep(&mut self, view: ViewAddress, picture: TextureHandle, wanted: &[ViewAddress]) {
        self.0.retain(|(known, _)| *known != view && wanted.contains(known));
        self.0.push((view, picture));
    }
}

impl State {
    /// The address of a view at a frame, without the scene's; `None` while nothing is open.
    pub(crate) fn address_of(&self, orbit: &OrbitCamera, frame: usize) -> Option<ViewAddress> {
        let scene = self.doc.scene.as_ref()?;
        let frame_number = scene.frame_numbers.get(frame).copied().unwrap_or_default();
        let lenses = [orbit.lens, scene.cameras.first()?.intrinsics];
        Some(ViewAddress::of(&orbit.world_from_camera, orbit.pivot_distance, lenses, frame_number))
    }

    /// The views that have small pictures: those that are kept, and the keys of the camera path.
    pub(crate) fn pictured_views(&self) -> Vec<ViewAddress> {
        let kept = self.doc.kept_views.iter().map(|kept| kept.view.clone());
        let keys = self.doc.path.keys.iter();
        kept.chain(keys.filter_map(|key| self.address_of(&key.orbit, key.frame))).collect()
    }
}

/// The name of the next view: its number, the first that none has.
pub(crate) fn next_name(kept: &[KeptView]) -> String {
    let mut names = (1..).map(|number| format!("View {number}"));
    names.find(|name| kept.iter().all(|known| known.name != *name)).unwrap_or_default()
}
