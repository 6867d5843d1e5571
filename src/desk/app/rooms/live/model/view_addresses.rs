//! The addresses of views of the open scene.

use super::orbit_camera::OrbitCamera;
use crate::address::ViewAddress;
use crate::app::model::state::State;

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
